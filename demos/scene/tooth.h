// A lower molar from formulas: enamel, dentin, pulp, and caries under its fissure. For demos, tests
// and benchmarks without files.
#pragma once

#include <cloudcontact/mesh/mesh.h>
#include <cloudcontact/voxels/cloud.h>

#include <vector>

namespace cloudcontact::program {

// The crown lies above the plane z = 0, the two roots below it. In meters, with the size of a first
// lower molar: crown about 10.5 by 10 by 7 mm, roots 13 mm.
struct ToothShape {
  double enamel = 1.6e-3;     // thickness of the enamel on the crown [m]; 0 at the neck
  double pit = 0.3e-3;        // radius of the carious hole in the enamel [m]
  double lesion = 2.0e-3;     // half width of the caries in the dentin, along the fissure [m]
  double pulpRoof = 0.7e-3;   // height of the pulp's roof below the pit [m]
  double meshCell = 0.25e-3;  // cell size of the meshes [m]
};

// Closed nested meshes, named "enamel", "dentin", "pulp" and "caries" as in dentalTissues()
// (tissue.h). The mesh of the enamel is the whole tooth: digitize() assigns each voxel to the
// smallest mesh around it. Throws std::invalid_argument if a length is not positive, or so large
// that the parts do not fit.
std::vector<NamedMesh> toothMeshes(const ToothShape& shape = {});

// The tooth as voxels of `voxelSize` [m]; 0.1 mm gives a grid of 2.4 million. `threads` 0: all
// cores. Throws as digitize() does.
Cloud toothCloud(double voxelSize, int threads = 0, const ToothShape& shape = {});

}  // namespace cloudcontact::program
