// A demo: a scene that tells a story and checks its own outcome against physics.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "replay/recorder.h"
#include "scene/scene.h"
#include "scene/simulation.h"

namespace cloudcontact::program {

struct Drawing;  // draw/drawing.h

// Runs a demo's worlds one after the other with a progress bar, and records them side by side if a
// replay is wanted.
class DemoStage {
 public:
  explicit DemoStage(bool replay, bool pictures = false)
      : wantsReplay_(replay), wantsPictures_(pictures) {}

  // `label` distinguishes the runs of a demo.
  SimulationReport run(const SceneDescription& scene, const WorldSettings& settings,
                       const SimulationSettings& simulation, const std::string& label);
  // For counts and times: runs with clouds use the settings that `adjust` changes, stop early, and
  // pass their report to `done`. The demo's own checks do not apply to such a run.
  struct Shortened {
    int steps = 0;
    double seconds = 1e9;  // of wall time
    std::function<void(WorldSettings&)> adjust;
    std::function<void(const std::string& label, const SimulationReport&)> done;
  };
  void shorten(Shortened how) { shortened_ = std::move(how); }
  bool isShort() const { return shortened_.has_value(); }
  // Scenes of robots, where the program reads such files (robotOf() in scene/scene_file.h).
  std::function<SceneDescription(const std::string& name, const std::string& text)> readRobot;
  // Takes of a replay, of demos without Bullet worlds; and pictures by name.
  bool wantsReplay() const { return wantsReplay_; }
  bool wantsPictures() const { return wantsPictures_; }
  void addTakes(std::vector<ReplayTake> takes, double seconds, const std::string& setup,
                double voxel);
  void addPicture(const std::string& name, std::shared_ptr<const Drawing> drawing);
  using Pictures = std::vector<std::pair<std::string, std::shared_ptr<const Drawing>>>;
  const Pictures& pictures() const { return pictures_; }

  // The takes and their set-up; the caller fills the rest.
  Replay replay();

 private:
  SimulationReport runShort(const SceneDescription& scene, const WorldSettings& settings,
                            const SimulationSettings& simulation, const std::string& label);

  bool wantsReplay_, wantsPictures_;
  std::optional<Shortened> shortened_;
  Recorder recorder_;
  std::set<std::string> setups_;  // descriptions of the runs
  double voxel_ = 0, seconds_ = 0;
  std::vector<ReplayTake> takes_;  // from addTakes()
  Pictures pictures_;
};

struct Demo {
  const char* name;
  const char* title;
  const char* story;  // what it shows
  const char* watch;  // what to look for
  std::vector<ReplayCheck> (*run)(DemoStage&);
  bool draws = false;      // whether it has pictures
  bool cuts = false;       // it is a cut, without a Bullet world
  bool asksRobot = false;  // DemoStage::readRobot
};

const std::vector<Demo>& demos();

std::vector<ReplayCheck> runNutBolt(DemoStage& stage);
std::vector<ReplayCheck> runPegHole(DemoStage& stage);
std::vector<ReplayCheck> runArm(DemoStage& stage);
std::vector<ReplayCheck> runStack(DemoStage& stage);
std::vector<ReplayCheck> runChain(DemoStage& stage);
std::vector<ReplayCheck> runDrill(DemoStage& stage);
std::vector<ReplayCheck> runScalpel(DemoStage& stage);

// Mass and surface of a demo's body.
struct DemoMatter {
  double mass = 0;  // [kg], 0: static
  double friction = 0;
  std::optional<double> stiffness, damping;
};
// A body with one mesh; bodies of equal `kind` must have the same mesh.
SceneBody demoBody(const std::string& name, const std::string& kind,
                   std::shared_ptr<const Mesh> mesh, const Pose& pose, const DemoMatter& matter);
SceneBody demoFloor(double friction);

// A world of clouds with the given voxel, or of Bullet's own primitives.
WorldSettings demoSettings(double voxel, Method method = Method::Cloud);

// `value` with `digits` decimals and a unit: "12.3 mm".
std::string figure(double value, int digits, const char* unit = "");

}  // namespace cloudcontact::program
