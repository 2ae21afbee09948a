// ShapeTriangles: the triangles of a Bullet shape that are near a cloud, as a solid.
#pragma once

#include <cloudcontact/contact/contact.h>

#include <memory>
#include <mutex>
#include <vector>

#include "law/triangle_surface.h"

class btCollisionShape;

namespace cloudcontact {

// Whether a shape is read as triangles: concave shapes that hand out triangles, single triangles
// and 2D shapes. Not GImpact's compounds and Bullet's distance fields, which hand out none.
bool hasTriangles(const btCollisionShape& shape);

// Every query reads the triangles from Bullet: a mesh's vertices may have moved, or another shape
// may have its address now. The surface is rebuilt only if they differ from the last ones.
class ShapeTriangles {
 public:
  // The solid behind the triangles near `cloud`, a body with a field; null if there are none.
  // `pose`: of the shape. `reach` [m]: triangles this far from the cloud are wanted, too.
  // `reading`: held while Bullet's shape is read, because GImpact's lock their vertices without
  // care for threads. Not of a shape without triangles.
  const Solid* of(const btCollisionShape& shape, const Pose& pose, const ContactBody& cloud,
                  double reach, std::mutex& reading);
  int changes() const { return changes_; }  // of the solid, so far

 private:
  void chooseSides(const Pose& toShape, const SurfaceField& field);

  std::shared_ptr<TriangleSurface> surface_, before_;
  Solid solid_;
  std::vector<double> read_, joined_;  // corners; those that surface_ was made of
  std::vector<Vec3> points_;
  Eigen::AlignedBox3d box_;
  // What chose the sides last.
  Pose chosenAt_;
  const SurfaceField* chosenBy_ = nullptr;
  int changes_ = 0;
};

}  // namespace cloudcontact
