// The bodies of all takes: solid, faded or hidden; as meshes or as voxels; whole or cut open.

const showStates = ['solid', 'faded', 'hidden'];

// The section face of a cut, where the plane is inside a closed surface: beyond the plane a line of sight
// crosses more back faces than front faces. The stencil buffer counts them.
class Section {
  constructor(color, planes) {
    const counting = (side, step) => new THREE.MeshBasicMaterial({
      side, clippingPlanes: planes, colorWrite: false, depthWrite: false, depthTest: false, stencilWrite: true,
      stencilFunc: THREE.AlwaysStencilFunc, stencilFail: step, stencilZFail: step, stencilZPass: step
    });
    this.counters = [
      counting(THREE.BackSide, THREE.IncrementWrapStencilOp), counting(THREE.FrontSide, THREE.DecrementWrapStencilOp)
    ];
    this.skin = new THREE.MeshBasicMaterial({
      color: color.clone().multiplyScalar(0.62), fog: false, side: THREE.DoubleSide, stencilWrite: true, stencilRef: 0,
      stencilFunc: THREE.NotEqualStencilFunc, stencilFail: THREE.ReplaceStencilOp, stencilZFail: THREE.ReplaceStencilOp,
      stencilZPass: THREE.ReplaceStencilOp
    });
    this.shown = [];
    this.face = null;  // placed by the stage
  }

  show(meshes) {
    for (const {parent, copy} of this.shown) parent.remove(copy);
    this.shown = [];
    for (const parent of meshes)
      for (const counter of this.counters) {
        const copy = new THREE.Mesh(parent.geometry, counter);
        copy.renderOrder = this.order;
        parent.add(copy);
        this.shown.push({parent, copy});
      }
    if (this.face) this.face.visible = meshes.length > 0;
  }
}

// Seven numbers of an array from `at` on, x y z qx qy qz qw, as the place of an object.
function placeAt(object, numbers, at) {
  object.position.fromArray(numbers, at);
  object.quaternion.fromArray(numbers, at + 3);
}

class BodyView {
  // `node` is the body's node of the glTF, moved by Motion.
  constructor(body, node, planes) {
    this.body = body;
    this.node = node;
    this.state = 'solid';
    this.asVoxels = false;
    this.meshes = [];
    node.traverse(child => { if (child.isMesh) this.meshes.push(child); });
    const color = new THREE.Color(body.color).convertSRGBToLinear();
    const clip = body.plane ? [] : planes;
    this.skin = new THREE.MeshStandardMaterial({
      color, roughness: body.plane ? 1 : 0.55, metalness: body.plane ? 0 : 0.1, clippingPlanes: clip, clipShadows: true, fog: body.plane
    });
    this.voxelSkin = new THREE.MeshLambertMaterial({color, vertexColors: THREE.VertexColors, clippingPlanes: clip, fog: false});
    for (const mesh of this.meshes) {
      mesh.material = this.skin;
      mesh.receiveShadow = true;
    }
    this.voxelMeshes = [];
    this.section = new Section(color, planes);
  }

  // A skin that is lit at its vertices alone, or not at all; show() must follow.
  simplify() {
    const {color, clippingPlanes, fog} = this.skin, Skin = this.body.plane ? THREE.MeshBasicMaterial : THREE.MeshLambertMaterial;
    this.skin = new Skin({color, clippingPlanes, fog});
    for (const mesh of this.meshes) mesh.material = this.skin;
  }

  // The meshes that are seen, unless it is hidden.
  shown() { return this.state === 'hidden' ? [] : this.asVoxels ? this.voxelMeshes : this.meshes; }

  // Of a body that is cut or deforms: its surface as it is now; show() must follow.
  renew({mass, gone, positions, normals, corners, place}) {
    this.body.masses = [[0, gone ? null : mass]];
    this.section.show([]);
    for (const mesh of this.meshes) {
      mesh.parent.remove(mesh);
      mesh.geometry.dispose();
    }
    this.meshes = [];
    if (!corners.length) return;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute('normal', new THREE.BufferAttribute(normals, 3, true));
    geometry.setIndex(new THREE.BufferAttribute(corners, 1));
    const mesh = new THREE.Mesh(geometry, this.skin);
    placeAt(mesh, place, 0);
    mesh.receiveShadow = true;
    this.node.add(mesh);
    this.meshes.push(mesh);
  }

  makeVoxels(shells) {
    for (const cloud of this.body.clouds) {
      const shell = shells[cloud.shell];
      shell.geometry = shell.geometry || voxelGeometry(shell);
      const mesh = new THREE.Mesh(shell.geometry, this.voxelSkin);
      mesh.position.fromArray(cloud.position);
      mesh.quaternion.fromArray(cloud.orientation);
      mesh.castShadow = mesh.receiveShadow = true;
      this.node.add(mesh);
      this.voxelMeshes.push(mesh);
    }
  }

  show(state, asVoxels, cut, shells) {
    this.state = state;
    this.asVoxels = asVoxels && this.body.clouds.length > 0;
    if (this.asVoxels && !this.voxelMeshes.length) this.makeVoxels(shells);
    const faded = state === 'faded';
    for (const skin of [this.skin, this.voxelSkin]) {
      skin.transparent = faded;
      skin.opacity = faded ? 0.28 : 1;
      skin.depthWrite = !faded;
      skin.needsUpdate = true;
    }
    for (const mesh of this.meshes) mesh.visible = state !== 'hidden' && !this.asVoxels;
    for (const mesh of this.voxelMeshes) mesh.visible = state !== 'hidden' && this.asVoxels;
    for (const mesh of this.meshes.concat(this.voxelMeshes)) mesh.castShadow = state === 'solid' && !this.body.plane;
    const cutOpen = cut && state === 'solid' && !this.body.plane;
    this.section.show(cutOpen ? (this.asVoxels ? this.voxelMeshes : this.meshes) : []);
  }
}
