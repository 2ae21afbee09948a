// The scenes of the demos drill and scalpel: a body of tissues, a tool, a hand and its path. For
// tests and benchmarks too.
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>

#include "scene/cutting_run.h"

namespace cloudcontact::program {

struct CutScene {
  Cloud cloud;
  TissueTable tissues;  // in the order of the cloud's materials
  CuttingTask task;
  Mesh tool;  // about its own origin [m]
};

// A ball bur opens a molar (tooth.h): a borehole through the enamel into the caries and down to
// the pulp's roof, then a cavity along the fissure, layer by layer.
CutScene drillScene(int threads = 0);

// How deep that bur is to go: its lowest point above the crown's plane z = 0 [m].
constexpr double kDrillFloor = 1.35e-3;

// A scalpel's blade is drawn along x through skin into the muscle below.
CutScene scalpelScene(int threads = 0);

// The hand plans to go so deep [m]; skin and muscle press it back by some of that, its wrist and
// the device being springs.
constexpr double kBladePlan = 5e-3;
constexpr double kBladeHalfThickness = 0.4e-3;
constexpr double kSkinThickness = 2e-3;
constexpr double kSlabTop = 0;                        // z of the skin's surface [m]
constexpr double kCutStart = -9e-3, kCutEnd = 10e-3;  // x between which it stays at its depth [m]

}  // namespace cloudcontact::program
