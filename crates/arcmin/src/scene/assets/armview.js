// An arm in three dimensions: links, joints, commanded and reached path of the tool. Colours are those of the page.

/// A cylinder from one point to another.
function rod(from, to, radius, sides = 28) {
  const [a, b] = [new THREE.Vector3(...from), new THREE.Vector3(...to)];
  const along = b.clone().sub(a);
  const geometry = new THREE.CylinderGeometry(radius, radius, along.length(), sides);
  const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.normalize());
  return geometry.applyMatrix4(new THREE.Matrix4().makeRotationFromQuaternion(turn)).translate(...a.add(b).multiplyScalar(0.5).toArray());
}

const matrixOf = (f) => new THREE.Matrix4().set(f[0], f[1], f[2], f[9], f[3], f[4], f[5], f[10], f[6], f[7], f[8], f[11], 0, 0, 0, 1);

function solidGeometry(solid) {
  if (solid.type === 'cylinder') return rod(solid.from_mm, solid.to_mm, solid.radius_mm);
  if (solid.type === 'ball') return new THREE.SphereGeometry(solid.radius_mm, 24, 16).translate(...solid.at_mm);
  // Six faces of a unit cube, made as one plate.
  const [x, y, z] = solid.size_mm.map((size) => size / 2);
  const outline = pathOf([[-x, -y], [x, -y], [x, y], [-x, y]], THREE.Shape);
  const geometry = new THREE.ExtrudeGeometry(outline, { depth: 2 * z, bevelEnabled: false }).translate(0, 0, -z);
  return geometry.applyMatrix4(matrixOf(frameOf(solid.frame)));
}

/// A polyline with a thickness: a rod between every two points. The points may move.
class Thread {
  constructor(parent, count, radius) {
    const geometry = new THREE.CylinderGeometry(radius, radius, 1, 6, 1, true);
    this.mesh = new THREE.InstancedMesh(geometry, new THREE.MeshBasicMaterial(), Math.max(1, count));
    this.mesh.frustumCulled = false;
    parent.add(this.mesh);
  }

  through(points) {
    const [matrix, turn, up, one] = [new THREE.Matrix4(), new THREE.Quaternion(), new THREE.Vector3(0, 1, 0), new THREE.Vector3(1, 1, 1)];
    const along = new THREE.Vector3();
    const middle = new THREE.Vector3();
    let count = 0;
    for (let i = 1; i < points.length; i += 1) {
      const [a, b] = [points[i - 1], points[i]];
      along.set(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
      one.y = along.length();
      if (one.y > 0) {
        turn.setFromUnitVectors(up, along.normalize());
        this.mesh.setMatrixAt(count, matrix.compose(middle.set((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2), turn, one));
        count += 1;
      }
    }
    this.mesh.count = count;
    this.mesh.instanceMatrix.needsUpdate = true;
  }
}

class ArmView extends Space {
  /// `ball` surrounds the arm over its programs.
  show(arm, ball, moments) {
    this.free(this.root);
    this.ball = ball;
    const { radius } = ball;
    const solid = (parent, geometry) => {
      const mesh = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial());
      parent.add(mesh);
      return mesh;
    };
    this.metal = arm.base.map((one) => solid(this.root, solidGeometry(one)));
    this.joints = [];
    this.groups = arm.links.map((link) => {
      const group = new THREE.Group();
      group.matrixAutoUpdate = false;
      this.root.add(group);
      this.joints.push(solid(group, solidGeometry(link.joint)));
      this.metal.push(...link.solids.map((one) => solid(group, solidGeometry(one))));
      return group;
    });
    // Shells are transparent, so that the joints inside are visible.
    if (arm.shells) for (const { material } of this.metal) Object.assign(material, { transparent: true, opacity: 0.45, depthWrite: false });
    const step = gridStep(2 * radius);
    const reach = step * Math.max(1, Math.round((0.8 * radius) / step));
    const lines = [];
    for (let at = -reach; at <= reach; at += step) lines.push(-reach, at, 0, reach, at, 0, at, -reach, 0, at, reach, 0);
    const geometry = new THREE.BufferGeometry().setAttribute('position', new THREE.BufferAttribute(new Float32Array(lines), 3));
    this.grid = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ transparent: true, opacity: 0.35 }));
    this.root.add(this.grid);
    this.commanded = new Thread(this.root, moments, 0.003 * radius);
    this.reached = new Thread(this.root, moments, 0.005 * radius);
    this.off = new Thread(this.root, 1, 0.003 * radius);
    this.marks = [0.012, 0.016].map((share) => {
      const mesh = new THREE.Mesh(new THREE.SphereGeometry(share * radius, 16, 12), new THREE.MeshBasicMaterial());
      this.root.add(mesh);
      return mesh;
    });
    this.home();
  }

  whole() {
    return { middle: this.ball.middle, radius: 1.06 * this.ball.radius, from: [0.55, -0.75, 0.37] };
  }

  /// `links` are frames, `joints` colours, paths lists of points. Arguments that are left out change nothing.
  set({ links, joints, way, reached, now }) {
    if (links) links.forEach((frame, i) => { this.groups[i].matrix.copy(matrixOf(frame)); this.groups[i].matrixWorldNeedsUpdate = true; });
    if (joints) joints.forEach((colour, i) => this.joints[i].material.color.set(colour));
    if (way) this.commanded.through(way);
    if (reached) this.reached.through(reached);
    if (now) {
      this.off.through(now);
      now.forEach((point, i) => this.marks[i].position.set(...point));
    }
    this.redraw();
  }

  paint({ metal, grid, way, reached }) {
    for (const mesh of this.metal) mesh.material.color.set(metal);
    this.grid.material.color.set(grid);
    for (const part of [this.commanded.mesh, this.marks[0]]) part.material.color.set(way);
    for (const part of [this.reached.mesh, this.off.mesh, this.marks[1]]) part.material.color.set(reached);
    this.redraw();
  }
}
