// A lower molar made by formula: enamel, dentin, pulp, and caries under its fissure. For demos,
// tests and benchmarks that must not need a file.
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>

#include <vector>

namespace cloudcontact::program {

// The crown stands on the plane z = 0 and points to +z, the two roots below it to -z. In metres;
// as large as a first lower molar: crown about 10.5 by 10 by 7 mm, roots 13 mm.
struct ToothShape {
  double enamel = 1.6e-3;     // thickness of the enamel on the crown [m]; it runs out at the neck
  double pit = 0.3e-3;        // radius of the caries' way in through the enamel [m]
  double lesion = 2.0e-3;     // half width of the caries in the dentin, along the fissure [m]
  double pulpRoof = 0.7e-3;   // height of the pulp's roof below the pit [m]
  double meshCell = 0.25e-3;  // of the meshes' cells [m]
};

// Closed meshes, one within another, named "enamel", "dentin", "pulp" and "caries" as
// dentalTissues() names them (tissue.h). The enamel's is the whole tooth: digitize() gives each
// voxel to the smallest mesh that holds it. Throws std::invalid_argument where a length is not
// positive, or so large that the parts do not fit.
std::vector<NamedMesh> toothMeshes(const ToothShape& shape = {});

// That tooth as voxels of `voxelSize` [m]: 0.1 mm make a grid of 2.4 million. `threads` 0: all
// cores. Throws as digitize() does.
Cloud toothCloud(double voxelSize, int threads = 0, const ToothShape& shape = {});

}  // namespace cloudcontact::program
