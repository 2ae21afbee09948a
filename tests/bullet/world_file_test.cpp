// Worlds with clouds through Bullet's files: a loaded world goes on as the saved one, to the bit.
#include <cloudcontact/bullet/world_file.h>
#include <cloudcontact/bullet/world_importer.h>
#include <gtest/gtest.h>

#include "base/document_sample.h"
// First: Bullet's soft bodies declare a global named seed.
#include "bullet/dispatch_stage.h"

#include <BulletDynamics/ConstraintSolver/btHingeConstraint.h>
#include <BulletDynamics/ConstraintSolver/btPoint2PointConstraint.h>

#include <filesystem>
#include <fstream>

namespace cloudcontact::testing::world_file_test {
namespace {

namespace fs = std::filesystem;

constexpr double kVoxel = 0.0625;
// Bullet's files hold the sizes of its shapes in float: these are none that it would round.
constexpr btScalar kMargin = btScalar(0.0625);

const std::shared_ptr<const SurfaceField>& cube() {
  static const auto field = fieldOf(boxMesh({1, 1, 1}), kVoxel);
  return field;
}
const std::shared_ptr<const SurfaceField>& ball() {
  static const auto field = fieldOf(sphereMesh(0.5, 1e-3), kVoxel);
  return field;
}

// A world of a CloudContact, which keeps nothing but what is in it.
struct FileWorld {
  FileWorld() {
    clouds.attach(dispatcher);
    recommendedSettings(world);
    world.setGravity({0, 0, btScalar(-9.8125)});
  }
  ~FileWorld() {
    for (int i = world.getNumConstraints(); i-- > 0;)
      world.removeConstraint(world.getConstraint(i));
    for (int i = world.getNumCollisionObjects(); i-- > 0;)
      world.removeCollisionObject(world.getCollisionObjectArray()[i]);
  }
  void step() { world.stepSimulation(btScalar(1.0 / 128), 0); }
  std::uint64_t hash() const {
    Hash sum;
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); ++i) {
      const btRigidBody& body = *btRigidBody::upcast(objects[i]);
      for (int row = 0; row < 3; ++row) sum.add(body.getWorldTransform().getBasis()[row]);
      sum.add(body.getWorldTransform().getOrigin());
      sum.add(body.getLinearVelocity());
      sum.add(body.getAngularVelocity());
    }
    for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
      const btPersistentManifold& manifold =
          *const_cast<btCollisionDispatcher&>(dispatcher).getManifoldByIndexInternal(i);
      for (int k = 0; k < manifold.getNumContacts(); ++k) addTo(sum, manifold.getContactPoint(k));
    }
    return sum.value();
  }
  btRigidBody& body(int i) { return *btRigidBody::upcast(world.getCollisionObjectArray()[i]); }

  CloudContact clouds;  // first: it must outlive the dispatcher
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
};

// Bullet's importers own what they have loaded, and delete it when asked only.
template <typename Importer>
struct Owner : Importer {
  using Importer::Importer;
  ~Owner() { this->deleteAllData(); }
};

// Clouds on a cloud and on Bullet's plane, beside and on Bullet's boxes, in compounds, with joints.
struct SavedWorld : FileWorld {
  SavedWorld() {
    add(own(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), btScalar(0))), 0,
        at({0, 0, 0}));
    table = own(std::make_unique<CloudShape>(cube()));
    add(table, 0, at({0, 0, btScalar(0.5)}));
    first = &add(table, 1, at({btScalar(0.25), 0, btScalar(1.5)}));
    first->setAngularVelocity({0, 0, 2});
    auto* const soft = own(std::make_unique<CloudShape>(cube()));
    soft->law = KelvinVoigt{4000, 30};
    add(soft, 2, at({3, 0, btScalar(0.5)})).setLinearVelocity({1, btScalar(0.5), 0});
    auto* const slow = own(std::make_unique<CloudShape>(ball()));
    slow->law = StandardLinearSolid{2000, 3000, 50};
    add(slow, 1, at({6, 0, btScalar(0.55)})).setFriction(btScalar(0.75));
    auto* const round = own(std::make_unique<CloudShape>(ball()));
    round->setFidelity({0.05});
    EXPECT_NE(round->recognized(), nullptr);
    add(round, 1, at({9, 0, btScalar(0.6)})).setLinearVelocity({btScalar(-1), 0, 0});
    addCompound();
    const btVector3 half(btScalar(0.5), btScalar(0.5), btScalar(0.5));
    auto* const box = own(std::make_unique<btBoxShape>(half));
    box->setMargin(kMargin);
    for (int i = 0; i < 3; ++i) add(box, 1 + i, at({15, btScalar(0.125 * i), btScalar(0.5 + i)}));
    add(table, 1, at({15, 0, btScalar(3.5)}));  // on the boxes
    addJoints(*box);
  }
  ~SavedWorld() {
    for (auto& joint : joints) world.removeConstraint(joint.get());
    for (auto& body : bodies) world.removeRigidBody(body.get());
  }

  template <typename Shape>
  Shape* own(std::unique_ptr<Shape> shape) {
    Shape* const made = shape.get();
    shapes.push_back(std::move(shape));
    return made;
  }
  btRigidBody& add(btCollisionShape* shape, double mass, const btTransform& place) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape->calculateLocalInertia(btScalar(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, shape, inertia);
    info.m_startWorldTransform = place;
    bodies.push_back(std::make_unique<btRigidBody>(info));
    world.addRigidBody(bodies.back().get());
    return *bodies.back();
  }
  void addCompound() {
    auto* const compound = own(std::make_unique<btCompoundShape>());
    auto* const end =
        own(std::make_unique<btBoxShape>(btVector3(btScalar(0.25), btScalar(0.25), btScalar(0.5))));
    end->setMargin(kMargin);
    compound->addChildShape(at({btScalar(-0.75), 0, 0}), table);
    compound->addChildShape(at({btScalar(0.75), 0, 0}), table);
    compound->addChildShape(at({btScalar(1.75), 0, 0}), end);
    add(compound, 3, at({12, 4, btScalar(0.625)})).setAngularVelocity({0, 1, 0});
  }
  void addJoints(btBoxShape& box) {
    btRigidBody& door = add(table, 1, at({20, 0, 3}));
    btRigidBody& arm = add(&box, 1, at({22, 0, 3}));
    joints.push_back(std::make_unique<btHingeConstraint>(door, arm, btVector3(1, 0, 0),
                                                         btVector3(-1, 0, 0), btVector3(0, 1, 0),
                                                         btVector3(0, 1, 0)));
    world.addConstraint(joints.back().get(), true);
    joints.push_back(
        std::make_unique<btPoint2PointConstraint>(door, btVector3(btScalar(-0.5), 0, 1)));
    world.addConstraint(joints.back().get());
  }

  CloudShape* table = nullptr;
  btRigidBody* first = nullptr;
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<std::unique_ptr<btTypedConstraint>> joints;
};

class WorldFile : public ::testing::Test {
 protected:
  ~WorldFile() override { fs::remove(file()); }
  static fs::path file() {
    const auto* const info = ::testing::UnitTest::GetInstance()->current_test_info();
    return fs::temp_directory_path() / ("world_file_test_" + std::string(info->name()) +
                                        std::to_string(sizeof(btScalar)) + ".bullet");
  }
};

std::string messageOf(const std::function<void()>& work) {
  try {
    work();
  } catch (const std::runtime_error& why) {
    return why.what();
  }
  return {};
}

std::vector<char> bytesOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
void write(const fs::path& file, const std::vector<char>& bytes) {
  std::ofstream(file, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
}

TEST_F(WorldFile, GoesOnAsTheWorldThatWasNotSaved) {
  for (const int before : {0, 1, 60, 200}) {
    SavedWorld saved;
    for (int i = 0; i < before; ++i) saved.step();
    saveWorld(saved.world, saved.clouds, file());
    FileWorld loaded;
    Owner<CloudImporter> importer(&loaded.world, &loaded.clouds);
    importer.loadFile(file());
    ASSERT_EQ(loaded.world.getNumCollisionObjects(), saved.world.getNumCollisionObjects());
    ASSERT_EQ(loaded.world.getNumConstraints(), 2);
    if (before > 0) {
      EXPECT_GT(saved.dispatcher.getNumManifolds(), 5);
      EXPECT_EQ(loaded.hash(), saved.hash()) << "as loaded, after " << before;
    }
    for (int i = 0; i < 100; ++i) {
      saved.step();
      loaded.step();
      ASSERT_EQ(loaded.hash(), saved.hash()) << "step " << i << " after " << before;
    }
    EXPECT_EQ(loaded.clouds.statistics().failures, 0u) << loaded.clouds.statistics().lastFailure;
  }
}

// What Bullet's own serializer writes has no contacts; before the first step there are none.
TEST_F(WorldFile, BulletsSerializerKeepsAllButTheContacts) {
  SavedWorld saved;
  btDefaultSerializer serializer;
  saved.world.serialize(&serializer);
  std::vector<char> bytes(serializer.getBufferPointer(),
                          serializer.getBufferPointer() + serializer.getCurrentBufferSize());
  FileWorld loaded;
  Owner<CloudImporter> importer(&loaded.world, &loaded.clouds);
  importer.loadFileFromMemory(bytes.data(), int(bytes.size()));
  for (int i = 0; i < 100; ++i) {
    saved.step();
    loaded.step();
    ASSERT_EQ(loaded.hash(), saved.hash()) << "step " << i;
  }
}

TEST_F(WorldFile, KeepsWhatAShapeIs) {
  SavedWorld saved;
  const TissueTable tissues = {{"wood", 3e4, 5, 1e6, 500, 1e9}};
  auto* const shape = saved.own(std::make_unique<CloudShape>(ball()));
  shape->setTissues(tissues);
  shape->setUserIndex(17);
  shape->setMargin(btScalar(0.03125));
  PaperSettings paper;
  paper.area = PlacedSolid{Cone{0.5, 0.25, 0.125}, {}};
  paper.parts = {{PlacedSolid{Box{{1, 2, 3}}, {}}, 0.5}};
  shape->usePaper(paper);
  shape->setLocalScaling({2, 2, 2});
  shape->law = TableLaw{{{0.001, 5}, {0.002, 20}}, 3};
  saved.add(shape, 1, at({0, 20, 5}));
  CloudSerializer serializer(saved.world, saved.clouds);
  serializer.registerNameForPointer(shape, "the ball");
  serializer.registerNameForPointer(saved.first, "the first");
  saved.world.serialize(&serializer);
  serializer.save(file());

  FileWorld loaded;
  Owner<CloudImporter> importer(&loaded.world, &loaded.clouds);
  importer.loadFile(file());
  const btCollisionShape* const named = importer.getCollisionShapeByName("the ball");
  ASSERT_NE(named, nullptr);
  const CloudShape* const found = CloudShape::of(*named);
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->tissues(), tissues);
  EXPECT_EQ(found->getUserIndex(), 17);
  EXPECT_EQ(found->getMargin(), btScalar(0.03125));
  EXPECT_EQ(found->getLocalScaling().x(), 2);
  EXPECT_EQ(found->field().hash(), shape->field().hash());
  ASSERT_TRUE(found->law && std::holds_alternative<TableLaw>(*found->law));
  EXPECT_EQ(std::get<TableLaw>(*found->law).depthForce, std::get<TableLaw>(*shape->law).depthForce);
  EXPECT_TRUE(found->usesPaper());
  EXPECT_EQ(std::get<Cone>(found->paper()->area->solid).margin, 0.125);
  EXPECT_EQ(found->paper()->parts.at(0).ability, 0.5);
  EXPECT_EQ(importer.getRigidBodyByName("the first")->getAngularVelocity().z(), 2);
  // A shape in two places is one shape; shapes that shared a field still do.
  EXPECT_EQ(loaded.body(1).getCollisionShape(), loaded.body(2).getCollisionShape());
  EXPECT_EQ(&CloudShape::of(*loaded.body(1).getCollisionShape())->field(),
            &CloudShape::of(*loaded.body(3).getCollisionShape())->field());
}

TEST_F(WorldFile, KeepsWhatABodyIs) {
  SavedWorld saved;
  btRigidBody& body = *saved.first;
  body.setDamping(btScalar(0.25), btScalar(0.125));
  body.setRollingFriction(btScalar(0.5));
  body.setCcdMotionThreshold(btScalar(0.75));
  body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
  body.setMassProps(btScalar(0.3), btVector3(btScalar(0.1), btScalar(0.7), btScalar(0.9)));
  body.setActivationState(DISABLE_DEACTIVATION);
  saved.world.removeRigidBody(&body);
  saved.world.addRigidBody(&body, 64, 5);
  body.setGravity({1, 2, 3});
  saveWorld(saved.world, saved.clouds, file());
  FileWorld loaded;
  Owner<CloudImporter> importer(&loaded.world, &loaded.clouds);
  importer.loadFile(file());
  const btRigidBody& found = loaded.body(loaded.world.getNumCollisionObjects() - 1);
  EXPECT_EQ(found.getLinearDamping(), btScalar(0.25));
  EXPECT_EQ(found.getAngularDamping(), btScalar(0.125));
  EXPECT_EQ(found.getRollingFriction(), btScalar(0.5));
  EXPECT_EQ(found.getCcdMotionThreshold(), btScalar(0.75));
  EXPECT_EQ(found.getCollisionFlags(), body.getCollisionFlags());
  EXPECT_EQ(found.getInvMass(), body.getInvMass());
  EXPECT_EQ(found.getInvInertiaDiagLocal(), body.getInvInertiaDiagLocal());
  EXPECT_EQ(found.getActivationState(), DISABLE_DEACTIVATION);
  EXPECT_EQ(found.getGravity(), btVector3(1, 2, 3));
  EXPECT_EQ(found.getBroadphaseHandle()->m_collisionFilterGroup, 64);
  EXPECT_EQ(found.getBroadphaseHandle()->m_collisionFilterMask, 5);
}

TEST_F(WorldFile, BulletsImporterLeavesCloudsOut) {
  SavedWorld saved;
  // Bullet's importer crashes at a joint whose first body it has left out.
  for (auto& joint : saved.joints) saved.world.removeConstraint(joint.get());
  saveWorld(saved.world, saved.clouds, file());
  FileWorld loaded;
  Owner<btBulletWorldImporter> importer(&loaded.world);
  EXPECT_TRUE(importer.loadFile(file().c_str()));
  EXPECT_GT(loaded.world.getNumCollisionObjects(), 3);
}

std::string refusalOf(const fs::path& file) {
  FileWorld loaded;
  Owner<CloudImporter> importer(&loaded.world, &loaded.clouds);
  return messageOf([&] { importer.loadFile(file); });
}

// The samples of docs/bullet.md, in a folder of their own.
TEST_F(WorldFile, SamplesEqualTheDocument) {
  const fs::path before = fs::current_path();
  fs::current_path(file().parent_path());
  FileWorld saved, loaded;
  CloudShape shape(cube());
  btRigidBody body(1, nullptr, &shape, btVector3(1, 1, 1));
  saved.world.addRigidBody(&body);
  {
    btDynamicsWorld& world = saved.world;
    CloudContact& contact = saved.clouds;
    // save begins
    cloudcontact::saveWorld(world, contact, "scene.bullet");
    // save ends
  }
  {
    btDynamicsWorld& world = loaded.world;
    CloudContact& contact = loaded.clouds;
    // load begins
#include <cloudcontact/bullet/world_importer.h>  // links BulletWorldImporter and BulletFileLoader
    cloudcontact::CloudImporter importer(&world, &contact);
    importer.loadFile("scene.bullet");
    // load ends
    EXPECT_EQ(loaded.hash(), saved.hash());
    importer.deleteAllData();
    EXPECT_EQ(world.getNumCollisionObjects(), 0);
  }
  fs::remove("scene.bullet");
  fs::current_path(before);
  for (const char* const name : {"save", "load"})
    expectSample("docs/bullet.md", name, "tests/bullet/world_file_test.cpp");
}

TEST_F(WorldFile, CutOffAndDamagedFilesAreRefused) {
  SavedWorld saved;
  for (int i = 0; i < 20; ++i) saved.step();
  saveWorld(saved.world, saved.clouds, file());
  const std::vector<char> whole = bytesOf(file());
  for (std::size_t part = 0; part < 200; ++part) {
    std::vector<char> cut(whole.begin(), whole.begin() + std::ptrdiff_t(whole.size() * part / 200));
    write(file(), cut);
    const std::string why = refusalOf(file());
    EXPECT_NE(why.find(file().string()), std::string::npos) << part << ": " << why;
  }
  for (std::size_t part = 0; part < 200; ++part) {
    std::vector<char> damaged = whole;
    damaged[part * (whole.size() - 1) / 199] ^= 4;
    write(file(), damaged);
    // Bytes 9 to 11 are Bullet's version, which its checksum covers too.
    const std::string why = refusalOf(file());
    EXPECT_NE(why.find(file().string()), std::string::npos) << part << ": " << why;
  }
}

TEST_F(WorldFile, CutOffFilesOfBulletsSerializerAreRefused) {
  SavedWorld saved;
  btDefaultSerializer serializer;
  saved.world.serialize(&serializer);
  const std::vector<char> whole(serializer.getBufferPointer(),
                                serializer.getBufferPointer() + serializer.getCurrentBufferSize());
  for (std::size_t part = 0; part < 200; ++part) {
    write(file(), {whole.begin(), whole.begin() + std::ptrdiff_t(whole.size() * part / 200)});
    EXPECT_FALSE(refusalOf(file()).empty()) << part;
  }
  write(file(), whole);
  EXPECT_EQ(refusalOf(file()), "");
}

TEST_F(WorldFile, WhatCannotBeKeptIsSaid) {
  EXPECT_NE(refusalOf("/no/such/file.bullet").find("no such file"), std::string::npos);
  write(file(), {'B', 'U', 'L', 'L'});
  EXPECT_NE(refusalOf(file()).find("is no file of Bullet"), std::string::npos);
  SavedWorld saved;
  saved.table->law = UserLaw{[](double depth, double) { return 1e4 * depth; }};
  EXPECT_NE(messageOf([&] { saveWorld(saved.world, saved.clouds, file()); }).find("a function"),
            std::string::npos);
  btDefaultSerializer serializer;  // which does not ask
  saved.world.serialize(&serializer);
  write(file(), {serializer.getBufferPointer(),
                 serializer.getBufferPointer() + serializer.getCurrentBufferSize()});
  EXPECT_NE(refusalOf(file()).find("a function"), std::string::npos);
}

}  // namespace
}  // namespace cloudcontact::testing::world_file_test
