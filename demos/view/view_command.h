// What the page of a live view asks for, as JSON text.
#pragma once

#include <cloudcontact/base/pose.h>

#include <cstddef>
#include <optional>
#include <string>
#include <variant>

namespace cloudcontact::program {

struct RunOn {};     // {"do": "run"}
struct Pause {};     // {"do": "pause"}
struct StepOnce {};  // {"do": "step"}: one step, then a pause
// {"do": "speed", "times": 0.5}: of real time, from 1e-6 to 1000; 0: as fast as it can.
struct SetSpeed {
  double times = 1;
};
// {"do": "pull", "body": 3, "at": [x, y, z], "to": [x, y, z]}: from a place in the body's frame to
// one in the world [m]. It lasts until the next, or {"do": "release"}.
struct PullBody {
  std::size_t body = 0;
  Vec3 at = Vec3::Zero(), to = Vec3::Zero();
};
struct Release {};
// {"do": "cut", "body": 3, "at": [x, y, z], "radius": r}: a ball about a place in the body's frame
// [m].
struct CutBall {
  std::size_t body = 0;
  Vec3 at = Vec3::Zero();
  double radius = 0;
};

using ViewCommand = std::variant<RunOn, Pause, StepOnce, SetSpeed, PullBody, Release, CutBall>;

// Empty where the text is none of these, or a number is not finite or out of its range.
std::optional<ViewCommand> readCommand(const std::string& text);

// Whether it only says where a hand is: of several such in a row the last counts.
bool isPull(const std::string& text);

}  // namespace cloudcontact::program
