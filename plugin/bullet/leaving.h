// Leaving: pairs that overlap although they have not moved into each other: placed so, teleported,
// or passed through. A spring would shoot them apart. They are moved apart instead: the nearest
// way, at a speed in proportion to what is left of the overlap and at most
// CloudContactSettings::leavingSpeed, so that they are slow where they part. Then the pair's law
// goes on.
#pragma once

#include "bullet/pair_query.h"
#include "contact/way_out.h"

namespace cloudcontact {

class Leaving {
 public:
  // Call once a step with the step's contact. Whether the pair leaves in this step. It begins to
  // where its last step had no contact and it is deeper than its motion explains, and so deep that
  // its spring would push it out faster than `most` [m/s]; or where half of a body is inside the
  // other. `step` [s].
  bool update(const PairQuery& query, const ContactResult& found, double most, double step);
  // One point that moves the bodies' centers apart at speed(), and one of negative depth that keeps
  // them from leaving faster, unless something else has made them faster.
  const ContactResult& contact() const { return contact_; }
  double speed() const { return speed_; }  // [m/s]

 private:
  bool begins(const PairQuery& query, const ContactResult& found, double most, double step);
  bool goesOn(const PairQuery& query, const ContactResult& found);
  void write(const PairQuery& query, double most, double step);

  WayOut out_;
  bool on_ = false, touched_ = false;
  bool way_ = false;  // the push is that of out_
  ContactPoint push_;
  double speed_ = 0;
  ContactResult contact_;
};

}  // namespace cloudcontact
