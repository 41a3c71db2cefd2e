// The mechanism in three dimensions. Lengths in mm, z along the axis out of the output.
const LOOKS = {
  housing: [0x8794a1, 0.35], pins: [0xb9c2cb, 1], disc: [0x9fb4c8, 1], shaft: [0xc7b694, 1], rollers: [0xd9dde1, 1],
  carrier: [0x7f9183, 1], gear: [0xc9a86a, 1], output_pins: [0x9aa58c, 1], output_ring: [0x7f9183, 0.35],
};
const DISCS = [0x8fb0cf, 0xb5c7a3, 0xcfb59a, 0xb8a8cc];
const SELECTED = 0x2f86d6;

function pathOf(points, Type) {
  const path = new Type();
  points.forEach(([x, y], i) => (i === 0 ? path.moveTo(x, y) : path.lineTo(x, y)));
  return path;
}

function shapeOf(outline, holes, circles) {
  const shape = pathOf(outline, THREE.Shape);
  for (const hole of holes) shape.holes.push(pathOf(hole, THREE.Path));
  for (const [x, y, radius] of circles) {
    const path = new THREE.Path();
    path.absarc(x, y, radius, 0, 2 * Math.PI, true);
    shape.holes.push(path);
  }
  return shape;
}

/// All points of a disc's flank, worn by `depths` (µm over the meshing angle) times a factor.
function flankOf(shape, depths, factor) {
  const points = [];
  const angles = [];
  for (let k = 0; k < shape.count; k += 1) {
    const [sin, cos] = [Math.sin((2 * Math.PI * k) / shape.count), Math.cos((2 * Math.PI * k) / shape.count)];
    shape.lobe.forEach(([x, y], i) => {
      const worn = (depths ? depthAt(depths, shape.meshing_angle_deg[i]) : 0) * 1e-3 * factor;
      const [px, py] = [x - worn * shape.normals[i][0], y - worn * shape.normals[i][1]];
      points.push([cos * px - sin * py, sin * px + cos * py]);
      angles.push(shape.meshing_angle_deg[i]);
    });
  }
  return { points, angles };
}

class View extends Space {
  constructor(canvas, onPick) {
    super(canvas);
    this.renderer.localClippingEnabled = true;
    this.plane = new THREE.Plane(new THREE.Vector3(0, 0, -1), 1e6);
    this.bodies = [];
    this.hidden = new Set();
    this.state = { crank: 0, magnify: 1, explode: 0, wear: null, wearFactor: 30, frame: null, most: { force: 1, pressure: 1 }, arrows: true, colour: 'pressure', cut: 'across', cutAt: 62 };
    let down = null;
    canvas.addEventListener('pointerdown', (event) => { down = [event.clientX, event.clientY]; });
    canvas.addEventListener('pointerup', (event) => {
      if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 5) onPick(this.pick(event.clientX, event.clientY));
      down = null;
    });
  }

  whole() {
    const { radius_mm: radius, length_mm: length } = this.drawn;
    return { middle: [0, 0, 0], radius: 1.04 * Math.hypot(radius, length / 2), from: [0.3, -0.52, 0.8] };
  }

  material(colour, opacity) {
    return new THREE.MeshLambertMaterial({ color: colour, side: THREE.DoubleSide, transparent: opacity < 1, opacity, depthWrite: opacity === 1, clippingPlanes: [this.plane] });
  }

  /// Shows another drive. The camera is set for the first one only.
  show(scene) {
    const first = !this.drawn;
    this.free(this.root);
    this.drawn = scene;
    this.shift = -scene.length_mm / 2;
    this.bodies = scene.bodies.map((body) => this.build(body));
    this.addArrows();
    this.ghostGroup = new THREE.Group();
    this.root.add(this.ghostGroup);
    if (this.ghostScene) this.ghost(this.ghostScene);
    if (first) this.home();
    this.flanks();
    this.update();
  }

  build(body) {
    const group = new THREE.Group();
    const [plain, opacity] = LOOKS[body.kind];
    const colour = body.kind === 'disc' ? DISCS[body.disc % DISCS.length] : plain;
    const built = { body, group, colour, meshes: [], flanks: [] };
    for (const shape of body.shapes) {
      const [low, high] = Array.isArray(shape.z) ? shape.z : [shape.z - shape.radius, shape.z + shape.radius];
      const material = this.material(colour, opacity);
      let mesh;
      if (shape.type === 'cylinders' || shape.type === 'balls' || shape.type === 'arcs') {
        const half = shape.half_angle_deg * TURN;
        const geometry = shape.type === 'balls' ? new THREE.SphereGeometry(shape.radius, 8, 5)
          // Faces towards the axis, for a pin on the x-axis; each instance is rotated to its position. Slightly in front of the contour.
          : shape.type === 'arcs' ? new THREE.CylinderGeometry(1.01 * shape.radius, 1.01 * shape.radius, high - low, 16, 1, true, -Math.PI / 2 - half, 2 * half).rotateX(Math.PI / 2)
          : new THREE.CylinderGeometry(shape.radius, shape.radius, high - low, shape.at.length > 8 ? 12 : 36).rotateX(Math.PI / 2);
        mesh = new THREE.InstancedMesh(geometry, material, shape.at.length);
        const matrix = new THREE.Matrix4();
        shape.at.forEach(([x, y], i) => {
          matrix.makeRotationZ(shape.type === 'arcs' ? Math.atan2(y, x) : 0);
          mesh.setMatrixAt(i, matrix.setPosition(x, y, (low + high) / 2));
        });
        if (body.kind === 'pins' || (body.kind === 'rollers' && body.disc !== null)) {
          material.color.set(0xffffff);
          built.instanced = mesh;
          built.at = shape.at;
        }
      } else if (shape.type === 'plate') {
        const geometry = new THREE.ExtrudeGeometry(shapeOf(shape.outline, shape.holes, shape.circles), { depth: high - low, bevelEnabled: false, curveSegments: 24 });
        mesh = new THREE.Mesh(geometry.translate(0, 0, low), material);
      } else {
        mesh = new THREE.Mesh(new THREE.BufferGeometry(), material);
        const paint = this.material(0xffffff, 1);
        paint.vertexColors = true;
        const side = new THREE.Mesh(new THREE.BufferGeometry(), paint);
        side.userData.body = built;
        built.flanks.push({ shape, solid: mesh, side });
        group.add(side);
      }
      mesh.userData.body = built;
      built.meshes.push(mesh);
      group.add(mesh);
    }
    this.root.add(group);
    return built;
  }

  /// Updates shape and colours of the worn flanks.
  flanks() {
    const { wear, wearFactor, colour } = this.state;
    const deepest = wear ? Math.max(...wear.flat(), 1e-9) : 1;
    for (const { colour: plain, shape, solid, side } of this.bodies.flatMap((b) => b.flanks.map((flank) => ({ colour: b.colour, ...flank })))) {
      const worn = (wear && wear[shape.ring]) || null;
      const { points, angles } = flankOf(shape, worn, wearFactor);
      const [low, high] = shape.z;
      const faces = new THREE.ExtrudeGeometry(shapeOf(points, shape.holes, shape.circles), { depth: high - low, bevelEnabled: false, curveSegments: 20 }).translate(0, 0, low);
      solid.geometry.dispose();
      solid.geometry = faces;
      // The coloured flank, slightly outside of the solid.
      const place = [];
      const colours = [];
      const normals = [];
      const index = [];
      const base = new THREE.Color(plain);
      points.forEach(([x, y], i) => {
        const [before, after] = [points[(i + points.length - 1) % points.length], points[(i + 1) % points.length]];
        const [tx, ty] = [after[0] - before[0], after[1] - before[1]];
        const length = Math.hypot(tx, ty) || 1;
        const [nx, ny] = [ty / length, -tx / length];
        const share = worn && colour === 'pressure' ? depthAt(worn, angles[i]) / deepest : null;
        const rgb = share === null ? [base.r, base.g, base.b] : ramp(share);
        const tone = share === null ? base : new THREE.Color().setRGB(rgb[0], rgb[1], rgb[2], 'srgb');
        for (const z of [low, high]) {
          place.push(x + 0.01 * nx, y + 0.01 * ny, z);
          normals.push(nx, ny, 0);
          colours.push(tone.r, tone.g, tone.b);
        }
        const [a, b] = [2 * i, 2 * ((i + 1) % points.length)];
        index.push(a, b, a + 1, b, b + 1, a + 1);
      });
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(place), 3));
      geometry.setAttribute('normal', new THREE.BufferAttribute(new Float32Array(normals), 3));
      geometry.setAttribute('color', new THREE.BufferAttribute(new Float32Array(colours), 3));
      geometry.setIndex(index);
      side.geometry.dispose();
      side.geometry = geometry;
    }
    this.redraw();
  }

  addArrows() {
    const count = this.drawn.rings.reduce((sum, ring) => sum + ring.pin_count * ring.flanks.length, 0);
    const material = new THREE.MeshBasicMaterial({ color: 0xd1495b, depthTest: false, transparent: true, opacity: 0.9 });
    const shaft = new THREE.CylinderGeometry(0.09, 0.09, 0.75, 8).translate(0, 0.375, 0);
    const head = new THREE.ConeGeometry(0.22, 0.25, 10).translate(0, 0.875, 0);
    this.arrows = [shaft, head].map((geometry) => {
      const mesh = new THREE.InstancedMesh(geometry, material.clone(), count);
      mesh.renderOrder = 5;
      mesh.frustumCulled = false;
      this.root.add(mesh);
      return mesh;
    });
    material.dispose();
  }

  /// Outlines of the discs of the pinned drive.
  ghost(scene) {
    this.ghostScene = scene;
    if (!this.ghostGroup) return;
    this.free(this.ghostGroup);
    if (scene) {
      const flanks = scene.bodies.flatMap((body) => body.shapes.filter((shape) => shape.type === 'lobes').map((shape) => ({ body, shape })));
      for (const { body, shape } of flanks) {
        const { points } = flankOf(shape, null, 0);
        const place = [];
        points.forEach(([x, y], i) => {
          const [x1, y1] = points[(i + 1) % points.length];
          place.push(x, y, shape.z[1] + 0.05, x1, y1, shape.z[1] + 0.05);
        });
        const geometry = new THREE.BufferGeometry().setAttribute('position', new THREE.BufferAttribute(new Float32Array(place), 3));
        const lines = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: 0xc2459a, depthTest: false }));
        lines.renderOrder = 6;
        lines.userData.motion = body.motion;
        this.ghostGroup.add(lines);
      }
    }
    this.update();
  }

  set(change) {
    const redo = ['wear', 'wearFactor', 'colour'].some((name) => name in change && change[name] !== this.state[name]);
    Object.assign(this.state, change);
    if (!this.drawn) return;
    if (redo) this.flanks();
    this.update();
  }

  hide(kind, is) {
    if (is) this.hidden.add(kind); else this.hidden.delete(kind);
    if (this.drawn) this.update();
  }

  select(id) {
    this.selected = id;
    if (this.drawn) this.update();
  }

  /// Moves all bodies and arrows to the present crank angle.
  update() {
    const { crank, magnify, explode, frame, cut, cutAt } = this.state;
    const { drawn } = this;
    const extra = frame && magnify > 1 && typeof frame.te === 'number' ? (frame.te / 60) * TURN * (magnify - 1) : 0;
    this.root.rotation.z = drawn.frame_rate * crank * TURN;
    for (const built of this.bodies) {
      const pose = poseAt(built.body.motion, crank);
      const lag = built.body.with_output ? extra : 0;
      built.group.position.set(pose.x, pose.y, this.shift + built.body.apart_mm * (explode / 100));
      built.group.rotation.z = pose.turn + lag;
      built.group.visible = !this.hidden.has(built.body.kind);
      const colour = built.body.id === this.selected ? SELECTED : built.instanced ? 0xffffff : built.colour;
      for (const mesh of built.meshes) mesh.material.color.set(colour);
    }
    for (const lines of this.ghostGroup ? this.ghostGroup.children : []) {
      const pose = poseAt(lines.userData.motion, crank);
      lines.position.set(pose.x, pose.y, this.shift);
      lines.rotation.z = pose.turn;
    }
    const furthest = Math.max(...drawn.bodies.map((body) => Math.abs(body.apart_mm)));
    const reach = drawn.length_mm + 2 * drawn.radius_mm + furthest;
    if (cut === 'across') this.plane.set(new THREE.Vector3(0, 0, -1), -drawn.length_mm * 0.5 * 1.1 + (cutAt / 100) * drawn.length_mm * 1.1 + (explode / 100) * 2.3 * furthest);
    else if (cut === 'along') this.plane.set(new THREE.Vector3(0, 1, 0), drawn.radius_mm * (1 - cutAt / 50));
    else this.plane.set(new THREE.Vector3(0, 0, -1), 10 * reach);
    this.loads();
    this.redraw();
  }

  loads() {
    const { frame, most, arrows, colour, crank } = this.state;
    const { rings, radius_mm: radius } = this.drawn;
    const contacts = frame ? frame.contacts : [];
    const matrix = new THREE.Matrix4();
    const up = new THREE.Vector3(0, 1, 0);
    const turn = new THREE.Quaternion();
    let count = 0;
    const places = new Map(this.bodies.map((built) => [built.body.id, built.group.position.z]));
    for (const { ring, disc, pin, force } of contacts) {
      const press = pressOf(rings[ring], disc, pin, crank);
      const length = 0.34 * radius * (force / (most.force || 1));
      const width = 0.07 * radius;
      turn.setFromUnitVectors(up, new THREE.Vector3(press.dx, press.dy, 0));
      const { body, middle_mm: middle } = rings[ring].flanks[disc];
      matrix.compose(new THREE.Vector3(press.x, press.y, middle + places.get(body)), turn, new THREE.Vector3(width, length, width));
      this.arrows.forEach((mesh) => mesh.setMatrixAt(count, matrix));
      count += 1;
    }
    for (const mesh of this.arrows) {
      mesh.count = count;
      mesh.visible = arrows && count > 0;
      mesh.instanceMatrix.needsUpdate = true;
    }
    const tone = new THREE.Color();
    const rollers = (frame && frame.rollers) || [];
    for (const { body, group, at, instanced } of this.bodies.filter((b) => b.instanced)) {
      const plain = new THREE.Color(LOOKS[body.kind][0]);
      const [shares, whole] = body.kind === 'pins' ? [pressuresOn(body, instanced.count, contacts), most.pressure]
        : [rollerForcesOn(body, at, rollers, group.rotation.z, rings[body.ring].rate * crank * TURN), most.roller];
      shares.forEach((share, i) => {
        if (colour === 'pressure' && share > 0) {
          const [r, g, b] = ramp(share / (whole || 1));
          instanced.setColorAt(i, tone.setRGB(r, g, b, 'srgb'));
        } else instanced.setColorAt(i, plain);
      });
      instanced.instanceColor.needsUpdate = true;
    }
  }

  /// The body at a position of the window, and the number of its part if it consists of equal parts.
  pick(clientX, clientY) {
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(((clientX - box.left) / box.width) * 2 - 1, 1 - ((clientY - box.top) / box.height) * 2);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    const solid = this.bodies.filter((b) => b.group.visible).map((b) => b.group);
    const hit = ray.intersectObjects(solid, true).find((one) => this.plane.distanceToPoint(one.point) >= 0
      && LOOKS[one.object.userData.body.body.kind][1] === 1);
    return hit ? { body: hit.object.userData.body.body, index: hit.instanceId } : null;
  }
}
