// Combination: faces that bound the matter of a 3x3x3 block of voxels together.
#pragma once

#include "field/face_field.h"
#include "kernels/contact/field_voxel.h"

#include <cstdint>
#include <initializer_list>

namespace cloudcontact {

constexpr int kMostEdgeFaces = CC_MAX_PLANES;

// How two faces share a sub-sample that both cut. `alike` falls from 1 for equal normals to 0 at a
// right angle, `opposed` from 1 for opposite normals to 0 at a right angle.
struct Angle {
  float alike = 0, opposed = 0;
};
Angle angleBetween(const FaceField& a, const FaceField& b);

// Faces that bound the material together: the intersection of their half-spaces, or the union where
// `concave`.
struct Combination {
  const FaceField* face[kMostEdgeFaces] = {};
  int count = 0;
  bool concave = false;
  Angle angle[kMostEdgeFaces * (kMostEdgeFaces - 1) /
              2];  // of 0 and 1, 0 and 2, 1 and 2, 0 and 3, ...

  const Angle& between(int i, int j) const { return angle[j * (j - 1) / 2 + i]; }  // i < j
};
Combination combine(std::initializer_list<const FaceField*> faces, bool concave);
void measureAngles(Combination& c);  // needed after its faces have moved

// The voxels of a block by the faces that cross them, one bit each.
struct BlockCases {
  std::uint32_t full = 0, empty = 0, several = 0;
  std::uint32_t only[kMostEdgeFaces] = {};  // this face alone
};
BlockCases casesOf(const Combination& c);

}  // namespace cloudcontact
