// The data of a contact's picture: the two bodies with their poses, and the contact.
#pragma once

#include <cloudcontact/contact/contact.h>
#include <cloudcontact/contact/paper_body.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace cloudcontact::program {

// A collision voxel of the paper's method and its base vector.
struct PaperVoxel {
  Vec3 center;      // world [m]
  Vec3 baseVector;  // Gr - Gc (4), world [m]
};

// One body of the pair: a cloud by its field, or the half-space.
struct PictureBody {
  std::string name;
  std::shared_ptr<const SurfaceField> field;
  std::optional<Solid> plane;  // if there is no field
  Pose pose;
  std::shared_ptr<const PaperBody> paper = {};  // with base vectors

  // Depth [m] and outward normal at a point of the world; empty far from the surface.
  std::optional<FieldPoint> at(const Vec3& world) const;
  double coverageAt(const Vec3& world) const;  // 0..1 of the voxel there
  int materialAt(const Vec3& world) const;     // of the voxel there, see Cloud::material
  // Depth of a point of the world in D, or in the body where D is all of it [m].
  double detectedDepth(const Vec3& world) const;
  // The base vector of a voxel whose center lies at `center`; empty unless part of it lies in the
  // D of `other`.
  std::optional<PaperVoxel> paperVoxel(const Eigen::Vector3i& voxel, const Vec3& center,
                                       const PictureBody& other) const;
};

struct ContactScene {
  PictureBody a, b;
  ContactResult result;
  Motion motionB;
  double voxel = 0;  // the larger of the two [m]

  bool byPaper() const { return a.paper || b.paper; }
};

// A sample of one body inside the other: the paper's collision voxel.
struct FoundSample {
  Vec3 position;          // world [m]
  Eigen::Vector3i voxel;  // in the grid of its own body
  int patch = 0;          // the nearest one
};

std::vector<FoundSample> samplesIn(const PictureBody& own, const PictureBody& other,
                                   const std::vector<ContactPoint>& points);

// Index of the patch with the largest force, the sum of k d over its points. There must be a patch.
int mostLoaded(const ContactResult& result);
double forceOf(const ContactResult& result, int patch);  // [N], at rest

}  // namespace cloudcontact::program
