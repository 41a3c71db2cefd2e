// Camera, light and input of a picture in three dimensions. Lengths in mm, z upwards.
/// Whether pictures are drawn by software, without a graphics processor.
function isSoftware() {
  const gl = document.createElement('canvas').getContext('webgl2');
  const about = gl && gl.getExtension('WEBGL_debug_renderer_info');
  return Boolean(about) && /swiftshader|llvmpipe|software/i.test(gl.getParameter(about.UNMASKED_RENDERER_WEBGL));
}

/// `whole()` of the drawn object returns its centre, its radius and the initial direction of view.
class Space {
  constructor(canvas) {
    this.canvas = canvas;
    // Without a graphics processor every sample costs time.
    const software = isSoftware();
    this.finest = software ? 1 : Math.min(window.devicePixelRatio, 2);
    this.ratio = this.finest;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !software, alpha: true, preserveDrawingBuffer: true });
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(32, 1, 1, 5000);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => this.redraw());
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x707880, 2.1));
    const sun = new THREE.DirectionalLight(0xffffff, 1.7);
    sun.position.set(0.6, -0.5, 1);
    this.camera.add(sun);
    this.scene.add(this.camera);
    this.root = new THREE.Group();
    this.scene.add(this.root);
    this.frames = 0;
    canvas.addEventListener('keydown', (event) => this.key(event));
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  resize() {
    const box = this.canvas.parentElement.getBoundingClientRect();
    if (box.width < 2) return;
    this.renderer.setPixelRatio(this.ratio);
    this.renderer.setSize(box.width, box.height, false);
    this.camera.aspect = box.width / box.height;
    this.camera.updateProjectionMatrix();
    this.redraw();
  }

  redraw() {
    // Printing needs the picture at once, not at the next frame.
    if (document.documentElement.dataset.printing) {
      this.renderer.render(this.scene, this.camera);
      return;
    }
    if (this.requested) return;
    this.requested = true;
    requestAnimationFrame(() => {
      this.requested = false;
      this.renderer.render(this.scene, this.camera);
      this.frames += 1;
      this.pace();
    });
  }

  /// A lower resolution while the picture moves faster than it can be drawn; the full resolution at rest.
  pace() {
    const now = performance.now();
    const took = now - (this.last || now);
    this.last = now;
    if (took > 0 && took < 1500) this.mean = 0.7 * (this.mean || took) + 0.3 * took;
    const target = this.mean > 45 ? Math.max(0.4, this.ratio * 0.75) : this.ratio;
    clearTimeout(this.resting);
    if (this.ratio < this.finest || target < this.ratio) {
      this.resting = setTimeout(() => { this.mean = 0; this.last = 0; this.ratio = this.finest; this.resize(); }, 500);
    }
    if (target < this.ratio) {
      this.ratio = target;
      this.mean = 0;
      this.resize();
    }
  }

  /// The wheel scrolls the page, unless the picture has the focus.
  amongText() {
    this.controls.enableZoom = false;
    this.canvas.style.touchAction = 'pan-y';
    this.canvas.addEventListener('pointerdown', () => this.canvas.focus({ preventScroll: true, focusVisible: false }));
    this.canvas.addEventListener('focus', () => { this.controls.enableZoom = true; });
    this.canvas.addEventListener('blur', () => { this.controls.enableZoom = false; });
  }

  home() {
    const { middle, radius, from } = this.whole();
    const far = radius / Math.sin((this.camera.fov / 2) * TURN) / Math.min(1, this.camera.aspect);
    this.controls.target.set(...middle);
    this.camera.position.set(...from).multiplyScalar(far).add(this.controls.target);
    this.camera.near = far / 50;
    this.camera.far = far * 4;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.redraw();
  }

  key(event) {
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    const offset = this.camera.position.clone().sub(this.controls.target);
    if (arrows && event.shiftKey) {
      const step = offset.length() * 0.03;
      const move = new THREE.Vector3(arrows[0] * step, arrows[1] * step, 0).applyQuaternion(this.camera.quaternion);
      this.camera.position.add(move);
      this.controls.target.add(move);
    } else if (arrows) {
      const flat = Math.hypot(offset.x, offset.y);
      const around = Math.atan2(offset.y, offset.x) + 0.12 * arrows[0];
      const up = Math.min(Math.max(Math.atan2(offset.z, flat) + 0.12 * arrows[1], -1.55), 1.55);
      const length = offset.length();
      this.camera.position.copy(this.controls.target).add(new THREE.Vector3(Math.cos(up) * Math.cos(around), Math.cos(up) * Math.sin(around), Math.sin(up)).multiplyScalar(length));
    } else if (event.key === '+' || event.key === '=') this.camera.position.copy(this.controls.target).addScaledVector(offset, 0.9);
    else if (event.key === '-') this.camera.position.copy(this.controls.target).addScaledVector(offset, 1.1);
    else if (event.key === 'Home') this.home();
    else return;
    event.preventDefault();
    this.controls.update();
    this.redraw();
  }

  free(group) {
    group.traverse((part) => { if (part.geometry) part.geometry.dispose(); if (part.material) part.material.dispose(); });
    group.clear();
  }
}
