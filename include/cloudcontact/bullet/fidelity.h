// Fidelity: the error that a user can bear, for which the library does no more than it needs.
#pragma once

namespace cloudcontact {

struct Fidelity {
  // [m] The surface that contacts see may differ from the cloud's by this much. 0: by the cloud's
  // own error, 0.15 voxel. So a body that is a ball or a box as far as its voxels tell meets others
  // like it as that, which is nearer to what was digitised; all other contacts are those of the
  // finest voxels.
  double tolerance = 0;
  // [s per step] Of a world (CloudContactSettings::fidelity): where its pairs would take longer,
  // those of least mass times error get coarser, beyond the tolerance. It is counted, not measured
  // (kLookupSeconds, kPairSeconds), so that a run repeats to the bit on any machine. 0: no limit.
  // Needs a tolerance. A shape has no budget of its own.
  double budget = 0;
  // Every contact is that of the finest voxels, whatever the body is like: to study the voxels'
  // own. Without a tolerance.
  bool exact = false;

  // [s] What a sample looked up and a pair searched count in a budget; about what they take on a
  // core of 3 GHz. PairReport::seconds is measured.
  static constexpr double kLookupSeconds = 1e-8, kPairSeconds = 4e-6;
};

}  // namespace cloudcontact
