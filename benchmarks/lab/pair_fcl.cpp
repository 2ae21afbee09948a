// FCL 0.7 (Debian's libfcl-dev 0.7.0, double).
//
// Meshes are BVHModel<OBBRSS>, FCL's usual tree for triangles, with contacts enabled and a limit on
// their number that no pair here reaches. A contact is a pair of intersecting triangles. Its
// position is one of their corners, its normal the face normal of one of them, and its
// penetration_depth the depth of one triangle's corners below the other's plane (the smaller of the
// two; corners are not clipped to the other triangle). That depth grows with the triangles' size
// and is not the depth of the bodies. The library has nothing better, so the chart shows it
// unchanged. A corner may lie on either body, so positions are off by half a depth. A body wholly
// inside the other has no contact.
//
// Convex bodies use FCL's closed forms for spheres, boxes and planes, else GJK and EPA of
// libccd 2.1 at FCL's default tolerance of 1e-6, on primitives or on the facets as fcl::Convex.
#include <fcl/config.h>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/convex.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/halfspace.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>

#include <memory>
#include <utility>

#include "lab/peer_pairs.h"

namespace cloudcontact::program::lab {

namespace {

constexpr std::size_t kMaxContacts = 1'000'000;

using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;
using GeometryMaker = Geometry (*)(const LabBody& body, double tolerance);

Geometry meshTree(const Mesh& mesh) {
  std::vector<fcl::Triangle> triangles;
  for (const Eigen::Vector3i& t : mesh.triangles)
    triangles.emplace_back(std::size_t(t[0]), std::size_t(t[1]), std::size_t(t[2]));
  auto model = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
  model->beginModel(int(triangles.size()), int(mesh.vertices.size()));
  model->addSubModel(mesh.vertices, triangles);
  model->endModel();
  return model;
}

Geometry convexOf(const Mesh& mesh) {
  auto faces = std::make_shared<std::vector<int>>();
  for (const Eigen::Vector3i& t : mesh.triangles)
    faces->insert(faces->end(), {3, t[0], t[1], t[2]});
  auto vertices = std::make_shared<std::vector<Vec3>>(mesh.vertices);
  return std::make_shared<fcl::Convexd>(vertices, int(mesh.triangles.size()), faces);
}

struct PrimitiveMaker {
  Geometry operator()(const HalfSpace& s) const {
    return std::make_shared<fcl::Halfspaced>(s.normal, s.offset);
  }
  Geometry operator()(const Sphere& s) const { return std::make_shared<fcl::Sphered>(s.radius); }
  Geometry operator()(const Box& s) const {
    return std::make_shared<fcl::Boxd>(fcl::Vector3d(2 * s.halfExtents));
  }
  Geometry operator()(const Capsule& s) const {
    return std::make_shared<fcl::Capsuled>(s.radius, 2 * s.halfHeight);
  }
  Geometry operator()(const Cylinder& s) const {
    return std::make_shared<fcl::Cylinderd>(s.radius, 2 * s.halfHeight);
  }
  Geometry operator()(const Cone& s) const {
    if (s.margin > 0) throw CannotDo("FCL has no cone with a margin");
    return std::make_shared<fcl::Coned>(s.radius, 2 * s.halfHeight);
  }
  Geometry operator()(const Hull&) const {
    throw CannotDo("FCL takes a hull as fcl::Convex, another setting");
  }
  template <class Other>
  Geometry operator()(const Other&) const {
    throw CannotDo("the laboratory has no such body");
  }
};

Geometry treeOf(const LabBody& body, double tolerance) {
  return isHalfSpace(body) ? PrimitiveMaker{}(std::get<HalfSpace>(*body.shape))
                           : meshTree(body.mesh(tolerance));
}

Geometry convexOf(const LabBody& body, double tolerance) {
  if (isHalfSpace(body)) return PrimitiveMaker{}(std::get<HalfSpace>(*body.shape));
  if (!body.convex) throw CannotDo(body.name + " is concave; fcl::Convex only takes convex bodies");
  return convexOf(body.mesh(tolerance));
}

Geometry primitive(const LabBody& body, double) {
  return std::visit(PrimitiveMaker{}, primitiveOf(body));
}

fcl::Transform3d toFcl(const Pose& pose) {
  fcl::Transform3d transform = fcl::Transform3d::Identity();
  transform.linear() = pose.orientation.toRotationMatrix();
  transform.translation() = pose.position;
  return transform;
}

class FclPair {
 public:
  FclPair(Geometry a, Geometry b) : a_(std::move(a)), b_(std::move(b)) {
    a_->computeLocalAABB();
    b_->computeLocalAABB();
  }

  void collide(const Pose& b, fcl::CollisionResultd& result) const {
    const fcl::CollisionRequestd request(kMaxContacts, true);
    fcl::collide(a_.get(), fcl::Transform3d::Identity(), b_.get(), toFcl(b), request, result);
  }

  std::vector<LabPoint> find(const Pose& b) const {
    fcl::CollisionResultd result;
    collide(b, result);
    std::vector<LabPoint> points;
    for (std::size_t k = 0; k < result.numContacts(); ++k) {
      const fcl::Contactd& c = result.getContact(k);
      // FCL swaps a shape before a mesh; the normal then points from the mesh to the shape.
      const double sign = c.o1 == b_.get() ? -1 : 1;
      points.push_back({c.pos, sign * c.normal, c.penetration_depth, 0});
    }
    return points;
  }

 private:
  Geometry a_, b_;
};

LabPair labPair(const Geometry& a, const Geometry& b) {
  const FclPair pair(a, b);
  LabPair made = pairOf([pair](const Pose& pose) { return pair.find(pose); },
                        [pair](const Pose& pose) {
                          fcl::CollisionResultd result;
                          pair.collide(pose, result);
                        });
  made.swapped = [a, b] { return labPair(b, a); };
  return made;
}

LabMethod fclMethod(const std::string& setting, double detail, GeometryMaker maker,
                    const std::string& description) {
  const auto prepare = [maker](const LabBody& a, const LabBody& b, double tolerance) {
    return labPair(maker(a, tolerance), maker(b, tolerance));
  };
  return {"fcl", setting, detail, prepare, description, detail > 0};
}

}  // namespace

std::vector<LabMethod> fclMethods() {
  std::vector<LabMethod> methods = {
      fclMethod("primitives, libccd", 0, primitive,
                "closed forms for spheres, boxes and planes, else GJK and EPA of libccd at FCL's "
                "default tolerance of 1e-6; contacts enabled"),
      fclMethod("Convex, libccd, facets " + fraction(kCoarseFacets), kCoarseFacets, convexOf,
                "fcl::Convex of " + facetsWithin(kCoarseFacets) +
                    ", GJK and EPA of libccd at the default tolerance of 1e-6; contacts enabled")};
  for (const double facets : kFacetLadder)
    methods.push_back(
        fclMethod("BVH, facets " + fraction(facets), facets, treeOf,
                  "BVHModel<OBBRSS> of " + facetsWithin(facets) +
                      ", all contacts, in double; a contact is a pair of intersecting "
                      "triangles"));
  return methods;
}

Version fclVersion() {
  return {"FCL", FCL_VERSION};
}

}  // namespace cloudcontact::program::lab
