// The contacts of the current frame: an arrow for the force of each point, a disc with its normal for each
// patch. Drawn over the bodies, because most contacts lie inside them.

const depthColors = ['#ffd75e', '#f59331', '#dc3b32', '#8f0b3a'].map(c => new THREE.Color(c).convertSRGBToLinear());
const apartColor = new THREE.Color('#7c8798').convertSRGBToLinear();

// The color of a depth on a scale from 0 to 1; gray without contact.
function depthColor(share, out) {
  if (!(share > 0)) return out.copy(apartColor);
  const at = Math.min(0.9999, share) * (depthColors.length - 1);
  return out.copy(depthColors[Math.floor(at)]).lerp(depthColors[Math.floor(at) + 1], at % 1);
}

// The record's integers as N and m (page_record.h).
const forceOf = (contacts, point) => contacts.mostForce * (contacts.pointForce[point] / 1023) ** 2;
const depthOf = (contacts, whole) => contacts.mostDepth * whole / 1023;

// Instances of a geometry, each with a transform and a color.
class Copies {
  constructor(geometry, material, parent) {
    Object.assign(this, {geometry, material, parent, most: 0, mesh: null});
    this.begin(1);
  }
  add(matrix, color) {
    this.mesh.setMatrixAt(this.mesh.count, matrix);
    color.toArray(this.colors.array, 3 * this.mesh.count);
    ++this.mesh.count;
  }
  remove() { this.parent.remove(this.mesh); }
  // Makes room for `most` copies, of which there are none yet.
  begin(most) {
    if (most > this.most) {
      this.most = Math.max(most, 2 * this.most);
      if (this.mesh) this.parent.remove(this.mesh);
      this.mesh = new THREE.InstancedMesh(this.geometry, this.material, this.most);
      this.colors = new THREE.InstancedBufferAttribute(new Float32Array(3 * this.most), 3);
      this.geometry.setAttribute('color', this.colors);
      this.mesh.frustumCulled = false;
      this.parent.add(this.mesh);
    }
    this.mesh.count = 0;
  }
  end() { this.mesh.instanceMatrix.needsUpdate = this.colors.needsUpdate = true; }
}

// Three faces from a unit circle at y = 0 to a tip at y = 1.
function spike() {
  const places = [];
  for (let i = 0; i < 3; ++i)
    for (const corner of [i + 1, i]) places.push(Math.cos(corner * 2 * Math.PI / 3), 0, Math.sin(corner * 2 * Math.PI / 3), ...(corner === i ? [0, 1, 0] : []));
  return new THREE.BufferGeometry().setAttribute('position', new THREE.BufferAttribute(new Float32Array(places), 3));
}

class ContactView {
  // `parent` has the take's frame; `scale` gives the meaning of arrows and colors.
  constructor(take, parent, scale) {
    this.take = take;
    this.scale = scale;
    this.parent = parent;
    this.make(false);
  }

  // `plain`: arrows are spikes, and nothing is lit, for a machine without a GPU. With 400 arrows as they are it draws 27
  // pictures a second, with spikes 36.
  make(plain) {
    this.plain = plain;
    const along = geometry => geometry.translate(0, 0.5, 0);
    const skin = more => new (plain ? THREE.MeshBasicMaterial : THREE.MeshLambertMaterial)({vertexColors: THREE.VertexColors, ...more});
    const glass = {side: THREE.DoubleSide, transparent: true, opacity: 0.62, depthWrite: false};
    const rod = sides => plain ? spike() : along(new THREE.CylinderBufferGeometry(1, 1, 1, sides));
    for (const copies of [this.shafts, this.heads, this.discs, this.pins]) if (copies) copies.remove();
    this.shafts = new Copies(rod(10), skin(), this.parent);
    this.heads = new Copies(plain ? spike() : along(new THREE.ConeBufferGeometry(1, 1, 14)), skin(), this.parent);
    this.discs = new Copies(new THREE.CircleBufferGeometry(1, plain ? 6 : 32).rotateX(-Math.PI / 2), skin(glass), this.parent);
    this.pins = new Copies(rod(6), skin(), this.parent);
  }

  place(array, i, out) {
    return out.fromArray(array, 3 * i).multiplyScalar(this.take.contacts.grid);
  }

  // Returns the number of points and patches in the frame.
  show(frame) {
    const c = this.take.contacts, all = [this.shafts, this.heads, this.discs, this.pins];
    const counts = {points: 0, patches: 0}, shown = c.shown.subarray(c.firstShown[frame], c.firstShown[frame + 1]);
    const points = shown.reduce((sum, i) => sum + c.patchCount[i], 0);
    for (const copies of all) copies.begin(Math.max(points, shown.length));
    for (const patch of shown) {
      this.addPatch(patch);
      const first = c.patchPoint[patch], end = first + c.patchCount[patch];
      for (let i = first; i < end; ++i) this.addPoint(i);
      ++counts.patches;
      counts.points += end - first;
    }
    for (const copies of all) copies.end();
    return counts;
  }

  addPoint(i) {
    const c = this.take.contacts, s = this.scale, force = forceOf(c, i);
    const length = s.length * Math.min(3, force / s.force);
    if (!(length > 0.01 * s.length)) return;
    const at = this.place(c.pointPlace, i, ContactView.at);
    ContactView.along.fromArray(c.pointDirection, 3 * i).normalize();
    const color = depthColor(depthOf(c, c.pointDepth[i]) / s.depth, ContactView.color);
    const width = 0.03 * s.length * Math.min(1, 3 * length / s.length), head = Math.min(0.28 * s.length, 0.6 * length);
    if (this.plain) return this.heads.add(this.matrix(at, ContactView.along, 2 * width, length), color);
    this.shafts.add(this.matrix(at, ContactView.along, width, length - head), color);
    at.addScaledVector(ContactView.along, length - head);
    this.heads.add(this.matrix(at, ContactView.along, 2.6 * width, head), color);
  }

  addPatch(i) {
    const c = this.take.contacts, s = this.scale;
    const at = this.place(c.patchPlace, i, ContactView.at);
    ContactView.along.fromArray(c.patchNormal, 3 * i).normalize();
    const radius = Math.max(0.12 * s.length, c.grid * c.patchRadius[i]);
    depthColor(depthOf(c, c.patchDepth[i]) / s.depth, ContactView.color);
    this.discs.add(this.matrix(at, ContactView.along, radius, 1), ContactView.color);
    this.pins.add(this.matrix(at, ContactView.along, 0.012 * s.length, 0.45 * s.length), ContactView.ink);
  }

  // Maps the unit geometry along y to `width` and `length` along a direction.
  matrix(at, along, width, length) {
    ContactView.turn.setFromUnitVectors(ContactView.up, along);
    return ContactView.whole.compose(at, ContactView.turn, ContactView.size.set(width, length, width));
  }
}
Object.assign(ContactView, {
  at: new THREE.Vector3(), along: new THREE.Vector3(), up: new THREE.Vector3(0, 1, 0), size: new THREE.Vector3(),
  turn: new THREE.Quaternion(), whole: new THREE.Matrix4(), color: new THREE.Color(),
  ink: new THREE.Color('#20242c').convertSRGBToLinear()
});
