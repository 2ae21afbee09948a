// What all cloud pairs of a Bullet world share: settings in, statistics out.
#pragma once

#include <cloudcontact/bullet/fidelity.h>
#include <cloudcontact/contact/contact.h>
#include <cloudcontact/contact/work_counts.h>
#include <cloudcontact/law/law.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>

namespace cloudcontact {

struct CloudContactSettings {
  // The law of every pair, whatever its bodies state. Empty: the bodies' laws decide
  // (CloudShape::setTissues and law, btCollisionObject::setContactStiffnessAndDamping), and pairs
  // without one get an automatic spring (automatic_spring.h). Foundation{}, without a stiffness:
  // the same, but shared out by area. Laws with a memory keep it while the bodies touch.
  std::optional<Law> law = std::nullopt;
  std::size_t samples = ContactSettings::kSamples;  // ContactSettings::samples of every pair
  // Upper limit of an automatic spring, in multiples of the stiffness that the step allows for the
  // pair's own mass: for light bodies that bear heavy ones, and for stacks at long steps. Use 1
  // with Bullet's own solver and up to 100 with NewtonSolver. At least 1 and finite.
  double bears = 1;
  // [voxels] A pair is searched again once a point of one body, where the two may touch, has moved
  // farther than this relative to the other; until then its last contact is moved with the bodies,
  // to first order in their motion. More is less exact and hardly faster. 0: every step searches,
  // for measurements. Finite and not negative.
  double reuseMotion = 0.02;
  // [m/s] Bodies that overlap without having moved into each other (placed so, or teleported) are
  // moved apart by the nearest way, no faster than this, and keep hardly any speed. It concerns
  // only those that their spring would push out faster. Infinite: the spring does. Positive.
  double leavingSpeed = 1;
  // The tolerance of shapes that state none (CloudShape::setFidelity), except that it makes no
  // shape a ball or a box; a budget for all pairs; and whether all are exact.
  Fidelity fidelity = {};
  // Told of each kind of failure (CloudContactStatistics::failures) once, and of each kind of body
  // that turns wrongly (diagnose()), which is no failure. From the thread that meets it, during a
  // step: it must not step or query the world. Empty: standard error.
  std::function<void(const std::string&)> onFailure = {};
  bool keepReports = false;  // CloudContact::pairs() also tells of pairs that have parted
};

// Time and work of the cloud narrow phase since the last reset.
struct CloudContactStatistics {
  double seconds = 0;
  // Not of pairs whose boxes stay apart for the step: they are not asked.
  std::size_t pairs = 0, samples = 0, contacts = 0;
  std::size_t shapes = 0;     // of `pairs`, those answered by shapes (CloudShape::setFidelity)
  std::size_t reused = 0;     // of `pairs`: those whose last contact was moved
  std::size_t device = 0;     // of `pairs`: those that a device searched (CloudDispatcher)
  std::size_t coarser = 0;    // of `pairs`: those searched with larger voxels than the finest
  std::size_t refined = 0;    // searches repeated with finer voxels, as the contact asked
  std::size_t eased = 0;      // of `pairs`: those beyond their tolerance, for Fidelity::budget
  WorkCounts work;            // of all searches, those ahead of Bullet's walk included
  std::size_t bytes = 0;      // that the pairs of now keep between steps
  double countedSeconds = 0;  // of the last full step, as Fidelity::budget counts; 0: no budget
  // Pairs without an answer (a NaN pose, a flat shape, an exception, none of which reaches Bullet),
  // and the message of the last one.
  std::size_t failures = 0;
  std::string lastFailure;
};

}  // namespace cloudcontact
