// A demo: a scene that tells a story and checks its own outcome against physics.
#pragma once

#include <string>
#include <vector>

#include "scene.h"
#include "simulation.h"

namespace cloudcontact::program {

// One thing that should have happened, and what did.
struct DemoCheck {
  std::string expected, found;
  bool holds = false;
};

struct Demo {
  const char* name;
  const char* title;
  const char* story;
  std::vector<DemoCheck> (*run)();
};

const std::vector<Demo>& demos();

std::vector<DemoCheck> runNutBolt();
std::vector<DemoCheck> runPegHole();
std::vector<DemoCheck> runStack();
std::vector<DemoCheck> runChain();

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
std::string figure(double value, int digits, const char* unit);

}  // namespace cloudcontact::program
