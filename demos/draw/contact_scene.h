// What a picture of a contact is made of: the two bodies as they stand, and what was found.
#pragma once

#include <cloudcontact/contact/contact.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace cloudcontact::program {

// One body of the pair: a cloud by its field, or the half-space.
struct PictureBody {
  std::string name;
  std::shared_ptr<const SurfaceField> field;
  std::optional<Solid> plane;  // where there is no field
  Pose pose;

  // Depth and outward normal at a point of the world; nothing far from the surface. [m]
  std::optional<FieldPoint> at(const Vec3& world) const;
  double coverageAt(const Vec3& world) const;  // 0..1 of the voxel there
  int materialAt(const Vec3& world) const;     // of the voxel there, see Cloud::material
};

struct ContactScene {
  PictureBody a, b;
  ContactResult result;
  Motion motionB;
  double voxel = 0;  // the larger of the two [m]
};

// A sample of one body that lies in the other: the paper's collision voxel.
struct FoundSample {
  Vec3 position;          // world [m]
  Eigen::Vector3i voxel;  // of its own body's grid
  int patch = 0;          // the nearest one
};

std::vector<FoundSample> samplesIn(const PictureBody& own, const PictureBody& other,
                                   const std::vector<ContactPoint>& points);

// Index of the patch with the largest force, k d over its points. There must be one.
int mostLoaded(const ContactResult& result);
double forceOf(const ContactResult& result, int patch);  // [N], at rest

}  // namespace cloudcontact::program
