// The hand in a live view: drags bodies by a spring that the simulation computes, and cuts away balls of matter.

// Why a body cannot be dragged, or cut; empty where it can.
function refusal({name, fixed, mass, cuttable, pullable}, carves) {
  if (carves) return cuttable ? '' : '\'' + name + '\' cannot be cut.';
  return pullable ? '' : '\'' + name + '\' is ' + (fixed ? 'fixed' : mass > 0 ? 'soft' : 'driven') + ': it cannot be dragged.';
}

class Hand {
  // `root` has the world's frame; `views` grows with the bodies; `live` sends commands (view_command.h).
  constructor(stage, root, views, live) {
    Object.assign(this, {stage, root, views, live, held: null, at: null, turned: false});
    const glass = new THREE.MeshBasicMaterial({color: 0xbe123c, transparent: true, opacity: 0.35, depthWrite: false});
    this.ball = new THREE.Mesh(new THREE.SphereBufferGeometry(1, 24, 16), glass);
    this.ball.visible = false;
    stage.overlay.add(this.ball);
    const box = document.getElementById('stage'), canvas = stage.canvas;
    // Before OrbitControls, which sees the mouse's events after these.
    canvas.addEventListener('pointerdown', event => this.down(event));
    canvas.addEventListener('pointermove', event => {
      this.at = [event.clientX, event.clientY];
      this.moved = true;
    });
    canvas.addEventListener('pointerleave', () => { if (!this.held) this.at = null; });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => this.up());
    canvas.addEventListener('mousedown', () => { this.turned = !this.held; });
    document.addEventListener('mouseup', () => { this.turned = false; });
    this.mark = what => { box.dataset.hand = what; };
  }

  get carves() { return document.getElementById('carve').getAttribute('aria-pressed') === 'true'; }
  get radius() { return 0.1 * this.stage.size * 10 ** Number(document.getElementById('carve-radius').value); }

  // What is seen at a place of the window, and may be used so.
  pick([x, y], may) {
    const meshes = new Map();
    for (const view of this.views) if (!view.body.plane) for (const mesh of view.shown()) meshes.set(mesh, view);
    const hits = this.stage.sight(x, y).intersectObjects([...meshes.keys()]);
    const hit = hits.find(({point}) => this.stage.planes.every(plane => plane.distanceToPoint(point) >= 0));
    if (!hit) return null;
    const view = meshes.get(hit.object);
    return may(view.body) ? {view, point: hit.point, body: this.views.indexOf(view)} : null;
  }

  down(event) {
    if (event.button !== 0 || this.live.ended) return;
    this.at = [event.clientX, event.clientY];
    const hit = this.pick(this.at, () => true);
    if (!hit) return;
    const why = refusal(hit.view.body, this.carves);
    if (why) return this.live.say(why, 3);
    this.stage.controls.enabled = false;
    this.stage.canvas.setPointerCapture(event.pointerId);
    this.last = null;
    this.held = {...hit, grip: hit.view.node.worldToLocal(hit.point.clone()), sent: null};
    const toward = this.stage.camera.getWorldDirection(new THREE.Vector3());
    this.held.plane = new THREE.Plane().setFromNormalAndCoplanarPoint(toward, hit.point);
    this.mark(this.carves ? 'carve' : 'held');
  }

  up() {
    this.stage.controls.enabled = true;
    if (this.held && !this.carves) this.live.ask({do: 'release'});
    this.held = null;
  }

  // Once a picture.
  tick() {
    this.ball.visible = false;
    if (this.live.ended) return this.mark('');
    if (!this.at || this.turned) return;
    if (this.carves) this.carve();
    else if (this.held) this.pull();
    else if (this.moved) this.mark(this.pick(this.at, body => body.pullable) ? 'open' : '');
    this.moved = false;
  }

  pull() {
    const to = this.stage.sight(...this.at).ray.intersectPlane(this.held.plane, new THREE.Vector3());
    if (!to) return;
    const place = this.root.worldToLocal(to).toArray(), told = place.join();
    if (told === this.held.sent) return;
    this.held.sent = told;
    this.live.ask({do: 'pull', body: this.held.body, at: this.held.grip.toArray(), to: place});
  }

  carve() {
    const hit = this.pick(this.at, body => body.cuttable);
    this.mark(hit ? 'carve' : '');
    if (!hit) return;
    this.ball.visible = this.stage.changed = true;
    this.ball.position.copy(hit.point);
    this.ball.scale.setScalar(this.radius);
    // A stroke is cut ball by ball, a third of a radius apart.
    if (!this.held || (this.last && hit.point.distanceTo(this.last) < this.radius / 3)) return;
    this.last = hit.point.clone();
    this.live.ask({do: 'cut', body: hit.body, at: hit.view.node.worldToLocal(hit.point.clone()).toArray(), radius: this.radius});
  }
}

// The springs of all hands: a line from the body to the place it is pulled to.
class PullView {
  constructor(parent, length) {
    const ink = () => new THREE.MeshBasicMaterial({vertexColors: THREE.VertexColors});
    this.width = 0.02 * length;
    this.lines = new Copies(new THREE.CylinderBufferGeometry(1, 1, 1, 8).translate(0, 0.5, 0), ink(), parent);
    this.ends = new Copies(new THREE.SphereBufferGeometry(1, 12, 8), ink(), parent);
    this.parent = parent;
    this.color = new THREE.Color('#be123c').convertSRGBToLinear();
  }

  show(pulls, views) {
    this.lines.begin(pulls.length);
    this.ends.begin(2 * pulls.length);
    const up = new THREE.Vector3(0, 1, 0), turn = new THREE.Quaternion(), whole = new THREE.Matrix4();
    for (const pull of pulls) {
      const view = views[pull.body];
      if (!view) continue;
      view.node.updateWorldMatrix(true, false);
      const from = this.parent.worldToLocal(view.node.localToWorld(new THREE.Vector3().fromArray(pull.at)));
      const to = new THREE.Vector3().fromArray(pull.to), along = to.clone().sub(from), length = along.length();
      if (length > 0) turn.setFromUnitVectors(up, along.divideScalar(length));
      this.lines.add(whole.compose(from, turn, new THREE.Vector3(this.width, length, this.width)), this.color);
      for (const end of [from, to])
        this.ends.add(whole.compose(end, turn, new THREE.Vector3().setScalar(2.2 * this.width)), this.color);
    }
    this.lines.end();
    this.ends.end();
  }
}
