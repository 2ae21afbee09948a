// CloudContact as a method of the laboratory, by fitted normals and by base vectors: both bodies
// digitized, the voxel a share of the case's size.
#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/contact/contact_finder.h>
#include <cloudcontact/voxels/digitize.h>

#include <cmath>
#include <cstdio>
#include <memory>

#include "lab/lab_meshes.h"
#include "lab/pair.h"
#include "scene/bullet_methods.h"
#include "scene/pair_probe.h"

namespace cloudcontact::program::lab {
namespace {

// Facet tolerance of primitives [voxels], far below the error of digitizing.
constexpr double kFacets = 0.004;

struct Side {
  std::shared_ptr<const SurfaceField> field;
  std::optional<Solid> plane;
  std::shared_ptr<btCollisionShape> shape;
  std::shared_ptr<const PaperBody> paper;  // for base vectors
  Pose grid;
  double volume = 0;  // [m^3]

  ContactBody at(const Pose& pose) const {
    ContactBody body;
    body.field = field.get();
    body.shape = plane ? &*plane : nullptr;
    body.paper = paper.get();
    body.pose = pose * grid;
    return body;
  }
};

// `window`: radius of the base vectors' C [voxels]; 0: fitted normals.
Side sideOf(const LabBody& body, double voxel, double window) {
  Side side;
  if (!body.mesh) {
    side.plane = body.shape;
    side.shape = primitiveShape(*body.shape).shape;
    return side;
  }
  side.grid = body.grid;
  DigitizeSettings settings;
  settings.voxelSize = voxel;
  const Cloud cloud = digitize(moved(body.mesh(kFacets * voxel), body.grid.inverse()), settings);
  side.volume = cloud.massProperties().volume;
  side.field = SurfaceField::build(cloud);
  const auto shape = std::make_shared<CloudShape>(side.field);
  side.shape = shape;
  if (window > 0) {
    PaperSettings paper;
    paper.window = sphereWindow(voxel, window);
    shape->usePaper(paper);
    side.paper = shape->paper();
  }
  return side;
}

// A point's share of the pair's spring is its stiffness; damping is 0 here.
std::vector<LabPoint> pointsOf(const ContactResult& result, double stiffness) {
  std::vector<LabPoint> points;
  for (const ContactPoint& p : result.points)
    if (p.depth > 0) points.push_back({p.position, p.normal, p.depth, p.stiffness / stiffness});
  return points;
}

LabPair pairOf(const std::shared_ptr<const Side>& a, const std::shared_ptr<const Side>& b,
               Method method) {
  const auto finder = std::make_shared<ContactFinder>();
  LabPair pair;
  ContactSettings settings;
  settings.law = KelvinVoigt{1, 0};
  pair.find = [=](const Pose& pose) {
    return pointsOf(finder->find(a->at(Pose{}), b->at(pose), settings), 1);
  };
  pair.work = [=](const Pose& pose) {
    ContactFinder first;
    first.find(a->at(Pose{}), b->at(pose), settings);
    return first.work();
  };
  pair.microseconds = [=](const Pose& pose, int repeat, double jitter) {
    // The probe has A's grid at the origin.
    const Pose seen = a->grid.inverse() * pose * b->grid;
    CloudContactSettings law{KelvinVoigt{1e4, 0}};
    law.fidelity.exact = true;  // the voxels' own contact
    law.reuseMotion = 0;        // every call searches
    PairProbe probe(*a->shape, *b->shape, seen, Motion{}, method, law);
    return probe.microseconds(repeat, jitter);
  };
  if (!a->plane && !b->plane) pair.volume = a->volume + b->volume;
  pair.swapped = [=] { return pairOf(b, a, method); };
  return pair;
}

LabPair prepared(const LabBody& a, const LabBody& b, double voxel, double window) {
  return pairOf(std::make_shared<Side>(sideOf(a, voxel, window)),
                std::make_shared<Side>(sideOf(b, voxel, window)),
                window > 0 ? Method::Paper : Method::Cloud);
}

LabPair prepare(const LabBody& a, const LabBody& b, double voxel) {
  return prepared(a, b, voxel, 0);
}

constexpr int kPaperParts = 32;                    // voxels in a case's size
constexpr double kPaperWindows[] = {1.5, 2.5, 4};  // radii of C [voxels]

constexpr const char* kDescription =
    "both bodies digitized with default settings, at their true size, on randomly rotated and "
    "shifted "
    "grids (six for the errors, two at 1/64, one in the quick run); contacts with default "
    "settings; "
    "timed is Bullet's processCollision of the pair";

}  // namespace

std::vector<LabMethod> cloudMethods() {
  std::vector<LabMethod> methods;
  for (const int parts : {4, 8, 16, 32, 64})
    methods.push_back(
        {"cloud", "voxel = size / " + std::to_string(parts), 1.0 / parts, prepare, kDescription});
  return methods;
}

std::vector<LabMethod> paperMethods() {
  std::vector<LabMethod> methods;
  for (const double window : kPaperWindows) {
    char setting[24];
    std::snprintf(setting, sizeof setting, "window %.3g", window);
    methods.push_back({"paper", setting, 1.0 / kPaperParts,
                       [window](const LabBody& a, const LabBody& b, double voxel) {
                         return prepared(a, b, voxel, window);
                       },
                       "as CloudContact, voxel = size / " + std::to_string(kPaperParts) +
                           ", but with the paper's base vectors in place of fitted normals; C is "
                           "a smooth sphere of the window's radius in voxels, Gr its center"});
  }
  return methods;
}

bool isOwn(const std::string& method) {
  return method == "cloud" || method == "paper";
}

}  // namespace cloudcontact::program::lab
