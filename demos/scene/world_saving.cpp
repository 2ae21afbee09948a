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
  for (const State::Joint& joint : s.joints)
    save.joints.push_back(
        {joint.rows->places(), {joint.rows->motor(0), joint.rows->motor(1)}, joint.rows->load()});
  for (const State::Body& body : s.bodies) {
    save.loads.push_back(body.load);
    const SceneDrive drive = body.scene.drive.value_or(SceneDrive());
    save.drives.push_back({body.scene.pose, body.driveFrom, drive.linear, drive.angular});
    save.volumes.push_back(body.volume);
  }
  return save;
}

void World::restore(const WorldSave& save) {
  State& s = *state_;
  const std::size_t count = s.bodies.size();
  if (save.loads.size() != count || save.drives.size() != count || save.volumes.size() != count)
    throw BadInput("the state is of " + std::to_string(save.loads.size()) +
                   " bodies, and the world has " + std::to_string(count) +
                   "; restore one of this scene, with no piece cut off since");
  if (save.joints.size() != s.joints.size())
    throw BadInput("the state is of " + std::to_string(save.joints.size()) +
                   " joints, and the world has " + std::to_string(s.joints.size()));
  for (std::size_t i = 0; i < count; ++i)
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
  for (std::size_t i = 0; i < save.joints.size(); ++i) {
    s.joints[i].rows->setPlaces(save.joints[i].places);
    s.joints[i].rows->setLoad(save.joints[i].load);
    for (std::size_t k = 0; k < 2; ++k) s.joints[i].rows->setMotor(k, save.joints[i].motors[k]);
  }
  for (std::size_t i = 0; i < count; ++i) {
    State::Body& body = s.bodies[i];
    body.load = save.loads[i];
    if (!body.scene.drive) continue;
    const DriveStart& drive = save.drives[i];
    body.scene.pose = drive.pose, body.driveFrom = drive.time;
    body.scene.drive->linear = drive.linear, body.scene.drive->angular = drive.angular;
  }
  s.poses.clear();
}

}  // namespace cloudcontact::program
