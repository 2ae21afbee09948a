// A cube for the programs of this folder.
#pragma once

#include <cloudcontact/cloudcontact.h>

inline cloudcontact::Mesh cube(double edge) {
  cloudcontact::Mesh mesh;
  for (int k = 0; k < 8; ++k)
    mesh.vertices.push_back(edge *
                            Eigen::Vector3d((k & 1) - 0.5, (k >> 1 & 1) - 0.5, (k >> 2) - 0.5));
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}
