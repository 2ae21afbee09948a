// PairStep: the value that goes through a pair's step, read -> find -> adjust -> write. Each
// station adds its part.
#pragma once

#include <cloudcontact/bullet/pair_report.h>

#include <optional>

#include "bullet/turning.h"

namespace cloudcontact {

struct PairStep {
  bool isStep = true;  // of the world; else a query, which changes no manifold
  double seconds = 0;  // [s] Bullet's; 0 before the world's first step
  // How far the pair is looked ahead [s].
  double ahead() const { return isStep ? knownStep(seconds) : 0; }

  PairQuery query;                // read: what the bodies are
  ContactResult contact;          // find: what touches
  Answer how = Answer::Searched;  // and how it was found
  std::optional<Touch> touch;     // adjust: when later in the step that is, of what sweeps or turns
  std::optional<Turn> turn;       // of what turns: where it was before
  std::optional<bool> keepsAwake;  // write: whether the bodies must not fall asleep; empty: not yet
  double earlier = 0;              // [s] of computing ahead of Bullet's walk
  // Whether the bodies touch there; else its points say where they come near.
  bool touches() const {
    return how == Answer::Shapes ? depthOf(contact) > 0 : contact.samples > 0;
  }
  PairSides sides(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b) const {
    return {&a, &b, query.a.motion, query.b.motion, query.mass, touch ? &*touch : nullptr};
  }
};

}  // namespace cloudcontact
