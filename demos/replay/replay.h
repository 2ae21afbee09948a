// A replay as plain values: one or more recorded worlds, written as a glTF file (gltf.h) or as a
// page (page.h).
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "replay/changing_surface.h"
#include "replay/keyframes.h"
#include "replay/replay_contacts.h"
#include "scene/drawn_body.h"

namespace cloudcontact::program {

// What a body that is cut weighs from a time on.
struct MassKey {
  double time = 0;                  // [s]
  std::optional<double> mass = {};  // World's [kg]; none where nothing is left
};

struct ReplayBody {
  std::string name;
  bool isStatic = false;
  double mass = 0;  // [kg]
  DrawnBody drawn;
  std::vector<PoseKey> keys;  // one if the body does not move
  // Of a body that is cut or deforms, beside `drawn`: its surface over time, and the place of its
  // frame.
  std::vector<SurfacePiece> surface = {};
  Pose surfacePlace = {};
  std::vector<MassKey> masses = {};             // of a body that is cut, from its beginning on
  bool isCuttable = false, isPullable = false;  // World's
};

// Figures of one instant.
struct ReplayFrame {
  double time = 0;                    // [s]
  double kinetic = 0, potential = 0;  // of the bodies [J]
  double spring = 0;                  // in contacts and bodies that deform [J]
  double deepest = 0;                 // since the last frame, by the method under test [m]
  double narrowPhase = 0;             // of a step, mean since the last frame [s]
};

// One world's run. A viewer shows several takes side by side, at the same time.
struct ReplayTake {
  std::string label;
  Vec3 offset = Vec3::Zero();  // where the viewer puts the world's origin [m]
  std::vector<ReplayBody> bodies;
  std::vector<ReplayFrame> frames;
  ReplayContacts contacts;     // of each frame
  Eigen::AlignedBox3d start;   // without infinite planes, at the start [m]
  Eigen::AlignedBox3d extent;  // including motion up to a limit [m]
};

// An expected outcome and the actual one.
struct ReplayCheck {
  std::string expected, found;
  bool holds = false;
};

struct Replay {
  bool isLive = false;  // the start of a world that runs on (live_view.h)
  std::string title;
  std::string story;  // what it shows
  std::string watch;  // what to look for; may be empty
  std::string setup;  // method, voxel, step
  double seconds = 0;
  double voxel = 0;  // [m]
  std::vector<ReplayTake> takes;
  std::vector<ReplayCheck> checks;                         // of a demo
  std::vector<std::pair<std::string, std::string>> facts;  // names and figures of a run
};

}  // namespace cloudcontact::program
