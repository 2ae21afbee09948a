// Worlds with clouds through Bullet's files: a loaded world goes on as the saved one, to the bit.
#include <cloudcontact/bullet/world_file.h>
#include <cloudcontact/bullet/world_importer.h>
#include <gtest/gtest.h>

#include "base/document_sample.h"
#include "bullet/saved_world.h"

#include <filesystem>
#include <fstream>

namespace cloudcontact::testing::world_file_test {
namespace {

namespace fs = std::filesystem;

using namespace saved_world;

// Bullet's importers own what they have loaded, and delete it when asked only.
template <typename Importer>
struct Owner : Importer {
  using Importer::Importer;
  ~Owner() { this->deleteAllData(); }
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
