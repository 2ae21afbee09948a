// Finds the frame of a body, digitizes it there, and gives it to Bullet.
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <cloudcontact/bullet/cloud_body.h>
#include <cloudcontact/voxels/digitize.h>
#include <cloudcontact/voxels/matter_sums.h>

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "bullet/convert.h"

namespace cloudcontact {

namespace {

[[noreturn]] void refuseBody(const char* field, double value, const char* wanted) {
  std::ostringstream message;
  message << "CloudBody: " << field << " is " << value << ", must be " << wanted;
  throw std::invalid_argument(message.str());
}

// Rounding and many small turns leave a transform that is rigid to this. Each entry.
constexpr double kRigid = 0.01;

bool isRigid(const btTransform& place) {
  const btMatrix3x3& basis = place.getBasis();
  const btMatrix3x3 square = basis.transposeTimes(basis);
  bool is = basis.determinant() > 0 && toVec3(place.getOrigin()).allFinite();
  for (int i = 0; i < 3; ++i)
    is &= toVec3(square[i] - btMatrix3x3::getIdentity()[i]).cwiseAbs().maxCoeff() <= kRigid;
  return is;
}

// Bullet keeps its inverse.
bool isTooLight(double mass) {
  return mass > 0 && !std::isfinite(btScalar(1) / btScalar(mass));
}

void validate(const CloudBodySettings& settings, const btTransform& place) {
  const auto isBad = [](double value) { return !(value >= 0) || !std::isfinite(value); };
  if (isBad(settings.voxelSize))
    refuseBody("voxelSize", settings.voxelSize, "positive, or 0 to take it from the size [m]");
  if (settings.mass && (isBad(*settings.mass) || isTooLight(*settings.mass)))
    refuseBody("mass", *settings.mass, "positive, or 0 for a fixed body [kg]");
  if (!isRigid(place))
    throw std::invalid_argument(
        "CloudBody: place is NaN, scaled, mirrored or sheared; give a rigid transform");
}

bool isFixed(const CloudBodySettings& settings) {
  return settings.mass && *settings.mass == 0;
}

std::vector<double> densitiesOf(const CloudBodySettings& settings, const Cloud& cloud) {
  if (settings.tissues.empty()) return settings.densities;
  std::vector<double> densities;
  for (const Tissue& tissue : tissuesOf(settings.tissues, cloud.materials()))
    densities.push_back(tissue.density);
  return densities;
}

std::vector<NamedMesh> inFrame(std::vector<NamedMesh> parts, const Pose& frame) {
  for (NamedMesh& part : parts)
    for (Vec3& vertex : part.mesh.vertices) vertex = frame.toLocal(vertex);
  return parts;
}

// A body's matter in Bullet's frame.
struct WeighedCloud {
  Cloud cloud;
  Pose frame;         // Bullet's, in the mesh's frame
  Pose cloudInFrame;  // turned only where the voxels could not be
  double mass = 0;
  Vec3 inertia = Vec3::Zero();
  DigitizeReport report = {};
};

// About its center of mass. Its axes stay: its products of inertia are known to be small.
void weigh(WeighedCloud& body, const CloudBodySettings& settings) {
  const MassProperties matter = massPropertiesOf(body.cloud, densitiesOf(settings, body.cloud));
  body.cloud = body.cloud.translated(-matter.centerOfMass);
  body.frame = body.frame * Pose{Eigen::Quaterniond::Identity(), matter.centerOfMass};
  body.mass = settings.mass.value_or(matter.mass);
  body.inertia = body.mass / matter.mass * matter.inertia.diagonal();
}

Eigen::Quaterniond axesOf(const Cloud& cloud, const CloudBodySettings& settings) {
  const MassProperties matter = massPropertiesOf(cloud, densitiesOf(settings, cloud));
  return principalAxes(matter.inertia, Eigen::Quaterniond::Identity(), kDiagonalEnough).orientation;
}

WeighedCloud weighed(const std::vector<NamedMesh>& parts, const CloudBodySettings& settings) {
  DigitizeSettings how;
  how.voxelSize = settings.voxelSize > 0 ? settings.voxelSize : suggestedVoxel(merged(parts));
  how.maxBytes = settings.maxBytes;
  how.threads = settings.threads;
  WeighedCloud body;
  body.cloud = digitize(parts, how, &body.report);
  if (isFixed(settings)) return body;
  body.frame.orientation = axesOf(body.cloud, settings);
  if (!body.frame.orientation.vec().isZero())
    body.cloud = digitize(inFrame(parts, body.frame), how, &body.report);
  weigh(body, settings);
  return body;
}

WeighedCloud weighed(const Cloud& cloud, const CloudBodySettings& settings) {
  if (cloud.empty()) throw std::invalid_argument("CloudBody: the cloud is empty; digitize a mesh");
  WeighedCloud body;
  body.cloud = cloud;
  if (isFixed(settings)) return body;
  const MassProperties matter = massPropertiesOf(cloud, densitiesOf(settings, cloud));
  weigh(body, settings);
  const PrincipalAxes principal = principalAxes(body.mass / matter.mass * matter.inertia,
                                                Eigen::Quaterniond::Identity(), kDiagonalEnough);
  body.inertia = principal.moments;
  body.cloudInFrame.orientation = principal.orientation.conjugate();
  body.frame.orientation = principal.orientation;
  return body;
}

// In a frame that fields have already.
WeighedCloud inPlace(const Cloud& cloud, const CloudBodySettings& settings) {
  WeighedCloud body;
  body.cloud = cloud;
  if (isFixed(settings)) return body;
  const MassProperties matter = massPropertiesOf(cloud, densitiesOf(settings, cloud));
  const PrincipalAxes principal =
      principalAxes(matter.inertia, Eigen::Quaterniond::Identity(), kDiagonalEnough);
  body.frame = {principal.orientation, matter.centerOfMass};
  body.cloudInFrame = body.frame.inverse();
  body.mass = settings.mass.value_or(matter.mass);
  body.inertia = body.mass / matter.mass * principal.moments;
  return body;
}

// Between the caller's motion state, which knows the mesh, and Bullet, which knows the body.
class MeshMotion : public btMotionState {
 public:
  MeshMotion(btMotionState& mesh, const Pose& frame)
      : mesh_(mesh), bodyToMesh_(toBullet(frame)), meshToBody_(toBullet(frame.inverse())) {}
  void getWorldTransform(btTransform& body) const override {
    mesh_.getWorldTransform(body);
    body = body * bodyToMesh_;
  }
  void setWorldTransform(const btTransform& body) override {
    mesh_.setWorldTransform(body * meshToBody_);
  }

 private:
  btMotionState& mesh_;
  btTransform bodyToMesh_, meshToBody_;
};

}  // namespace

struct CloudBody::State {
  Pose frame;         // of the body in the mesh's frame
  Pose cloudInFrame;  // of the cloud in the body's
  DigitizeReport report;
  CloudShape shape;
  std::unique_ptr<btCompoundShape> turned;  // where the cloud does not lie along the body's axes
  std::unique_ptr<btMotionState> motion;    // a MeshMotion
  std::unique_ptr<btRigidBody> body;
  btDynamicsWorld* world = nullptr;

  State(const WeighedCloud& made, CloudShape shaped, const CloudBodySettings& settings);
  State(const State& like, const Pose& place);
  ~State() { leaveWorld(); }

  void makeBody(double mass, const btVector3& inertia, const Pose& place);
  void leaveWorld() {
    if (world) world->removeRigidBody(body.get());
    world = nullptr;
  }
};

namespace {

// With a tolerance, fields are built for the contacts that ask for them.
CloudShape shapeOfBody(const Cloud& cloud, const CloudBodySettings& settings) {
  FieldSettings how;
  how.threads = settings.threads;
  if (settings.fidelity.tolerance > 0)
    return CloudShape(std::make_shared<const FieldLevels>(cloud, how));
  return CloudShape(SurfaceField::build(cloud, how));
}

}  // namespace

CloudBody::State::State(const WeighedCloud& made, CloudShape shaped,
                        const CloudBodySettings& settings)
    : frame(made.frame),
      cloudInFrame(made.cloudInFrame),
      report(made.report),
      shape(std::move(shaped)) {
  if (settings.law) cloudcontact::validate(*settings.law);
  shape.law = settings.law;
  if (!settings.tissues.empty())
    shape.setTissues(tissuesOf(settings.tissues, made.cloud.materials()));
  shape.setFidelity(settings.fidelity);
  if (settings.motionState) motion = std::make_unique<MeshMotion>(*settings.motionState, frame);
}

CloudBody::State::State(const State& like, const Pose& place)
    : frame(like.frame), cloudInFrame(like.cloudInFrame), report(like.report), shape(like.shape) {
  const double inverse = like.body->getInvMass();
  makeBody(inverse > 0 ? 1 / inverse : 0, like.body->getLocalInertia(), place);
}

void CloudBody::State::makeBody(double mass, const btVector3& inertia, const Pose& place) {
  btCollisionShape* root = &shape;
  if (!cloudInFrame.orientation.vec().isZero() || !cloudInFrame.position.isZero(0)) {
    turned = std::make_unique<btCompoundShape>(false, 1);
    turned->addChildShape(toBullet(cloudInFrame), &shape);
    root = turned.get();
  }
  btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(mass), nullptr, root,
                                                inertia);
  info.m_startWorldTransform = toBullet(place * frame);
  body = std::make_unique<btRigidBody>(info);
  if (!motion) return;
  motion->setWorldTransform(info.m_startWorldTransform);
  body->setMotionState(motion.get());
}

CloudBody::CloudBody(const std::vector<NamedMesh>& parts, const btTransform& place,
                     const CloudBodySettings& settings) {
  validate(settings, place);
  for (const NamedMesh& part : parts) cloudcontact::validate(part.mesh);
  const WeighedCloud made = weighed(parts, settings);
  state_ = std::make_unique<State>(made, shapeOfBody(made.cloud, settings), settings);
  state_->makeBody(made.mass, toBullet(made.inertia), toPose(place));
}

CloudBody::CloudBody(const Mesh& mesh, const btTransform& place, const CloudBodySettings& settings)
    : CloudBody(std::vector<NamedMesh>{{"", mesh}}, place, settings) {}

CloudBody::CloudBody(const Cloud& cloud, const btTransform& place,
                     const CloudBodySettings& settings) {
  validate(settings, place);
  const WeighedCloud made = weighed(cloud, settings);
  state_ = std::make_unique<State>(made, shapeOfBody(made.cloud, settings), settings);
  state_->makeBody(made.mass, toBullet(made.inertia), toPose(place));
}

void CloudBody::make(const Cloud& cloud, CloudShape shape, const btTransform& place,
                     const CloudBodySettings& settings) {
  validate(settings, place);
  const WeighedCloud made = inPlace(cloud, settings);
  state_ = std::make_unique<State>(made, std::move(shape), settings);
  state_->makeBody(made.mass, toBullet(made.inertia), toPose(place));
}

CloudBody::CloudBody(std::shared_ptr<const SurfaceField> field, const btTransform& place,
                     const CloudBodySettings& settings) {
  if (!field) throw std::invalid_argument("CloudBody: the field is null; build one");
  if (settings.fidelity.tolerance > 0)
    make(field->cloud(), shapeOfBody(field->cloud(), settings), place, settings);
  else
    make(field->cloud(), CloudShape(field), place, settings);
}

CloudBody::CloudBody(std::shared_ptr<const FieldLevels> levels, const btTransform& place,
                     const CloudBodySettings& settings) {
  if (!levels) throw std::invalid_argument("CloudBody: the levels are null; make some");
  make(levels->cloud(), CloudShape(levels), place, settings);
}

CloudBody::CloudBody(const CloudBody& like, const btTransform& place) {
  validate({}, place);
  state_ = std::make_unique<State>(*like.state_, toPose(place));
}

CloudBody::~CloudBody() = default;
CloudBody::CloudBody(CloudBody&& other) noexcept = default;
CloudBody& CloudBody::operator=(CloudBody&& other) noexcept = default;

btRigidBody& CloudBody::body() {
  return *state_->body;
}
const btRigidBody& CloudBody::body() const {
  return *state_->body;
}
CloudShape& CloudBody::shape() {
  return state_->shape;
}
const CloudShape& CloudBody::shape() const {
  return state_->shape;
}
const DigitizeReport& CloudBody::report() const {
  return state_->report;
}

btTransform CloudBody::meshToBody() const {
  return toBullet(state_->frame.inverse());
}
btTransform CloudBody::bodyToMesh() const {
  return toBullet(state_->frame);
}
btTransform CloudBody::meshPlace() const {
  return toBullet(toPose(state_->body->getWorldTransform()) * state_->frame.inverse());
}

void CloudBody::setMeshPlace(const btTransform& place) {
  validate({}, place);
  btRigidBody& body = *state_->body;
  body.setCenterOfMassTransform(toBullet(toPose(place) * state_->frame));
  body.setInterpolationWorldTransform(body.getWorldTransform());
  if (state_->motion) state_->motion->setWorldTransform(body.getWorldTransform());
  body.activate();
  if (state_->world) state_->world->updateSingleAabb(&body);
}

void CloudBody::addTo(btDynamicsWorld& world) {
  leaveWorld();
  world.addRigidBody(state_->body.get());
  state_->world = &world;
}

void CloudBody::addTo(btDynamicsWorld& world, int group, int mask) {
  leaveWorld();
  world.addRigidBody(state_->body.get(), group, mask);
  state_->world = &world;
}

void CloudBody::leaveWorld() {
  state_->leaveWorld();
}

btDynamicsWorld* CloudBody::world() const {
  return state_->world;
}

}  // namespace cloudcontact
