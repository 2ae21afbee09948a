// A replay as plain values: what a recorder has seen of one or several worlds, ready to be written
// as a glTF file (gltf.h) or as a page (page.h).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "replay/keyframes.h"
#include "replay/replay_contacts.h"
#include "scene/drawn_body.h"

namespace cloudcontact::program {

struct ReplayBody {
  std::string name;
  bool isStatic = false;
  double mass = 0;  // [kg]
  DrawnBody drawn;
  std::vector<PoseKey> keys;  // one for a body that does not move
};

// What is known at one instant beyond where bodies stand.
struct ReplayFrame {
  double time = 0;                    // [s]
  double kinetic = 0, potential = 0;  // of the bodies [J]
  double spring = 0;                  // in the contacts [J]
  double deepest = 0;                 // since the frame before, by the method under test [m]
  double narrowPhase = 0;             // a step's, mean since the frame before [s]
};

// One world's run. Several stand beside each other and run at the same time.
struct ReplayTake {
  std::string label;
  Vec3 offset = Vec3::Zero();  // where the viewer puts the world's origin [m]
  std::vector<ReplayBody> bodies;
  std::vector<ReplayFrame> frames;
  ReplayContacts contacts;     // of each frame
  Eigen::AlignedBox3d start;   // of all that is not endless, at the start [m]
  Eigen::AlignedBox3d extent;  // with where it moves to, as far as that is not very far
};

// Something that should have happened, and what did.
struct ReplayCheck {
  std::string expected, found;
  bool holds = false;
};

struct Replay {
  std::string title;
  std::string story;  // what is shown
  std::string watch;  // what to look for; may be empty
  std::string setup;  // method, voxel, step
  double seconds = 0;
  double voxel = 0;  // [m]
  std::vector<ReplayTake> takes;
  std::vector<ReplayCheck> checks;                         // of a demo
  std::vector<std::pair<std::string, std::string>> facts;  // of any run: a name and a figure
};

}  // namespace cloudcontact::program
