// What the live view sends to its pages: the time, the poses, and the surfaces that change.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "replay/replay.h"
#include "scene/world.h"

namespace cloudcontact::program {

// What is not the world's.
struct ViewStatus {
  double time = 0;  // [s]
  bool isRunning = true, isEnded = false;
  double speed = 1;   // that is asked for, times real time; 0: as fast as it can
  double factor = 0;  // that is reached
  long steps = 0;     // since the last moment
  int pages = 0;
  std::string said;  // the latest answer to a page; may be empty
  int sayings = 0;   // answers so far
  std::string why;   // of an end that is a failure
};

// Packed as PackedArrays.
class LiveFrames {
 public:
  // A topic of its own for each body's surface, and the last for the moment.
  static constexpr int kMoment = 1'000'000'000;

  // The world must outlive it.
  explicit LiveFrames(const World& world, double time);
  ~LiveFrames();

  // The world at the start, for the page; first of all. Title and setup are the caller's to fill.
  Replay start();
  // Poses, contacts, figures, pulls.
  std::string moment(const ViewStatus& status);
  // The surfaces that changed since the last call, and those of bodies that are new: topic and
  // bytes. `all`: also of bodies that deform, which change in every step.
  std::vector<std::pair<int, std::string>> surfaces(bool all = true);
  bool hasNewBodies() const;

 private:
  struct Surface;
  void addBody(std::size_t body);
  std::string surface(std::size_t body);

  const World& world_;
  double time_;
  std::vector<ReplayBody> bodies_;
  std::vector<std::unique_ptr<Surface>> surfaces_;  // of each body that is cut or deforms
  std::vector<bool> isFixed_;
  float still_ = 0;         // as ReplayContacts [m]
  double narrowPhase_ = 0;  // the world's clock at the last moment [s]
  ContactsNow now_;
};

}  // namespace cloudcontact::program
