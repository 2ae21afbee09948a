// The view: camera, light and cut. Draws only after a change.

class Stage {
  constructor(canvas, record) {
    this.canvas = canvas;
    this.record = record;
    this.renderer = new THREE.WebGLRenderer({canvas, antialias: !(record.live && Stage.isSlow())});
    this.most = 2;  // pixels a css px
    this.renderer.gammaOutput = true;
    this.renderer.gammaFactor = 2.2;
    this.renderer.localClippingEnabled = true;
    this.renderer.autoClear = false;
    this.renderer.setClearColor(0xeef0f4);
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    this.scene = new THREE.Scene();
    this.scene.fog = new THREE.Fog(0xeef0f4, 1, 2);  // for infinite planes only
    this.overlay = new THREE.Scene();  // contacts, drawn over the bodies
    this.plane = new THREE.Plane(new THREE.Vector3(0, 0, -1), 0);
    this.planes = [];  // clipping planes of the bodies' materials: `plane` while there is a cut
    this.faces = [];
    this.box = this.boxOfTakes('low', 'high');
    this.cutBox = this.boxOfTakes('startLow', 'startHigh');
    this.size = this.box.getSize(new THREE.Vector3()).length() || 1;
    this.scene.fog.near = 2.5 * this.size;
    this.scene.fog.far = 6.5 * this.size;
    this.camera = new THREE.PerspectiveCamera(32, 1, 0.01 * this.size, 40 * this.size);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.enableKeys = false;  // the arrow keys belong to the timeline
    this.addLight(this.scene, true);
    this.addLight(this.overlay, false);
    this.home();
    this.changed = true;
    this.controls.addEventListener('change', () => { this.changed = true; });
  }

  // Whether this machine draws without a GPU.
  static isSlow() {
    const gl = document.createElement('canvas').getContext('webgl'), names = gl && gl.getExtension('WEBGL_debug_renderer_info');
    return !!names && /swiftshader|llvmpipe|software|basic render/i.test(gl.getParameter(names.UNMASKED_RENDERER_WEBGL));
  }

  // Converts from the takes' frame, z up, to the viewer's, y up.
  boxOfTakes(low, high) {
    const box = new THREE.Box3();
    for (const take of this.record.takes)
      for (const corner of [take[low], take[high]])
        box.expandByPoint(new THREE.Vector3(corner[0] + take.offset[0], corner[2] + take.offset[2], -corner[1] - take.offset[1]));
    return box;
  }

  addLight(scene, shadows) {
    scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8f99, shadows ? 0.62 : 0.65));
    const sun = new THREE.DirectionalLight(0xffffff, shadows ? 0.6 : 0.45);
    const center = this.box.getCenter(new THREE.Vector3());
    sun.position.copy(center).add(new THREE.Vector3(0.5, 1.2, 0.8).multiplyScalar(this.size));
    sun.target.position.copy(center);
    scene.add(sun, sun.target);
    if (!shadows) return;
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    const reach = 0.75 * this.size;
    Object.assign(sun.shadow.camera, {left: -reach, right: reach, top: reach, bottom: -reach, near: 0.05 * this.size, far: 4 * this.size});
    sun.shadow.bias = -0.002;
  }

  // Shows all takes, from slightly above.
  home() {
    const center = this.box.getCenter(new THREE.Vector3()), half = this.box.getSize(new THREE.Vector3()).multiplyScalar(0.5);
    const aspect = Math.max(0.3, this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight));
    const wide = this.record.takes.length > 1;
    const from = new THREE.Vector3(wide ? 0.12 : 0.55, wide ? 0.28 : 0.45, 1).normalize();
    const tan = Math.tan(this.camera.fov * Math.PI / 360);
    const across = Math.hypot(half.x, wide ? 0 : half.z), upward = half.y + 0.35 * half.z;
    const distance = 1.18 * Math.max(across / (tan * aspect), upward / tan) + half.z;
    this.controls.target.copy(center);
    this.camera.position.copy(center).addScaledVector(from, distance);
    this.controls.update();
    this.changed = true;
  }

  // A square as large as the view, masked by each body's section.
  addSection(section) {
    const square = new THREE.PlaneBufferGeometry(6 * this.size, 6 * this.size), i = this.faces.length;
    section.order = 2 * i + 2;
    section.face = new THREE.Mesh(square, section.skin);
    section.face.renderOrder = 2 * i + 3;
    section.face.visible = false;
    section.face.onAfterRender = renderer => renderer.clearStencil();
    this.scene.add(section.face);
    this.faces.push(section.face);
    if (this.planes.length) this.placeFaces();
  }

  // `axis` in the takes' frame; `at` from -1 to 1 over the bounds at the start. Keeps the part below the cut
  // along x and z, and behind it along y as seen from the front; `flipped` keeps the other part.
  cut(on, axis, at, flipped) {
    const directions = {x: [1, 0, 0], y: [0, 0, -1], z: [0, 1, 0]};
    const normal = new THREE.Vector3().fromArray(directions[axis]);
    const center = this.cutBox.getCenter(new THREE.Vector3()), half = this.cutBox.getSize(new THREE.Vector3()).multiplyScalar(0.5);
    const reach = Math.abs(normal.dot(half)) || 1;
    const point = normal.dot(center) + at * reach * 1.001;
    const side = (axis === 'y') !== flipped ? 1 : -1;
    this.plane.normal.copy(normal).multiplyScalar(side);
    this.plane.constant = -side * point;
    this.planes.length = 0;
    if (on) this.planes.push(this.plane);
    this.facing = {normal, middle: center.addScaledVector(normal, point - normal.dot(center))};
    this.placeFaces();
    this.changed = true;
  }

  placeFaces() {
    for (const face of this.faces) {
      face.position.copy(this.facing.middle);
      face.lookAt(face.position.clone().add(this.facing.normal));
    }
  }

  // The line of sight through a place of the window [css px].
  sight(x, y) {
    const box = this.canvas.getBoundingClientRect(), ray = new THREE.Raycaster();
    ray.setFromCamera({x: 2 * (x - box.left) / box.width - 1, y: 1 - 2 * (y - box.top) / box.height}, this.camera);
    return ray;
  }

  // For a machine that draws too slowly, as without a GPU: without shadows, then with fewer pixels. False where
  // nothing is left to do.
  simplify() {
    if (this.most < 1) return false;
    if (this.renderer.shadowMap.enabled) {
      this.renderer.shadowMap.enabled = false;
      this.scene.traverse(thing => { if (thing.isLight) thing.castShadow = false; });
    } else {
      this.most = 0.5;
      this.resize();
    }
    this.changed = true;
    return true;
  }

  resize() {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    this.renderer.setPixelRatio(Math.min(this.most, window.devicePixelRatio || 1));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(1, height);
    this.camera.updateProjectionMatrix();
    this.changed = true;
  }

  draw() {
    if (!this.changed) return false;
    this.changed = false;
    this.renderer.clear();
    this.renderer.render(this.scene, this.camera);
    this.renderer.clearDepth();
    this.renderer.render(this.overlay, this.camera);
    return true;
  }

  // Projects a point of a take onto the canvas [css px].
  onScreen(take, place) {
    const v = new THREE.Vector3(place[0] + take.offset[0], place[2] + take.offset[2], -place[1] - take.offset[1]).project(this.camera);
    return [(v.x + 1) / 2 * this.canvas.clientWidth, (1 - v.y) / 2 * this.canvas.clientHeight];
  }
}
