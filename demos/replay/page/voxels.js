// A body's voxels for the contact method: cubes with their visible faces only.

const cubeFaces = [
  [[-1, 0, 0], [[0, 0, 0], [0, 0, 1], [0, 1, 1], [0, 1, 0]]],
  [[1, 0, 0], [[1, 0, 0], [1, 1, 0], [1, 1, 1], [1, 0, 1]]],
  [[0, -1, 0], [[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]]],
  [[0, 1, 0], [[0, 1, 0], [0, 1, 1], [1, 1, 1], [1, 1, 0]]],
  [[0, 0, -1], [[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 0, 0]]],
  [[0, 0, 1], [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]]
];

function voxelGeometry(shell) {
  let faces = 0;
  for (const open of shell.open) for (let f = 0; f < 6; ++f) faces += open >> f & 1;
  const positions = new Float32Array(12 * faces), normals = new Int8Array(12 * faces);
  const shades = new Uint8Array(12 * faces), corners = new Uint32Array(6 * faces);
  let at = 0;
  for (let i = 0; i < shell.open.length; ++i)
    for (let f = 0; f < 6; ++f) {
      if (!(shell.open[i] >> f & 1)) continue;
      const [normal, quad] = cubeFaces[f];
      // Full voxels have the body's color, emptier ones are darker.
      const shade = 120 + 135 * (shell.coverage[i] - 128) / 127;
      for (let k = 0; k < 4; ++k) {
        const v = 3 * (4 * at + k);
        positions[v] = shell.origin[0] + shell.edge * (shell.x[i] + quad[k][0]);
        positions[v + 1] = shell.origin[1] + shell.edge * (shell.y[i] + quad[k][1]);
        positions[v + 2] = shell.origin[2] + shell.edge * (shell.z[i] + quad[k][2]);
        for (let axis = 0; axis < 3; ++axis) {
          normals[v + axis] = 127 * normal[axis];
          shades[v + axis] = shade;
        }
      }
      corners.set([0, 1, 2, 0, 2, 3].map(c => 4 * at + c), 6 * at);
      ++at;
    }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  geometry.setAttribute('normal', new THREE.BufferAttribute(normals, 3, true));
  geometry.setAttribute('color', new THREE.BufferAttribute(shades, 3, true));
  geometry.setIndex(new THREE.BufferAttribute(corners, 1));
  return geometry;
}
