// Scaling, timing and names for all peers; the list of peers outside Bullet.
#include "lab/peer_pairs.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
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
  Solid operator()(const SurfaceSolid&) const { throw CannotDo("the laboratory has no such body"); }
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

// Wraps a pair of scaled bodies as a pair of the original ones.
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

// Direction of the k-th jitter: spread evenly over the sphere, equal on every run.
Vec3 jitterDirection(int k) {
  const double height = std::fmod(k * std::numbers::phi, 1.0) * 2 - 1;
  const double angle = 2.399963229728653 * k, radius = std::sqrt(1 - height * height);
  return {radius * std::cos(angle), radius * std::sin(angle), height};
}

}  // namespace

std::vector<double> timedCalls(const Pose& b, int repeat, double jitter,
                               const std::function<void(const Pose&)>& call) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> times;
  for (int k = -1; k < repeat; ++k) {
    Pose moved = b;
    moved.position += jitter * jitterDirection(k + 1);
    const auto start = Clock::now();
    call(moved);
    const std::chrono::duration<double, std::micro> time = Clock::now() - start;
    if (k >= 0) times.push_back(time.count());
  }
  return times;
}

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

LabMethod atMeterScale(const LabMethod& method) {
  LabMethod scaling = method;
  scaling.meterScale = true;
  scaling.prepare = [prepare = method.prepare](const LabBody& a, const LabBody& b, double detail) {
    // Detail 0 means primitives: throws where a body is none.
    if (detail == 0) primitiveOf(a), primitiveOf(b);
    const double smaller = std::min(reachOf(a, detail), reachOf(b, detail));
    const double factor = std::isfinite(smaller) && smaller > 0 ? 1 / smaller : 1;
    return scaledBack(prepare(scaled(a, factor), scaled(b, factor), factor * detail), factor);
  };
  return scaling;
}

std::string whyMeterScale() {
  return "Peers get both bodies scaled so that the smaller one reaches 1 m from its origin; their "
         "answers are scaled back. Their tolerances are absolute and made for bodies of about that "
         "size, and their manuals advise such units. At the true size of centimeters several of "
         "them "
         "would be less accurate. CloudContact gets the bodies at their true size.";
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
    for (const LabMethod& method : methods) all.push_back(atMeterScale(method));
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
