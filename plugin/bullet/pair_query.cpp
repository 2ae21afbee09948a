// Wrappers to ContactBody and ContactSettings.
#include "bullet/pair_query.h"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <cloudcontact/bullet/cloud_shape.h>

#include <algorithm>
#include <limits>

#include "bullet/convert.h"
#include "bullet/object_motion.h"
#include "contact/shape_contact.h"

namespace cloudcontact {

namespace {

constexpr const char* kNoShape =
    "a shape beside a CloudShape has neither volume nor triangles: diagnose() names it; make it a "
    "triangle mesh or a CloudShape";
constexpr const char* kBadPose = "a body's pose or velocity is NaN or infinite: it has no contacts";
constexpr const char* kUneven =
    "a CloudShape is scaled unevenly or not positively, so it has no contacts: scale the mesh and "
    "digitize it again";

bool isFinite(const ContactBody& body) {
  return body.pose.position.allFinite() && body.pose.orientation.coeffs().allFinite() &&
         body.motion.linear.allFinite() && body.motion.angular.allFinite();
}

void setPivot(const btCollisionObject& object, ContactBody& body) {
  body.pivot = body.pose.toLocal(body.motion.center);
  body.inverseInertia = inverseInertiaOf(object);
}

void moveBy(const Pose& way, ContactBody& body) {
  body.motion.center = way.toWorld(body.motion.center);
  body.pose = way * body.pose;
}

// Of the finest: laws and speeds must not depend on a level.
double voxelOf(const CloudShape* const clouds[2]) {
  double size = std::numeric_limits<double>::infinity();
  for (int side = 0; side < 2; ++side)
    if (clouds[side]) size = std::min(size, clouds[side]->voxelSize());
  return size;
}

// Stated base vectors know the finest voxels alone.
bool usesPaper(const CloudShape* const clouds[2]) {
  const auto asks = [](const CloudShape* cloud) { return cloud && cloud->usesPaper(); };
  return asks(clouds[0]) || asks(clouds[1]);
}

// Bodies nearer than this get points before they touch: a voxel, or how far fast ones move in a
// step. A little more, so that a face at the end of that way is not half out of reach by rounding.
double reachOf(double speed, double voxel, double step) {
  constexpr double kBeyond = 0.02;  // [voxels]
  return std::max(voxel, speed * step + kBeyond * voxel);
}

// At least closingSpeed(), which needs the fields that are yet to be chosen.
double closingSpeedOf(const CloudShape* const clouds[2], const ContactBody* const bodies[2]) {
  double speed = (bodies[0]->motion.linear - bodies[1]->motion.linear).norm();
  for (int side = 0; side < 2; ++side) {
    const Motion& motion = bodies[side]->motion;
    const int seen = clouds[side] ? side : 1 - side;  // a plane has no end
    const Eigen::AlignedBox3d box = clouds[seen]->bounds();
    const Vec3 center = bodies[seen]->pose.toLocal(motion.center);
    speed += motion.angular.norm() *
             (box.max() - center).cwiseAbs().cwiseMax((box.min() - center).cwiseAbs()).norm();
  }
  return speed;
}

bool samePlace(const ContactBody& x, const ContactBody& y) {
  return x.pose.position == y.pose.position &&
         x.pose.orientation.coeffs() == y.pose.orientation.coeffs() &&
         x.motion.linear == y.motion.linear && x.motion.angular == y.motion.angular &&
         x.motion.center == y.motion.center;
}

bool sameSpring(const KelvinVoigt& x, const KelvinVoigt& y) {
  return x.stiffness == y.stiffness && x.damping == y.damping;
}

bool sameBody(const ContactBody& x, const ContactBody& y) {
  return x.field == y.field && x.shape == y.shape && x.tissues == y.tissues && x.paper == y.paper &&
         x.inverseInertia == y.inverseInertia && x.spring.has_value() == y.spring.has_value() &&
         (!x.spring || sameSpring(*x.spring, *y.spring));
}

}  // namespace

const CloudShape* cloudOf(const btCollisionObjectWrapper& wrap) {
  return CloudShape::of(*wrap.getCollisionShape());
}

bool sameMatter(const PairQuery& x, const PairQuery& y) {
  return !x.wrong && !y.wrong && !x.apart && !y.apart && x.byShapes == y.byShapes &&
         sameBody(x.a, y.a) && sameBody(x.b, y.b) && x.lives[0] == y.lives[0] &&
         x.lives[1] == y.lives[1] && x.conversions == y.conversions &&
         x.settings.law.index() == y.settings.law.index() &&
         sameSpring(sharedSpring(x.settings.law), sharedSpring(y.settings.law)) &&
         x.settings.samples == y.settings.samples;
}

bool sameQuery(const PairQuery& x, const PairQuery& y) {
  return sameMatter(x, y) && samePlace(x.a, y.a) && samePlace(x.b, y.b);
}

ContactBody asShape(const ContactBody& body, const PlacedSolid* recognized) {
  if (!recognized) return body;
  ContactBody shape = body;
  shape.field = nullptr;
  shape.shape = &recognized->solid;
  shape.pose = body.pose * recognized->place;
  shape.pivot = recognized->place.toLocal(body.pivot);
  return shape;
}

void PairReader::readShapes(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
                            const btCollisionObjectWrapper& b, PairQuery& query) {
  if (settings.fidelity.exact || query.a.paper || query.b.paper) return;
  const CloudShape* const clouds[2] = {cloudOf(a), cloudOf(b)};
  const Solid* solids[2] = {query.a.shape, query.b.shape};
  for (int side = 0; side < 2; ++side) {
    if (!clouds[side]) continue;
    const RecognizedShape* const known = clouds[side]->recognized();
    if (!known || clouds[side]->tissues().size() > 1) return;
    query.recognized[side] = &known->placed;
    query.shapeError += known->error;
    solids[side] = &known->placed.solid;
  }
  query.byShapes = takesShapes(*solids[0], *solids[1], query.settings);
}

// What one of the bodies states; the other then has the usual base vectors.
void PairReader::readPaper(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                           PairQuery& query) {
  const CloudShape* const clouds[2] = {cloudOf(a), cloudOf(b)};
  if (!usesPaper(clouds)) return;
  ContactBody* const bodies[2] = {&query.a, &query.b};
  for (int side = 0; side < 2; ++side) {
    if (!clouds[side]) continue;
    paper_[side] = clouds[side]->paper();  // stays while the query does
    bodies[side]->paper = paper_[side].get();
  }
}

void PairReader::chooseLevels(const CloudContactSettings& settings,
                              const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                              PairQuery& query) const {
  const CloudShape* const clouds[2] = {cloudOf(a), cloudOf(b)};
  const Pose poses[2] = {query.a.pose, query.b.pose};
  ContactBody* const bodies[2] = {&query.a, &query.b};
  const double world = settings.fidelity.tolerance;
  query.levels = {};
  if (PairLevels::tolerance(clouds, world) > 0 && !usesPaper(clouds)) {
    const double speed = closingSpeedOf(clouds, bodies);
    query.levels =
        levels_.choose(clouds, poses, world, reachOf(speed, voxelOf(clouds), query.step));
  }
  PairLevels::apply(query.levels, clouds, bodies);
  query.settings.samples = settings.samples;
  if (query.levels.samples > 0)
    query.settings.samples = std::min(settings.samples, query.levels.samples);
}

// Kept ones, or chosen.
void PairReader::setLevels(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
                           const btCollisionObjectWrapper& b, PairQuery& query) {
  const CloudShape* const clouds[2] = {cloudOf(a), cloudOf(b)};
  const auto lives = [&](int side) {
    return !clouds[side] || clouds[side]->life() == shapesLevels_->lives[side];
  };
  if (shapesLevels_ && !(lives(0) && lives(1))) shapesLevels_.reset();
  if (!shapesLevels_) return chooseLevels(settings, a, b, query);
  ContactBody* const bodies[2] = {&query.a, &query.b};
  query.levels = shapesLevels_->choice;
  PairLevels::apply(query.levels, clouds, bodies);
  query.settings.samples = settings.samples;
}

// False if there is no query, and why.
bool PairReader::setBodies(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
                           const btCollisionObjectWrapper& b, double gap, const Touch* touch,
                           PairQuery& query) {
  const btCollisionObjectWrapper* const wraps[2] = {&a, &b};
  ContactBody* const bodies[2] = {&query.a, &query.b};
  for (int side = 0; side < 2; ++side) {
    bodies[side]->pose = toPose(wraps[side]->getWorldTransform());
    bodies[side]->motion = motionOf(*wraps[side]->getCollisionObject());
    if (touch) moveBy(side == 0 ? touch->a : touch->b, *bodies[side]);
    if (!isFinite(*bodies[side])) query.wrong = kBadPose;
    if (const char* const wrong = wrongMaterial(*wraps[side]->getCollisionObject()))
      query.wrong = wrong;
    const CloudShape* const cloud = cloudOf(*wraps[side]);
    if (cloud && !cloud->scalesEvenly()) query.wrong = kUneven;
  }
  if (!query.wrong) setLevels(settings, a, b, query);
  for (int side = 0; side < 2 && !query.wrong; ++side) {
    ContactBody& body = *bodies[side];
    if (body.field) continue;
    const btCollisionShape& shape = *wraps[side]->getCollisionShape();
    if (const PlacedSolid* const placed = converted_[side].of(shape)) {
      body.shape = &placed->solid;
      body.pose = body.pose * placed->place;
    } else if (hasTriangles(shape) && bodies[1 - side]->field) {
      body.shape = triangles_[side].of(shape, body.pose, *bodies[1 - side], gap, reading_);
      query.apart = !body.shape;
    } else {
      query.wrong = kNoShape;
    }
    query.conversions += converted_[side].conversions() + triangles_[side].changes();
  }
  for (int side = 0; side < 2; ++side) setPivot(*wraps[side]->getCollisionObject(), *bodies[side]);
  return !query.wrong && !query.apart;
}

PairQuery PairReader::read(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
                           const btCollisionObjectWrapper& b, double step, bool steps, double gap,
                           const Touch* touch) {
  PairQuery query;
  query.step = steps ? step : 0;
  if (!setBodies(settings, a, b, gap, touch, query)) return query;
  const CloudShape* const clouds[2] = {cloudOf(a), cloudOf(b)};
  const double inverse =
      inverseMass(*a.getCollisionObject()) + inverseMass(*b.getCollisionObject());
  query.mass = inverse > 0 ? 1 / inverse : 0;
  query.voxel = voxelOf(clouds);
  query.law = lawOf(settings, a, b, query.voxel, step);
  query.settings.law = query.law.shared;
  ContactBody* const bodies[2] = {&query.a, &query.b};
  for (int side = 0; side < 2; ++side) {
    bodies[side]->tissues = query.law.tissues[side];
    bodies[side]->spring = query.law.springs[side];
  }
  readPaper(a, b, query);
  readShapes(settings, a, b, query);
  for (int side = 0; side < 2; ++side)
    if (clouds[side]) query.lives[side] = clouds[side]->life();
  if (!query.byShapes)
    shapesLevels_.reset();
  else if (!shapesLevels_)
    shapesLevels_ = KeptLevels{query.levels, {query.lives[0], query.lives[1]}};
  if (steps) {
    query.settings.margin = reachOf(closingSpeed(query.a, query.b), query.voxel, step);
    query.pull[0] = accelerationOf(*a.getCollisionObject());
    query.pull[1] = accelerationOf(*b.getCollisionObject());
  }
  return query;
}

}  // namespace cloudcontact
