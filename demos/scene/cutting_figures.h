// Summary of a cutting run: forces, volumes, times, and figures for each tissue.
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include <optional>
#include <string>
#include <vector>

#include "scene/cutting_run.h"

namespace cloudcontact::program {

struct TissueFigures {
  std::string name;
  std::optional<double> firstTouch;  // [s] when it first made up a twentieth of the touched voxels
  double seconds = 0;                // [s] during which it made up nine tenths or more
  double meanForce = 0;              // [N] over those seconds
};

struct CuttingFigures {
  double mostForce = 0;  // [N]
  // Largest relative change of the force between two ticks, among forces above a tenth of the
  // largest: without a cut, and with a cut in either tick.
  double largestStep = 0, largestCuttingStep = 0;
  double cutVolume = 0;                                // [m^3] volume before minus after
  double workVolume = 0;                               // [m^3] by Archard's law
  double medianMicroseconds = 0, p99Microseconds = 0;  // of a tick in contact
  std::vector<TissueFigures> tissues;
};

CuttingFigures figuresOf(const CuttingRun& run);

// Mean force [N] between two times [s], over the ticks in contact.
double meanForce(const CuttingRun& run, double from, double to);

// Volume of each material of the cloud [m^3]; one number if it has no materials.
std::vector<double> materialVolumes(const Cloud& cloud);

}  // namespace cloudcontact::program
