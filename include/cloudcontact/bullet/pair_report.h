// PairReport: what was modelled of a pair with a cloud, what was left out, and what it cost.
#pragma once

#include <cloudcontact/contact/work_counts.h>

#include <cstddef>

class btCollisionObject;

namespace cloudcontact {

// How a pair got its contact: its surfaces were searched, here or on a device, closed forms
// answered for bodies that are known as shapes (CloudShape::setFidelity), or the last contact moved
// with the bodies (CloudContactSettings::reuseMotion).
enum class Answer { Searched, Shapes, Moved, Device };

// Of all steps and queries of a pair. The pairs of a compound's children are one. The objects may
// be gone if reports are kept (CloudContactSettings::keepReports).
struct PairReport {
  const btCollisionObject* a = nullptr;
  const btCollisionObject* b = nullptr;
  Answer last = Answer::Searched;
  std::size_t searched = 0, shapes = 0, moved = 0, device = 0;  // answers
  std::size_t samples = 0;  // that searches of all samples would look up
  // What the pair's searches here took, those of time of impact and of a change of voxels apart.
  WorkCounts work;
  std::size_t bytes = 0;  // that the pair keeps between steps
  double seconds = 0;
  // [m] The largest so far of what a depth may be off by, 95 % of them: depthError()
  // (contact/depth_error.h), or the error of the shapes, and what a contact that is moved may miss.
  // 0: the bodies have not touched.
  double expectedError = 0;
  double error = 0;  // [m] that of the last answer
  double depth = 0;  // [m] of the last answer, depthOf()
  int level = 0;     // of the samples of the last search (ContactResult::level)
  // Of the voxels of the last answer, of `a` and `b`: 0 the finest, each further one twice as large
  // (FieldLevels); and their edges [m], 0: no cloud.
  int voxelLevel[2] = {0, 0};
  double voxel[2] = {0, 0};
  double tolerance = 0;     // [m] of the pair; 0: none
  std::size_t coarser = 0;  // answers with larger voxels than the finest
  std::size_t refined = 0;  // searches repeated with finer voxels, as the contact's error asked
  std::size_t eased = 0;    // answers beyond the tolerance, for Fidelity::budget

  std::size_t answers() const { return searched + shapes + moved + device; }
};

}  // namespace cloudcontact
