// A demo: a scene that tells a story and checks its own outcome against physics.
#pragma once

#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "replay/recorder.h"
#include "scene/scene.h"
#include "scene/simulation.h"

namespace cloudcontact::program {

struct Drawing;  // draw/drawing.h

// What a demo runs on: its worlds run here one after the other, with progress shown; where a replay
// is wanted they are watched, and stand side by side in it.
class DemoStage {
 public:
  explicit DemoStage(bool replay, bool pictures = false) : watched_(replay), pictured_(pictures) {}

  // `label` tells this run from the demo's others.
  SimulationReport run(const SceneDescription& scene, const WorldSettings& settings,
                       const SimulationSettings& simulation, const std::string& label);
  // What a demo without worlds shows by itself: a replay's takes, and pictures by their name.
  bool watched() const { return watched_; }
  bool pictured() const { return pictured_; }
  void addTakes(std::vector<ReplayTake> takes, double seconds, const std::string& setup,
                double voxel);
  void addPicture(const std::string& name, std::shared_ptr<const Drawing> drawing);
  using Pictures = std::vector<std::pair<std::string, std::shared_ptr<const Drawing>>>;
  const Pictures& pictures() const { return pictures_; }

  // The takes and how they were set up; the rest is the caller's.
  Replay replay();

 private:
  bool watched_, pictured_;
  Recorder recorder_;
  std::set<std::string> setups_;  // of the runs, in words
  double voxel_ = 0, seconds_ = 0;
  std::vector<ReplayTake> takes_;  // of a demo without worlds
  Pictures pictures_;
};

struct Demo {
  const char* name;
  const char* title;
  const char* story;  // what is shown
  const char* watch;  // what to look for
  std::vector<ReplayCheck> (*run)(DemoStage&);
  bool draws = false;  // pictures
};

const std::vector<Demo>& demos();

std::vector<ReplayCheck> runNutBolt(DemoStage& stage);
std::vector<ReplayCheck> runPegHole(DemoStage& stage);
std::vector<ReplayCheck> runStack(DemoStage& stage);
std::vector<ReplayCheck> runChain(DemoStage& stage);
std::vector<ReplayCheck> runDrill(DemoStage& stage);
std::vector<ReplayCheck> runScalpel(DemoStage& stage);

// How a body of a demo is made and what its surface is like.
struct DemoMatter {
  double mass = 0;  // [kg], 0: static
  double friction = 0;
  std::optional<double> stiffness, damping;
};
// A body of one mesh; bodies of one `kind` must have the same mesh.
SceneBody demoBody(const std::string& name, const std::string& kind,
                   std::shared_ptr<const Mesh> mesh, const Pose& pose, const DemoMatter& matter);
SceneBody demoFloor(double friction);

// A world of clouds with the given voxel, or of Bullet's own primitives.
WorldSettings demoSettings(double voxel, Method method = Method::Cloud);

// "12.3 mm" from metres, and so on: `digits` after the point.
std::string figure(double value, int digits, const char* unit = "");

}  // namespace cloudcontact::program
