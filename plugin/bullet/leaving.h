// Leaving: pairs that overlap although they have not moved into each other: placed so, teleported,
// or passed through. A spring would shoot them apart. They are moved apart instead: the nearest
// way, at a speed in proportion to what is left of the overlap and at most
// CloudContactSettings::leavingSpeed, so that they are slow where they part. Then the pair's law
// goes on.
#pragma once

#include <limits>
#include <optional>

#include "bullet/pair_query.h"
#include "contact/way_out.h"

namespace cloudcontact {

class Leaving {
 public:
  // Call once a step with the step's contact. Whether the pair leaves in this step. It begins to
  // where it is deeper than its last step and its motion explain, and so deep that
  // its spring would push it out faster than `most` [m/s]; or where half of a body is inside the
  // other. `step` [s].
  bool update(const PairQuery& query, const ContactResult& found, double most, double step);
  // It ends where the overlap is a tenth of a voxel or, since a joint or another body may hold the
  // pair, has not become less for a quarter of a second; the spring then has it until they part.
  // One point that moves the bodies' centers apart at speed(), and one of negative depth that keeps
  // them from leaving faster, unless something else has made them faster.
  ContactResult contact() const;
  double speed() const { return speed_; }  // [m/s]
  // For a step with a contact from elsewhere, and one without a query.
  void touched(const ContactResult& found);
  void reset();
  // For files (base/byte_archive.h).
  template <typename Archive>
  void keepIn(Archive& archive) {
    archive(on_, way_, held_, last_, least_, still_, speed_);
    out_.keepIn(archive);
  }

 private:
  bool begins(const PairQuery& query, const ContactResult& found, double most, double step);
  bool goesOn(const PairQuery& query, const ContactResult& found);
  bool moves(double step);
  void setSpeed(const PairQuery& query, double most, double step);

  WayOut out_;
  static constexpr double kNone = -std::numeric_limits<double>::infinity();
  bool on_ = false, way_ = false;  // way_: the push is that of out_
  bool held_ = false;              // something holds the pair: it stays with the law
  double last_ = kNone;            // [m] depth in the last step
  double least_ = 0, still_ = 0;   // [m] least depth so far, and how long it has been that [s]
  ContactPoint push_;
  double speed_ = 0;
  std::optional<double> brake_;  // [m] the depth of the second point, if there is one
};

}  // namespace cloudcontact
