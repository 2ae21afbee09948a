// The bodies of all takes: solid, faded or hidden; as meshes or as voxels; whole or cut open.

const showStates = ['solid', 'faded', 'hidden'];

class BodyView {
  // `node` is the glTF's, which the motion moves.
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
      color, roughness: body.plane ? 1 : 0.55, metalness: body.plane ? 0 : 0.1, clippingPlanes: clip, clipShadows: true
    });
    this.voxelSkin = new THREE.MeshLambertMaterial({color, vertexColors: THREE.VertexColors, clippingPlanes: clip});
    // Where a cut opens a closed surface one sees its inner side: painted flat, that is the section.
    this.section = new THREE.MeshBasicMaterial({
      color: color.clone().lerp(new THREE.Color(0x2a1520), 0.45), side: THREE.BackSide, clippingPlanes: clip
    });
    this.inner = [];
    for (const mesh of this.meshes.slice()) {
      mesh.material = this.skin;
      mesh.castShadow = !body.plane;
      mesh.receiveShadow = true;
      if (!body.plane) this.inner.push(this.addInner(mesh));
    }
    this.voxelMeshes = [];
  }

  addInner(mesh) {
    const inner = new THREE.Mesh(mesh.geometry, this.section);
    inner.visible = false;
    mesh.add(inner);
    return inner;
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
      this.inner.push(this.addInner(mesh));
    }
  }

  show(state, asVoxels, cut, shells) {
    this.state = state;
    this.asVoxels = asVoxels && this.body.clouds.length > 0;
    if (this.asVoxels && !this.voxelMeshes.length) this.makeVoxels(shells);
    const faded = state === 'faded';
    for (const skin of [this.skin, this.voxelSkin, this.section]) {
      skin.transparent = faded;
      skin.opacity = faded ? 0.28 : 1;
      skin.depthWrite = !faded;
      skin.needsUpdate = true;
    }
    for (const mesh of this.meshes) mesh.visible = state !== 'hidden' && !this.asVoxels;
    for (const mesh of this.voxelMeshes) mesh.visible = state !== 'hidden' && this.asVoxels;
    for (const mesh of this.meshes.concat(this.voxelMeshes)) mesh.castShadow = state === 'solid' && !this.body.plane;
    for (const mesh of this.inner) mesh.visible = cut && !faded;
  }
}
