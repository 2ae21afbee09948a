// Whether a solid's lengths make it an area or a body (solid.h).
#include <cloudcontact/law/solid.h>
#include <cloudcontact/voxels/cloud.h>

#include <cmath>
#include <stdexcept>
#include <string>

namespace cloudcontact {

namespace {

void requireSizes(const char* what, const Vec3& sizes) {
  if (!(sizes.array() > 0).all() || !sizes.allFinite())
    throw std::invalid_argument(std::string(what) + " must be positive and finite");
}
void requireMargin(const char* what, double margin) {
  if (!(margin >= 0) || !std::isfinite(margin))
    throw std::invalid_argument(std::string(what) + " margin must be at least 0 and finite");
}

void requireLengths(const char* what, const Vec3& lengths) {
  if (!(lengths.array() >= 0).all() || !lengths.allFinite())
    throw std::invalid_argument(std::string(what) + " must be at least 0 and finite");
}

// Lengths of a solid: of an area positive, of a body 0 or more.
struct LengthValidation {
  void (*require)(const char*, const Vec3&);

  void operator()(const Sphere& s) const { require("a sphere's radius", Vec3::Constant(s.radius)); }
  void operator()(const Box& b) const { require("a box's half extents", b.halfExtents); }
  void operator()(const Ellipsoid& e) const {
    requireSizes("an ellipsoid's semi-axes", e.semiAxes);
  }
  void operator()(const Capsule& c) const {
    require("a capsule's radius and half height", {c.radius, c.radius, c.halfHeight});
  }
  void operator()(const Cylinder& c) const {
    require("a cylinder's radius and half height", {c.radius, c.radius, c.halfHeight});
  }
  void operator()(const Cone& c) const {
    require("a cone's radius and half height", {c.radius, c.radius, c.halfHeight});
    requireMargin("a cone's", c.margin);
  }
};

struct AreaValidation : LengthValidation {
  using LengthValidation::operator();
  void operator()(const HalfSpace&) const {
    throw std::invalid_argument("an area must be bounded; a half-space is not");
  }
  void operator()(const Hull& hull) const {
    if (hull.planes.size() < 4 || hull.corners.empty())
      throw std::invalid_argument("a hull needs at least four planes, and corners for its bounds");
    requireSizes("a hull's extents", boundsOf(Solid(hull)).sizes());
    requireMargin("a hull's", hull.margin);
  }
  void operator()(const CloudSolid& c) const {
    if (!c.cloud || !c.depth)
      throw std::invalid_argument("a cloud solid has no cloud: make it with cloudSolid()");
    requireSizes("a cloud solid's voxel", Vec3::Constant(c.cloud->voxelSize()));
  }
  void operator()(const SurfaceSolid&) const {
    throw std::invalid_argument("an area must enclose a volume; triangles need not");
  }
};

// Runs in each query: nothing that grows with a hull's faces.
struct BodyValidation : LengthValidation {
  using LengthValidation::operator();
  void operator()(const HalfSpace& half) const {
    if (!half.normal.allFinite() || !std::isfinite(half.offset))
      throw std::invalid_argument("a half-space's normal and offset must be finite");
  }
  void operator()(const Hull& hull) const { requireMargin("a hull's", hull.margin); }
  void operator()(const CloudSolid&) const {}
  void operator()(const SurfaceSolid&) const {}
};

}  // namespace

void validate(const PlacedSolid& area) {
  std::visit(AreaValidation{{&requireSizes}}, area.solid);
  if (!area.place.position.allFinite() || !area.place.orientation.coeffs().allFinite())
    throw std::invalid_argument("an area's place must be finite");
}

void validateBody(const Solid& body) {
  std::visit(BodyValidation{{&requireLengths}}, body);
}

}  // namespace cloudcontact
