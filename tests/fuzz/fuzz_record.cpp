// What Bullet's files hold of ours: the chunks that are checked before Bullet reads them, the
// record of a shape, and the record of a world's contacts. Bullet's own loader is not ours.
#include <btBulletDynamicsCommon.h>
#include <cloudcontact/bullet/imported_world.h>
#include <cloudcontact/bullet/world_file.h>

#include "bullet/contact_record.h"
#include "bullet/shape_record.h"
#include "bullet/world_bytes.h"
#include "fuzz/fuzz_input.h"
#include "fuzz/fuzz_target.h"

namespace cloudcontact::fuzz {

namespace {

std::shared_ptr<const SurfaceField> ball() {
  static const auto field = fieldOf(smallBall());
  return field;
}

// Two balls that touch.
struct World {
  CloudContact clouds;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  CloudShape shape{ball()};
  btRigidBody a{1, nullptr, &shape, btVector3(1, 1, 1)}, b{1, nullptr, &shape, btVector3(1, 1, 1)};

  World() {
    clouds.attach(dispatcher);
    b.setWorldTransform(btTransform(btQuaternion::getIdentity(), {btScalar(0.009), 0, 0}));
    world.addRigidBody(&a), world.addRigidBody(&b);
    world.performDiscreteCollisionDetection();
  }
  ~World() { world.removeRigidBody(&a), world.removeRigidBody(&b); }
  World(const World&) = delete;
  World& operator=(const World&) = delete;
};

void shapeRecord(std::string_view bytes) {
  const std::string whole = sealed(kShapeKind, std::string(bytes));
  mayRefuse("", [&] {
    const ShapeRecord record = ShapeRecord::from(opened(kShapeKind, whole.data(), whole.size()));
    const auto shape = record.make(ball());
    btVector3 low, high;
    shape->getAabb(btTransform::getIdentity(), low, high);
    require(std::isfinite(low.x()) && std::isfinite(high.x()), "bounds that are not finite");
  });
}

void contactsRecord(std::string_view bytes) {
  World world;
  mayRefuse("", [&] {
    restoreContacts(world.world, ContactRecords::narrowPhaseOf(world.clouds), {&world.a, &world.b},
                    {bytes.data(), bytes.size()});
  });
  world.world.stepSimulation(btScalar(1e-3), 0);
}

void read(std::string_view input) {
  const int kind = input.empty() ? 0 : input[0] & 3;
  const std::string_view bytes = input.substr(input.empty() ? 0 : 1);
  if (kind == 0)
    mayRefuse("a.bullet", [&] { checkWorldBytes({bytes.data(), bytes.size()}, "a.bullet"); });
  if (kind == 1) shapeRecord(bytes);
  if (kind == 2) contactsRecord(bytes);
  if (kind == 3) mayRefuse("", [&] { opened(kContactsKind, bytes.data(), bytes.size()); });
}

std::vector<std::string> seeds() {
  World world;
  ShapeRecord record;
  record.law = KelvinVoigt{1e4, 10};
  record.tissues = {{"bone", 1e4, 1, 1e9, 1900}};
  ShapeRecord paper = record;
  paper.law = TableLaw{{{0, 0}, {1e-3, 5}}, 1};
  paper.usesPaper = true;
  paper.paper.area = PlacedSolid{Box{Vec3(1, 1, 1)}, {}};
  paper.paper.parts = {{PlacedSolid{Sphere{0.1}, {}}, 2}};
  CloudSerializer file(world.world, world.clouds);
  world.world.serialize(&file);
  std::string whole(1, '\0');
  whole.append(reinterpret_cast<const char*>(file.getBufferPointer()),
               std::size_t(file.getCurrentBufferSize()));
  const std::string contacts = contactsOf(world.world, ContactRecords::narrowPhaseOf(world.clouds));
  return {whole, '\1' + record.bytes(), '\1' + paper.bytes(), '\2' + contacts,
          '\3' + sealed(kContactsKind, contacts)};
}

}  // namespace

Target recordTarget() {
  return {"record", read, seeds, 1 << 17};
}

}  // namespace cloudcontact::fuzz
