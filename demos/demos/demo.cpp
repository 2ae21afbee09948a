// The list of demos, the stage they run on, and what their scenes share.
#include "demos/demo.h"

#include <algorithm>
#include <iomanip>
#include <sstream>

#include "io/progress.h"

namespace cloudcontact::program {

const std::vector<Demo>& demos() {
  static const std::vector<Demo> all = {
      {"nut_bolt", "An M16 nut on its bolt",
       "The same nut and bolt twice: at friction 0.01, below the slope of the thread, and at 0.3, "
       "above it.",
       "On the left the nut turns down under its own weight, 2 mm per turn; on the right it stays "
       "in place. Cut the bodies open to see the flanks press.",
       runNutBolt},
      {"peg_hole", "An 8 mm peg in a hole 0.1 mm wider",
       "The peg starts tilted and off the axis, at the mouth of the hole.",
       "The wall straightens it; it slides down without jamming and comes to rest on the "
       "floor. Cut the bodies open to see it inside.",
       runPegHole},
      {"arm", "An arm of six joints puts a peg into a hole",
       "The arm of a URDF file holds an 8 mm peg and believes the hole, 0.1 mm wider, up to half a "
       "millimeter and two degrees from where it is. Its joints push as springs at the peg's end "
       "would.",
       "The chamfers and the walls turn the peg into its hole, from 50 random beliefs. With "
       "--pictures DIR: the wrench at the flange over time.",
       runArm, true, false, true},
      {"stack", "Ten boxes on top of each other",
       "Ten boxes of a tonne each, five times: clouds at 240 and 60 steps a second, with a "
       "given stiffness and without, and Bullet's own boxes at 60.",
       "All stacks of clouds stand for a minute, without sleeping; the stack of Bullet's own boxes "
       "tips over.",
       runStack},
      {"chain", "Ten links of a chain",
       "Ten links hang from the first, which is fixed. Each carries all links below it.",
       "They hang still. Force and depth grow from link to link upward.", runChain},
      {"drill", "A bur opens a tooth",
       "A ball bur in a simulated hand drills through enamel into the caries below, down to just "
       "above the pulp, and clears a cavity along the fissure.",
       "The force falls as the bur leaves enamel. With --pictures DIR: the force over time by "
       "tissue, and the opened tooth.",
       runDrill, true, true},
      {"scalpel", "A blade slits skin",
       "A thin blade that cuts with its rim is drawn through skin and the muscle below.",
       "The slit stays open behind the blade. With --pictures DIR: the force over time, and the "
       "cut slab.",
       runScalpel, true, true}};
  return all;
}

SimulationReport DemoStage::run(const SceneDescription& scene, const WorldSettings& settings,
                                const SimulationSettings& simulation, const std::string& label) {
  if (shortened_) return runShort(scene, settings, simulation, label);
  World world(scene, settings);
  setups_.insert(setupText(settings, simulation.step, simulation.substeps));
  if (usesClouds(settings.common.method)) voxel_ = std::max(voxel_, settings.voxel);
  if (wantsReplay_) recorder_.begin(world, label, simulation.seconds, simulation.step);
  const auto progress =
      progressBar("simulating " + scene.name + (label.empty() ? "" : " (" + label + ")"));
  SimulationSettings watched = simulation;
  watched.observe = [&](double time, const World& now) {
    if (simulation.observe) simulation.observe(time, now);
    if (wantsReplay_) recorder_.record(time, now);
    if (progress) progress(std::min(1.0, time / simulation.seconds));
  };
  const SimulationReport report = simulate(world, watched);
  if (progress) progress(1);  // in case rounding leaves the last time below 1
  return report;
}

SimulationReport DemoStage::runShort(const SceneDescription& scene, const WorldSettings& settings,
                                     const SimulationSettings& simulation,
                                     const std::string& label) {
  const bool told = usesClouds(settings.common.method);
  WorldSettings own = settings;
  if (told) shortened_->adjust(own);
  World world(scene, own);
  const SimulationReport report =
      simulateShort(world, simulation, told ? shortened_->steps : 1, shortened_->seconds);
  if (told) shortened_->done(label, report);
  return report;
}

void DemoStage::addTakes(std::vector<ReplayTake> takes, double seconds, const std::string& setup,
                         double voxel) {
  for (ReplayTake& take : takes) takes_.push_back(std::move(take));
  seconds_ = std::max(seconds_, seconds);
  setups_.insert(setup);
  voxel_ = std::max(voxel_, voxel);
}

void DemoStage::addPicture(const std::string& name, std::shared_ptr<const Drawing> drawing) {
  pictures_.emplace_back(name, std::move(drawing));
}

Replay DemoStage::replay() {
  Replay replay = recorder_.finish();
  for (ReplayTake& take : takes_) replay.takes.push_back(std::move(take));
  replay.seconds = std::max(replay.seconds, seconds_);
  if (setups_.size() == 1) replay.setup = *setups_.begin();  // otherwise the labels name the set-up
  replay.voxel = voxel_;
  return replay;
}

SceneBody demoBody(const std::string& name, const std::string& kind,
                   std::shared_ptr<const Mesh> mesh, const Pose& pose, const DemoMatter& matter) {
  SceneBody body;
  body.name = name;
  body.pose = pose;
  body.isStatic = matter.mass == 0;
  if (matter.mass > 0) body.mass = matter.mass;
  body.friction = matter.friction;
  body.stiffness = matter.stiffness;
  body.damping = matter.damping;
  body.collisions.push_back({kind, Pose(), SceneMesh{kind, Vec3::Ones(), std::move(mesh)}});
  return body;
}

SceneBody demoFloor(double friction) {
  SceneBody body;
  body.name = "floor";
  body.isStatic = true;
  body.friction = friction;
  body.collisions.push_back({"floor", Pose(), ScenePlane{}});
  return body;
}

WorldSettings demoSettings(double voxel, Method method) {
  WorldSettings settings;
  settings.common.method = method;
  settings.voxel = voxel;
  return settings;
}

std::string figure(double value, int digits, const char* unit) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(digits) << value;
  if (*unit) out << ' ' << unit;
  return out.str();
}

}  // namespace cloudcontact::program
