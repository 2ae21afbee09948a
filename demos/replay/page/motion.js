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
          turns: channel.target.path === 'rotation',
          times: (await gltf.parser.getDependency('accessor', sampler.input)).array,
          values: (await gltf.parser.getDependency('accessor', sampler.output)).array
        });
      }
    return motion;
  }

  show(t) {
    for (const {node, turns, times, values} of this.tracks) {
      const i = indexAt(times, t), j = Math.min(i + 1, times.length - 1);
      const span = times[j] - times[i];
      const share = span > 0 ? Math.min(1, Math.max(0, (t - times[i]) / span)) : 0;
      if (turns) {
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
