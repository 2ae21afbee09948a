// Samples the glTF's animation. three.js's mixer finds nodes by name, which bodies of two takes may share.

class Motion {
  static async of(gltf) {
    const motion = new Motion();
    const json = gltf.parser.json;
    motion.tracks = [];
    for (const animation of json.animations || [])
      for (const channel of animation.channels) {
        const sampler = animation.samplers[channel.sampler];
        motion.tracks.push({
          node: await gltf.parser.getDependency('node', channel.target.node),
          path: channel.target.path,
          times: (await gltf.parser.getDependency('accessor', sampler.input)).array,
          values: (await gltf.parser.getDependency('accessor', sampler.output)).array
        });
      }
    return motion;
  }

  show(t) {
    for (const {node, path, times, values} of this.tracks) {
      const i = indexAt(times, t), j = Math.min(i + 1, times.length - 1);
      if (path === 'scale') {  // a piece of surface: there or not
        node.visible = values[3 * i] > 0;
        node.scale.set(1, 1, 1);
        continue;
      }
      const span = times[j] - times[i];
      const share = span > 0 ? Math.min(1, Math.max(0, (t - times[i]) / span)) : 0;
      if (path === 'rotation') {
        Motion.from.fromArray(values, 4 * i);
        Motion.to.fromArray(values, 4 * j);
        THREE.Quaternion.slerp(Motion.from, Motion.to, node.quaternion, share);
      } else {
        for (let axis = 0; axis < 3; ++axis)
          node.position.setComponent(axis, values[3 * i + axis] * (1 - share) + values[3 * j + axis] * share);
      }
    }
  }
}
Motion.from = new THREE.Quaternion();
Motion.to = new THREE.Quaternion();
