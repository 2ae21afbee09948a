// ODE 0.16 (Debian's libode-dev 0.16.2: double, OPCODE's trees, built without libccd).
//
// Meshes are dTriMesh, primitives ODE's sphere, box, capsule, cylinder and plane. Without libccd
// there is no cylinder against a cylinder or a capsule; there is no cone. Convex hulls are left
// out, as they collide with each other by their vertices only. The contact limit is dCollide's
// maximum (65,535); merging of equal contacts stays on. Debian's build is not thread-safe: query
// one pair at a time.
#include <ode/ode.h>
#include <ode/version.h>

#include <cstdarg>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "lab/peer_pairs.h"

namespace cloudcontact::program::lab {

namespace {

constexpr int kMaxContacts = 0xffff;

// Suppresses a message about a full table of equal contacts, which would be printed tens of
// thousands of times while time is measured.
void keepQuiet(int, const char*, va_list) {}

// Initializes ODE once per process and once per calling thread.
void startOde() {
  static std::once_flag once;
  std::call_once(once, [] {
    dInitODE2(0);
    dSetMessageHandler(keepQuiet);
  });
  thread_local const bool ready = dAllocateODEDataForThread(dAllocateMaskAll) != 0;
  if (!ready) throw CannotDo("ODE cannot initialize in this thread");
}

// A geometry with the mesh that it refers to.
class OdeGeometry {
 public:
  explicit OdeGeometry(dGeomID geometry) : geometry_(geometry) {}
  explicit OdeGeometry(const Mesh& mesh) : data_(dGeomTriMeshDataCreate()) {
    for (const Vec3& v : mesh.vertices)
      coordinates_.insert(coordinates_.end(), v.data(), v.data() + 3);
    for (const Eigen::Vector3i& t : mesh.triangles)
      for (int k = 0; k < 3; ++k) indices_.push_back(static_cast<dTriIndex>(t[k]));
    dGeomTriMeshDataBuildDouble(data_, coordinates_.data(), 3 * sizeof(double),
                                int(mesh.vertices.size()), indices_.data(), int(indices_.size()),
                                3 * sizeof(dTriIndex));
    geometry_ = dCreateTriMesh(nullptr, data_, nullptr, nullptr, nullptr);
  }
  // A plane has no pose; place() sets its parameters.
  explicit OdeGeometry(const HalfSpace& plane)
      : geometry_(dCreatePlane(nullptr, 0, 0, 1, 0)), plane_(plane) {
    place({});
  }
  ~OdeGeometry() {
    dGeomDestroy(geometry_);
    if (data_ != nullptr) dGeomTriMeshDataDestroy(data_);
  }
  OdeGeometry(const OdeGeometry&) = delete;
  OdeGeometry& operator=(const OdeGeometry&) = delete;

  dGeomID id() const { return geometry_; }

  void place(const Pose& pose) {
    if (plane_) {
      const Vec3 n = pose.orientation * plane_->normal;
      dGeomPlaneSetParams(geometry_, n.x(), n.y(), n.z(), plane_->offset + n.dot(pose.position));
      return;
    }
    const Eigen::Quaterniond& q = pose.orientation;
    const dQuaternion quaternion = {q.w(), q.x(), q.y(), q.z()};
    dGeomSetPosition(geometry_, pose.position.x(), pose.position.y(), pose.position.z());
    dGeomSetQuaternion(geometry_, quaternion);
  }

 private:
  dTriMeshDataID data_ = nullptr;
  dGeomID geometry_ = nullptr;
  std::optional<HalfSpace> plane_;
  std::vector<double> coordinates_;
  std::vector<dTriIndex> indices_;
};

using Geometry = std::shared_ptr<OdeGeometry>;

struct PrimitiveMaker {
  Geometry operator()(const HalfSpace& s) const { return std::make_shared<OdeGeometry>(s); }
  Geometry operator()(const Sphere& s) const {
    return std::make_shared<OdeGeometry>(dCreateSphere(nullptr, s.radius));
  }
  Geometry operator()(const Box& s) const {
    const Vec3 size = 2 * s.halfExtents;
    return std::make_shared<OdeGeometry>(dCreateBox(nullptr, size.x(), size.y(), size.z()));
  }
  Geometry operator()(const Capsule& s) const {
    return std::make_shared<OdeGeometry>(dCreateCapsule(nullptr, s.radius, 2 * s.halfHeight));
  }
  Geometry operator()(const Cylinder& s) const {
    return std::make_shared<OdeGeometry>(dCreateCylinder(nullptr, s.radius, 2 * s.halfHeight));
  }
  Geometry operator()(const Cone&) const { throw CannotDo("ODE has no cone"); }
  Geometry operator()(const Hull&) const {
    throw CannotDo("ODE's convex hulls need libccd, which Debian's build lacks");
  }
  template <class Other>
  Geometry operator()(const Other&) const {
    throw CannotDo("the laboratory has no such body");
  }
};

bool isCylinder(const LabBody& body) {
  return std::holds_alternative<Cylinder>(*body.shape);
}
bool isCapsule(const LabBody& body) {
  return std::holds_alternative<Capsule>(*body.shape);
}

// dCollide returns no contact for pairs that it does not support; this throws for them.
void validate(const LabBody& a, const LabBody& b) {
  const bool round = (isCylinder(a) || isCapsule(a)) && (isCylinder(b) || isCapsule(b));
  if (round && (isCylinder(a) || isCylinder(b)))
    throw CannotDo(
        "ODE needs libccd for cylinder against cylinder or capsule; Debian's build lacks it");
}

class OdePair {
 public:
  OdePair(Geometry a, Geometry b)
      : a_(std::move(a)), b_(std::move(b)), contacts_(std::make_shared<Contacts>(kMaxContacts)) {}

  int collide(const Pose& b) const {
    b_->place(b);
    return dCollide(a_->id(), b_->id(), kMaxContacts, contacts_->data(), sizeof(dContactGeom));
  }

  std::vector<LabPoint> find(const Pose& b) const {
    startOde();
    const int count = collide(b);
    std::vector<LabPoint> points;
    for (int k = 0; k < count; ++k) {
      const dContactGeom& c = (*contacts_)[std::size_t(k)];
      const Vec3 intoA(c.normal[0], c.normal[1], c.normal[2]);
      // Where dCollide swaps the bodies it reverses the normals.
      points.push_back({Vec3(c.pos[0], c.pos[1], c.pos[2]), -intoA, c.depth, 0});
    }
    return points;
  }

 private:
  using Contacts = std::vector<dContactGeom>;
  Geometry a_, b_;
  std::shared_ptr<Contacts> contacts_;
};

LabPair odePair(Geometry a, Geometry b) {
  const OdePair pair(std::move(a), std::move(b));
  LabPair made = pairOf([pair](const Pose& pose) { return pair.find(pose); },
                        [pair](const Pose& pose) { pair.collide(pose); });
  const auto timed = made.microseconds;
  made.microseconds = [timed](const Pose& pose, int repeat, double jitter) {
    startOde();
    return timed(pose, repeat, jitter);
  };
  return made;
}

LabPair primitives(const LabBody& a, const LabBody& b, double) {
  startOde();
  const Solid &shapeA = primitiveOf(a), &shapeB = primitiveOf(b);
  validate(a, b);
  return odePair(std::visit(PrimitiveMaker{}, shapeA), std::visit(PrimitiveMaker{}, shapeB));
}

LabPair triangles(const LabBody& a, const LabBody& b, double tolerance) {
  startOde();
  const auto geometry = [&](const LabBody& body) {
    return isHalfSpace(body) ? std::visit(PrimitiveMaker{}, *body.shape)
                             : std::make_shared<OdeGeometry>(body.mesh(tolerance));
  };
  return odePair(geometry(a), geometry(b));
}

}  // namespace

std::vector<LabMethod> odeMethods() {
  const std::string limits = "up to 65,535 contacts, equal ones merged, in double";
  std::vector<LabMethod> methods = {{"ode", "primitives", 0, primitives,
                                     "ODE's sphere, box, capsule, cylinder and plane; " + limits}};
  for (const double facets : kFacetLadder)
    methods.push_back({"ode", "trimesh, facets " + fraction(facets), facets, triangles,
                       "dTriMesh (OPCODE) of " + facetsWithin(facets) + "; " + limits, true});
  return methods;
}

Version odeVersion() {
  return {"ODE", dODE_VERSION};
}

}  // namespace cloudcontact::program::lab
