// States of a running world, in memory (World::save, restore).
#include "io/errors.h"
#include "scene/running_world.h"

namespace cloudcontact::program {

WorldSave World::save() const {
  State& s = *state_;
  for (const State::Body& body : s.bodies)
    if (body.soft)
      throw BadInput("body '" + body.scene.name + "': deforms; states keep rigid bodies only");
  WorldSave save;
  save.bullet = saveState(s.world, *s.cloudContact);
  save.time = s.time, save.latestStep = s.latestStep;
  save.moment = s.moment;
  for (const State::Body& body : s.bodies) {
    save.loads.push_back(body.load);
    save.volumes.push_back(body.volume);
  }
  return save;
}

void World::restore(const WorldSave& save) {
  State& s = *state_;
  if (save.loads.size() != s.bodies.size() || save.volumes.size() != s.bodies.size())
    throw BadInput("the state is of " + std::to_string(save.loads.size()) +
                   " bodies, and the world has " + std::to_string(s.bodies.size()) +
                   "; restore one of this scene, with no piece cut off since");
  for (std::size_t i = 0; i < s.bodies.size(); ++i)
    if (save.volumes[i] != s.bodies[i].volume)
      throw BadInput("body '" + s.bodies[i].scene.name +
                     "': was cut since the state was saved, and cuts do not come back");
  try {
    restoreState(s.world, *s.cloudContact, save.bullet);
  } catch (const std::exception& why) {
    throw BadInput(std::string("the state is none of this world: ") + why.what());
  }
  s.time = save.time, s.latestStep = save.latestStep;
  s.moment = save.moment;
  for (std::size_t i = 0; i < s.bodies.size(); ++i) s.bodies[i].load = save.loads[i];
  s.poses.clear();
}

}  // namespace cloudcontact::program
