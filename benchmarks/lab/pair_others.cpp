// The peers outside Bullet as one list, and what all peers share.
#include "lab/pair_others.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cloudcontact::program::lab {

namespace {

struct Scaler {
  double factor;

  Solid operator()(HalfSpace s) const {
    s.offset *= factor;
    return s;
  }
  Solid operator()(const Sphere& s) const { return Sphere{factor * s.radius}; }
  Solid operator()(const Box& s) const { return Box{factor * s.halfExtents}; }
  Solid operator()(const Capsule& s) const {
    return Capsule{factor * s.radius, factor * s.halfHeight};
  }
  Solid operator()(const Cylinder& s) const {
    return Cylinder{factor * s.radius, factor * s.halfHeight};
  }
  Solid operator()(const Ellipsoid& s) const { return Ellipsoid{factor * s.semiAxes}; }
  Solid operator()(const CloudSolid&) const { throw CannotDo("the laboratory has no such body"); }
  Solid operator()(const Cone& s) const {
    return Cone{factor * s.radius, factor * s.halfHeight, factor * s.margin};
  }
  Solid operator()(Hull s) const {
    for (HalfSpace& plane : s.planes) plane.offset *= factor;
    for (Vec3& corner : s.corners) corner *= factor;
    s.margin *= factor;
    return s;
  }
};

LabBody scaled(const LabBody& body, double factor) {
  LabBody larger = body;
  if (body.shape) larger.shape = std::visit(Scaler{factor}, *body.shape);
  larger.mesh = [mesh = body.mesh, factor](double tolerance) {
    return mesh(tolerance / factor).scaled(Vec3::Constant(factor));
  };
  return larger;
}

Pose scaled(const Pose& pose, double factor) {
  return {pose.orientation, factor * pose.position};
}

// A pair of bodies made larger by the factor, as one of the bodies themselves.
LabPair scaledBack(const LabPair& pair, double factor) {
  LabPair back;
  back.find = [pair, factor](const Pose& pose) {
    std::vector<LabPoint> points = pair.find(scaled(pose, factor));
    for (LabPoint& p : points) {
      p.position /= factor;
      p.depth /= factor;
    }
    return points;
  };
  back.microseconds = [pair, factor](const Pose& pose, int repeat, double jitter) {
    return pair.microseconds(scaled(pose, factor), repeat, factor * jitter);
  };
  if (pair.swapped) back.swapped = [pair, factor] { return scaledBack(pair.swapped(), factor); };
  return back;
}

}  // namespace

double reachOf(const LabBody& body, double tolerance) {
  if (isHalfSpace(body)) return std::numeric_limits<double>::infinity();
  double reach = 0;
  if (body.shape) {
    const Eigen::AlignedBox3d box = boundsOf(*body.shape);
    reach = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).norm();
  } else {
    for (const Vec3& v : body.mesh(tolerance).vertices) reach = std::max(reach, v.norm());
  }
  return reach;
}

LabMethod atMetreScale(const LabMethod& method) {
  LabMethod scaling = method;
  scaling.metreScale = true;
  scaling.prepare = [prepare = method.prepare](const LabBody& a, const LabBody& b, double detail) {
    // Primitives have no detail, and their reach needs no mesh; what is none cannot be one.
    if (detail == 0) primitiveOf(a), primitiveOf(b);
    const double smaller = std::min(reachOf(a, detail), reachOf(b, detail));
    const double factor = std::isfinite(smaller) && smaller > 0 ? 1 / smaller : 1;
    return scaledBack(prepare(scaled(a, factor), scaled(b, factor), factor * detail), factor);
  };
  return scaling;
}

std::string whyMetreScale() {
  return "Peers see both bodies scaled so that the smaller reaches 1 m from its origin, and their "
         "answers scaled back: their tolerances are in metres, made for bodies of about that size, "
         "and their users are told to choose units so. At their true size of centimetres several "
         "would answer worse. CloudContact sees the bodies as they are.";
}

std::string fraction(double detail) {
  return "1/" + std::to_string(std::lround(1 / detail));
}

std::string facetsWithin(double detail) {
  return "facets within " + fraction(detail) + " of the size";
}

bool isHalfSpace(const LabBody& body) {
  return body.shape && std::holds_alternative<HalfSpace>(*body.shape);
}

const Solid& primitiveOf(const LabBody& body) {
  if (!body.shape) throw CannotDo(body.name + " is not a primitive");
  return *body.shape;
}

std::vector<LabPoint> touching(std::vector<LabPoint> points) {
  std::erase_if(points, [](const LabPoint& p) { return !(p.depth > 0); });
  for (LabPoint& p : points) p.share = 1.0 / double(points.size());
  return points;
}

LabPair pairOf(const std::function<std::vector<LabPoint>(const Pose& b)>& find,
               const std::function<void(const Pose& b)>& narrowPhase) {
  return {[find](const Pose& b) { return touching(find(b)); },
          [narrowPhase](const Pose& b, int repeat, double jitter) {
            return timedCalls(b, repeat, jitter, narrowPhase);
          },
          {},
          {}};
}

#ifdef CLOUDCONTACT_PEERS

std::vector<Version> peerVersions() {
  return {fclVersion(), odeVersion(), mujocoVersion(), {"libccd", CLOUDCONTACT_CCD_VERSION}};
}

std::vector<LabMethod> otherMethods() {
  std::vector<LabMethod> all;
  for (auto& methods : {fclMethods(), odeMethods(), mujocoMethods()})
    for (const LabMethod& method : methods) all.push_back(atMetreScale(method));
  return all;
}

#else

std::vector<Version> peerVersions() {
  return {};
}

std::vector<LabMethod> otherMethods() {
  const auto missing = [](const std::string& method, const std::string& library) {
    return LabMethod{method, "not built", 0,
                     [library](const LabBody&, const LabBody&, double) -> LabPair {
                       throw CannotDo("built without " + library);
                     }};
  };
  return {missing("fcl", "FCL"), missing("ode", "ODE"), missing("mujoco", "MuJoCo")};
}

#endif

}  // namespace cloudcontact::program::lab
