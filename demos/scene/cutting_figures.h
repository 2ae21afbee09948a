// What a cut comes to: the figures by which it is judged and told.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <optional>
#include <string>
#include <vector>

#include "scene/cutting_run.h"

namespace cloudcontact::program {

struct TissueFigures {
  std::string name;
  std::optional<double> firstTouch;  // [s] when it was first a twentieth of what is touched
  double seconds = 0;                // that it was nine tenths or more of it
  double meanForce = 0;              // [N] over those
};

struct CuttingFigures {
  double mostForce = 0;  // [N]
  // Greatest change of the force from one tick to the next, as part of the force, where that is
  // above a tenth of the greatest: with nothing cut, and with a cut in either tick.
  double largestStep = 0, largestCuttingStep = 0;
  double cutVolume = 0;                                // [m^3] the workpiece's before, less after
  double workVolume = 0;                               // [m^3] by Archard's law
  double medianMicroseconds = 0, p99Microseconds = 0;  // of a tick in touch
  std::vector<TissueFigures> tissues;
};

CuttingFigures figuresOf(const CuttingRun& run);

// Mean force [N] and shares between two times [s], where the tool is in touch.
double meanForce(const CuttingRun& run, double from, double to);

// Volume of each of the cloud's materials [m^3], in their order; one number where it has none.
std::vector<double> materialVolumes(const Cloud& cloud);

}  // namespace cloudcontact::program
