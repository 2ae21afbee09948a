// The scenes of the demos drill and scalpel: a body of tissues, a tool, a hand and its path. Tests
// and benchmarks use them too.
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>

#include "scene/cutting_run.h"

namespace cloudcontact::program {

struct CutScene {
  Cloud cloud;
  TissueTable tissues;  // in the order of the cloud's materials
  CuttingTask task;
  Mesh tool;  // in the tool's frame [m]
};

// A ball bur opens a molar (tooth.h): a borehole through the enamel into the caries and down to
// the pulp's roof, then a cavity along the fissure, layer by layer.
CutScene drillScene(int threads = 0);

// Planned height of the bur's lowest point above the crown's plane z = 0 [m].
constexpr double kDrillFloor = 1.35e-3;

// A scalpel's blade is drawn along x through skin into the muscle below.
CutScene scalpelScene(int threads = 0);

// Planned depth of the blade [m]; the wrist and the device are springs, so the blade stays above
// it.
constexpr double kBladePlan = 5e-3;
constexpr double kBladeHalfThickness = 0.4e-3;
constexpr double kSkinThickness = 2e-3;
constexpr double kSlabTop = 0;                        // z of the skin's surface [m]
constexpr double kCutStart = -9e-3, kCutEnd = 10e-3;  // range of x at full depth [m]

}  // namespace cloudcontact::program
