// Scenes from SDFormat text: values, absent elements, and messages for bad input.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>

#include "io/errors.h"
#include "scene/scene_file.h"

namespace cloudcontact::program::sim_scene_test {
namespace {

// A temporary folder for each test.
class SceneTest : public ::testing::Test {
 protected:
  SceneTest() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("cloudcontact_") + info->test_suite_name() + "_" + info->name());
    std::filesystem::create_directories(folder_ / "meshes");
    std::ofstream(folder_ / "meshes" / "part.obj") << "v 0 0 0\n";
  }
  ~SceneTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& text) const {
    std::ofstream(folder_ / "scene.sdf") << text;
    return folder_ / "scene.sdf";
  }
  SceneDescription load(const std::string& text) const { return loadScene(write(text)); }

  std::filesystem::path folder_;
};

std::string world(const std::string& inner) {
  return "<?xml version=\"1.0\"?>\n<sdf version=\"1.9\"><world name=\"w\">" + inner +
         "</world></sdf>";
}

std::string ball(const std::string& inner = "", const std::string& surface = "") {
  return "<model name=\"ball\"><pose>0 0 1 0 0 0</pose><link name=\"l\">" + inner +
         "<collision name=\"c\"><geometry><sphere><radius>0.5</radius></sphere></geometry>" +
         surface + "</collision></link></model>";
}

TEST_F(SceneTest, ReadsAllValues) {
  const auto scene = load(world(
      "<gravity>1 2 3</gravity><physics name=\"p\" type=\"bullet\"><max_step_size>0.004"
      "</max_step_size><real_time_factor>0</real_time_factor></physics>" +
      ball("<inertial><mass>2</mass><inertia><ixx>1</ixx><iyy>1.5</iyy><izz>2</izz><ixy>0.1</ixy>"
           "<ixz>0</ixz><iyz>0</iyz></inertia></inertial>",
           "<surface><friction><ode><mu>0.3</mu></ode></friction><contact><ode><kp>5000</kp>"
           "<kd>7</kd></ode></contact></surface>")));
  EXPECT_EQ(scene.name, "w");
  EXPECT_EQ(scene.gravity, Vec3(1, 2, 3));
  EXPECT_EQ(scene.step, 0.004);
  ASSERT_EQ(scene.bodies.size(), 1u);
  const SceneBody& body = scene.bodies[0];
  EXPECT_EQ(body.name, "ball");
  EXPECT_EQ(body.pose.position, Vec3(0, 0, 1));
  EXPECT_FALSE(body.isStatic);
  EXPECT_EQ(body.mass, 2);
  ASSERT_TRUE(body.inertia);
  EXPECT_EQ((*body.inertia)(0, 0), 1);
  EXPECT_EQ((*body.inertia)(0, 1), 0.1);
  EXPECT_EQ((*body.inertia)(2, 2), 2);
  EXPECT_EQ(body.friction, 0.3);
  EXPECT_EQ(body.stiffness, 5000);
  EXPECT_EQ(body.damping, 7);
  EXPECT_EQ(std::get<SceneSphere>(body.collisions[0].geometry).radius, 0.5);
}

// libsdformat's defaults would be mass 1, inertia 1, mu 1, kp 1e12, kd 1.
TEST_F(SceneTest, AbsentValuesStayAbsent) {
  const auto scene = load(world(ball() + "<model name=\"massOnly\"><link name=\"l\"><inertial>"
                                         "<mass>3</mass></inertial></link></model>"));
  const SceneBody& bare = scene.bodies[0];
  EXPECT_FALSE(bare.mass || bare.inertia || bare.inertialPose);
  EXPECT_FALSE(bare.friction || bare.stiffness || bare.damping);
  EXPECT_EQ(scene.bodies[1].mass, 3);
  EXPECT_FALSE(scene.bodies[1].inertia);
}

TEST_F(SceneTest, HalfStatedSurfacesLeaveTheRestAbsent) {
  const auto scene = load(world(ball("",
                                     "<surface><friction><ode><mu2>0.9</mu2></ode></friction>"
                                     "<contact><ode><kd>5</kd></ode></contact></surface>")));
  EXPECT_FALSE(scene.bodies[0].friction);
  EXPECT_FALSE(scene.bodies[0].stiffness);
  EXPECT_EQ(scene.bodies[0].damping, 5);
}

TEST_F(SceneTest, ReadsEveryGeometry) {
  const auto shape = [](const std::string& geometry) {
    return "<collision name=\"" + geometry.substr(1, 4) + "\"><geometry>" + geometry +
           "</geometry></collision>";
  };
  const auto scene = load(world(
      "<model name=\"m\"><static>true</static><link name=\"l\">" +
      shape("<box><size>1 2 3</size></box>") +
      shape("<cylinder><radius>1</radius><length>4</length></cylinder>") +
      shape("<capsule><radius>2</radius><length>5</length></capsule>") +
      shape("<plane><normal>0 3 4</normal></plane>") +
      shape("<mesh><uri>meshes/part.obj</uri><scale>1 2 4</scale></mesh>") + "</link></model>"));
  const auto& shapes = scene.bodies[0].collisions;
  ASSERT_EQ(shapes.size(), 5u);
  EXPECT_EQ(std::get<SceneBox>(shapes[0].geometry).size, Vec3(1, 2, 3));
  EXPECT_EQ(std::get<SceneCylinder>(shapes[1].geometry).length, 4);
  EXPECT_EQ(std::get<SceneCapsule>(shapes[2].geometry).radius, 2);
  EXPECT_TRUE(std::get<ScenePlane>(shapes[3].geometry).normal.isApprox(Vec3(0, 0.6, 0.8)));
  const auto& mesh = std::get<SceneMesh>(shapes[4].geometry);
  EXPECT_EQ(mesh.file, folder_ / "meshes" / "part.obj");
  EXPECT_EQ(mesh.scale, Vec3(1, 2, 4));
}

// A model turned by 90 degrees about z, with a link relative to one of its frames and a collision
// relative to the link.
TEST_F(SceneTest, ResolvesFramesThroughModelsAndLinks) {
  const std::string model =
      "<model name=\"m\"><pose>0 0 1 0 0 1.5707963267948966</pose>"
      "<frame name=\"f\"><pose>1 0 0 0 0 0</pose></frame>"
      "<link name=\"a\"><pose relative_to=\"f\">0 0 2 0 0 0</pose><collision name=\"c\">"
      "<pose>0 1 0 0 0 0</pose><geometry><box><size>1 1 1</size></box></geometry></collision>"
      "</link>";
  const auto two = load(world(model + "<link name=\"b\"/></model>"));
  ASSERT_EQ(two.bodies.size(), 2u);
  EXPECT_EQ(two.bodies[0].name, "m::a");
  EXPECT_TRUE(two.bodies[0].pose.position.isApprox(Vec3(0, 1, 3), 1e-12));
  EXPECT_TRUE(two.bodies[0].collisions[0].pose.position.isApprox(Vec3(0, 1, 0), 1e-12));
  EXPECT_EQ(two.bodies[0].model, two.bodies[1].model);
  // The only link of a model has the model's frame, and the collision moves with it.
  const auto one = load(world(model + "</model>" + ball()));
  EXPECT_EQ(one.bodies[0].name, "m");
  EXPECT_TRUE(one.bodies[0].pose.position.isApprox(Vec3(0, 0, 1), 1e-12));
  EXPECT_TRUE(one.bodies[0].collisions[0].pose.position.isApprox(Vec3(1, 1, 2), 1e-12));
  EXPECT_NE(one.bodies[0].model, one.bodies[1].model);
}

TEST_F(SceneTest, ReadsJointsInTheWorldsFrame) {
  const auto scene = load(world(
      "<model name=\"m\"><pose>0 0 1 0 0 1.5707963267948966</pose><link name=\"a\"/>"
      "<link name=\"b\"><pose>1 0 0 0 0 0</pose></link>"
      "<joint name=\"hinge\" type=\"revolute\"><parent>a</parent><child>b</child>"
      "<axis><xyz>1 0 0</xyz><limit><lower>-0.5</lower><upper>1</upper></limit></axis></joint>"
      "<joint name=\"nail\" "
      "type=\"fixed\"><parent>world</parent><child>a</child></joint></model>"));
  ASSERT_EQ(scene.joints.size(), 2u);
  const SceneJoint& hinge = scene.joints[0];
  EXPECT_EQ(hinge.kind, SceneJoint::Kind::Revolute);
  EXPECT_EQ(hinge.parent, 0);
  EXPECT_EQ(hinge.child, 1);
  EXPECT_TRUE(hinge.pose.position.isApprox(Vec3(0, 1, 1), 1e-12));  // the child's origin
  EXPECT_TRUE(hinge.axis.isApprox(Vec3(0, 1, 0), 1e-12));
  EXPECT_EQ(hinge.lower, -0.5);
  EXPECT_EQ(hinge.upper, 1);
  EXPECT_EQ(scene.joints[1].kind, SceneJoint::Kind::Fixed);
  EXPECT_EQ(scene.joints[1].parent, -1);
}

TEST_F(SceneTest, ReadsKindsOfJoints) {
  const auto joint = [](const std::string& name, const std::string& type, const std::string& more) {
    return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent>a</parent><child>b</child>" +
           more + "</joint>";
  };
  const std::string
      z = "<axis><xyz>0 0 1</xyz><limit><effort>7</effort></limit></axis>",
      x = "<axis2><xyz>1 0 0</xyz><limit><lower>-0.1</lower><upper>0.2</upper></limit>"
          "</axis2>",
      links = "<model name=\"m\"><link name=\"a\"/><link name=\"b\"/>";
  const auto scene =
      load(world(links + joint("cross", "universal", z + x) + joint("bead", "ball", "") +
                 joint("wheel", "continuous", z) +
                 joint("thread", "screw", z + "<thread_pitch>-1570.7963267948966</thread_pitch>") +
                 "</model>"));
  ASSERT_EQ(scene.joints.size(), 4u);
  EXPECT_EQ(scene.joints[0].kind, SceneJoint::Kind::Universal);
  EXPECT_EQ(scene.joints[0].effort, 7);
  EXPECT_EQ(scene.joints[0].second.axis, Vec3::UnitX());
  EXPECT_EQ(scene.joints[0].second.upper, 0.2);
  EXPECT_EQ(scene.joints[1].kind, SceneJoint::Kind::Ball);
  EXPECT_EQ(scene.joints[2].kind, SceneJoint::Kind::Revolute);
  EXPECT_FALSE(scene.joints[2].lower || scene.joints[2].upper);
  EXPECT_EQ(scene.joints[3].kind, SceneJoint::Kind::Screw);
  EXPECT_NEAR(scene.joints[3].pitch, 4e-3, 1e-9);
}

// Of what nothing touches the visuals are drawn; a link with a collision looks like that.
TEST_F(SceneTest, ReadsVisualsOfLinksWithoutCollisions) {
  const std::string seen =
      "<visual name=\"v\"><pose>0 0 3 0 0 0</pose><geometry><sphere><radius>2"
      "</radius></sphere></geometry></visual>";
  const auto scene = load(world("<model name=\"ghost\"><link name=\"l\"><pose>1 0 0 0 0 0</pose>" +
                                seen + "</link></model>" + ball(seen)));
  ASSERT_EQ(scene.bodies[0].visuals.size(), 1u);
  EXPECT_EQ(scene.bodies[0].visuals[0].pose.position, Vec3(1, 0, 3));
  EXPECT_TRUE(scene.bodies[0].collisions.empty());
  EXPECT_TRUE(scene.bodies[1].visuals.empty());
  // One that cannot be read is not drawn.
  const std::string strange =
                        "<visual name=\"u\"><geometry><ellipsoid><radii>1 2 3</radii>"
                        "</ellipsoid></geometry></visual>",
                    lost =
                        "<visual name=\"w\"><geometry><mesh><uri>lost.obj</uri></mesh></geometry>"
                        "</visual>";
  const auto odd = load(world("<model name=\"m\"><static>true</static><link name=\"l\">" + strange +
                              lost + seen + "</link></model>" + ball()));
  EXPECT_EQ(odd.bodies[0].visuals.size(), 1u);
}

// Must be read as six numbers: libsdformat reads a pose, which would wrap 10 rad/s.
TEST_F(SceneTest, ReadsInitialVelocities) {
  const std::string state =
      "<state world_name=\"w\"><model name=\"ball\"><link name=\"l\"><velocity>1 2 3 10 20 -30"
      "</velocity></link></model></state>";
  const auto scene = load(world(ball() + state));
  EXPECT_TRUE(scene.bodies[0].linearVelocity.isApprox(Vec3(1, 2, 3), 1e-12));
  EXPECT_TRUE(scene.bodies[0].angularVelocity.isApprox(Vec3(10, 20, -30), 1e-12));
}

TEST_F(SceneTest, ReadsElementsOfOurOwn) {
  const auto scene = load(world(
      "<model name=\"tooth\"><static>true</static><link name=\"l\"><collision name=\"c\"><geometry>"
      "<box><size>1 1 1</size></box></geometry><cloudcontact:cuttable/>"
      "<cloudcontact:tissue part=\"crown\"> enamel </cloudcontact:tissue>"
      "<cloudcontact:tissue>dentin</cloudcontact:tissue></collision></link></model>"
      "<model name=\"bur\"><pose>0 0 2 0 0 0</pose><link name=\"l\"><pose>1 0 0 0 0 0</pose>"
      "<cloudcontact:drive><linear>0 0 -0.1</linear><angular>0 0 30</angular></cloudcontact:drive>"
      "<collision name=\"c\"><geometry><sphere><radius>0.5</radius></sphere></geometry>"
      "<cloudcontact:cutter ability=\"0.5\" hardness=\"1e9\" efficiency=\"0.2\" edge_speed=\"4\"/>"
      "<cloudcontact:window>box:1,2,3</cloudcontact:window>"
      "<cloudcontact:representative>0 0 0.5</cloudcontact:representative>"
      "<cloudcontact:tolerance>1e-4</cloudcontact:tolerance>"
      "<cloudcontact:area>sphere:0.25</cloudcontact:area></collision></link></model>"));
  ASSERT_EQ(scene.bodies.size(), 2u);
  const SceneCollision& tooth = scene.bodies[0].collisions[0];
  EXPECT_TRUE(tooth.isCuttable);
  ASSERT_EQ(tooth.tissues.size(), 2u);
  EXPECT_EQ(tooth.tissues[0].part, "crown");
  EXPECT_EQ(tooth.tissues[0].name, "enamel");
  EXPECT_EQ(tooth.tissues[1].part, "");
  EXPECT_FALSE(tooth.cutter || tooth.paper.isGiven());
  const SceneBody& bur = scene.bodies[1];
  ASSERT_TRUE(bur.drive);
  EXPECT_FALSE(bur.isFree());
  EXPECT_EQ(bur.drive->linear, Vec3(0, 0, -0.1));
  EXPECT_EQ(bur.drive->angular, Vec3(0, 0, 30));
  EXPECT_EQ(bur.drive->place.position, Vec3(1, 0, 0));  // the link in the model
  const SceneCollision& head = bur.collisions[0];
  EXPECT_EQ(head.tolerance, 1e-4);
  EXPECT_FALSE(tooth.tolerance);
  ASSERT_TRUE(head.cutter);
  EXPECT_EQ(head.cutter->ability, 0.5);
  EXPECT_EQ(head.cutter->cutter.hardness, 1e9);
  EXPECT_EQ(head.cutter->cutter.efficiency, 0.2);
  EXPECT_EQ(head.cutter->cutter.edgeSpeed, 4);
  EXPECT_EQ(std::get<Box>(*head.paper.window).halfExtents, Vec3(0.5, 1, 1.5));
  EXPECT_EQ(*head.paper.representative, Vec3(0, 0, 0.5));
  EXPECT_EQ(std::get<Sphere>(*head.paper.area).radius, 0.25);
}

struct BadScene {
  const char* name;
  std::string text;
  const char* says;
};

class BadSceneTest : public SceneTest, public testing::WithParamInterface<BadScene> {
 protected:
  BadSceneTest() {
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("cloudcontact_bad_") + GetParam().name);
    std::filesystem::create_directories(folder_);
  }
};

TEST_P(BadSceneTest, IsRefusedInOneLineThatNamesIt) {
  try {
    load(GetParam().text);
    FAIL() << "was accepted";
  } catch (const BadInput& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("scene.sdf"), std::string::npos) << message;
    EXPECT_NE(message.find(GetParam().says), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

std::string shaped(const std::string& geometry, const std::string& flag = "") {
  return world("<model name=\"m\">" + flag + "<link name=\"l\"><collision name=\"c\"><geometry>" +
               geometry + "</geometry></collision></link></model>");
}

std::string jointed(const std::string& joint) {
  return world("<model name=\"m\"><link name=\"a\"/><link name=\"b\"/>" + joint + "</model>");
}

INSTANTIATE_TEST_SUITE_P(
    Table, BadSceneTest,
    ::testing::Values(
        BadScene{"empty", "", "no <sdf>"}, BadScene{"notXml", "solid stl\n", "no <sdf>"},
        BadScene{"cutShort", world(ball()).substr(0, 150), "cut short"},
        BadScene{"malformed", "<sdf version=\"1.9\"><world></sdf>", "SDFormat"},
        BadScene{"noWorld", "<sdf version=\"1.9\">" + ball() + "</sdf>", "exactly one <world>"},
        BadScene{"noBodies", world(""), "has no model"},
        BadScene{"misspelt", world(ball("<inertial><mas>1</mas></inertial>")), "mas"},
        BadScene{"zeroMass", world(ball("<inertial><mass>0</mass></inertial>")), "inertia"},
        BadScene{"negativeMass", world(ball("<inertial><mass>-1</mass></inertial>")), "inertia"},
        BadScene{"inertiaWithoutMass",
                 world(ball("<inertial><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz><ixy>0</ixy>"
                            "<ixz>0</ixz><iyz>0</iyz></inertia></inertial>")),
                 "<mass>"},
        BadScene{"negativeRadius", shaped("<sphere><radius>-1</radius></sphere>"), "<radius>"},
        BadScene{"zeroBox", shaped("<box><size>1 0 1</size></box>"), "<size>"},
        BadScene{"wordForNumber", shaped("<box><size>1 x 1</size></box>"), "size"},
        BadScene{"noGeometry", shaped(""), "<geometry>"},
        BadScene{"movingPlane", shaped("<plane><normal>0 0 1</normal></plane>"), "<static>"},
        BadScene{"ellipsoid", shaped("<ellipsoid><radii>1 1 1</radii></ellipsoid>"),
                 "use box, sphere"},
        BadScene{"noMeshFile", shaped("<mesh><uri>none.obj</uri></mesh>"), "none.obj"},
        BadScene{"meshByScheme", shaped("<mesh><uri>model://m.obj</uri></mesh>"), "relative"},
        BadScene{"negativeFriction",
                 world(ball("", "<surface><friction><ode><mu>-1</mu></ode></friction></surface>")),
                 "<mu>"},
        BadScene{"noStiffness",
                 world(ball("", "<surface><contact><ode><kp>0</kp></ode></contact></surface>")),
                 "<kp>"},
        BadScene{"gears",
                 jointed("<joint name=\"j\" type=\"gearbox\"><parent>a</parent><child>b</child>"
                         "<gearbox_ratio>2</gearbox_ratio><gearbox_reference_body>a"
                         "</gearbox_reference_body><axis><xyz>0 0 1</xyz></axis></joint>"),
                 "screw, ball or universal"},
        BadScene{"screwWithoutPitch",
                 jointed("<joint name=\"j\" type=\"screw\"><parent>a</parent><child>b</child>"
                         "<axis><xyz>0 0 1</xyz></axis></joint>"),
                 "<thread_pitch>"},
        BadScene{"screwOfPitch0",
                 jointed("<joint name=\"j\" type=\"screw\"><parent>a</parent><child>b</child>"
                         "<thread_pitch>0</thread_pitch><axis><xyz>0 0 1</xyz></axis></joint>"),
                 "<thread_pitch>"},
        BadScene{"crossAlongItself",
                 jointed("<joint name=\"j\" type=\"universal\"><parent>a</parent><child>b</child>"
                         "<axis><xyz>0 0 1</xyz></axis><axis2><xyz>0 0 1</xyz></axis2></joint>"),
                 "across the first"},
        BadScene{"negativeSpring",
                 jointed("<joint name=\"j\" type=\"prismatic\"><parent>a</parent><child>b</child>"
                         "<axis><xyz>0 0 1</xyz><dynamics><spring_stiffness>-1</spring_stiffness>"
                         "</dynamics></axis></joint>"),
                 "<spring_stiffness>"},
        BadScene{"jointToNothing",
                 jointed("<joint name=\"j\" type=\"fixed\"><parent>a</parent><child>z</child>"
                         "</joint>"),
                 "z"},
        BadScene{"zeroStep",
                 world("<physics name=\"p\" type=\"bullet\"><max_step_size>0</max_step_size>"
                       "<real_time_factor>0</real_time_factor></physics>" +
                       ball()),
                 "<max_step_size>"},
        BadScene{"stateOfNobody",
                 world(ball() + "<state world_name=\"w\"><model name=\"other\"><link name=\"l\">"
                                "<velocity>0 0 0 0 0 0</velocity></link></model></state>"),
                 "other::l"}),
    [](const auto& scene) { return std::string(scene.param.name); });

std::string ours(const std::string& inCollision, const std::string& inLink = "") {
  return world(ball(inLink, inCollision));
}

INSTANTIATE_TEST_SUITE_P(
    OwnElements, BadSceneTest,
    ::testing::Values(
        BadScene{"misspeltOwn", ours("<cloudcontact:tisue>enamel</cloudcontact:tisue>"),
                 "<cloudcontact:tisue>: is not known; after cloudcontact: use one of tissue"},
        BadScene{"misplaced",
                 ours("<cloudcontact:drive><linear>0 0 0</linear></cloudcontact:drive>"),
                 "<cloudcontact:drive>: stands in a <collision>; move it into a <link>"},
        BadScene{"inTheWorld", world(ball() + "<cloudcontact:cuttable/>"), "move it into a <coll"},
        BadScene{"unknownAttribute", ours("<cloudcontact:cutter abilty=\"1\"/>"),
                 "<cloudcontact:cutter>: attribute abilty is not known"},
        BadScene{"unknownPart",
                 ours("", "<cloudcontact:drive><line>1 0 0</line></cloudcontact:drive>"),
                 "<line> in it is not known; it has: linear, angular"},
        BadScene{"emptyTissue", ours("<cloudcontact:tissue/>"), "is empty; give the name"},
        BadScene{"tissueTwice",
                 ours("<cloudcontact:tissue>a</cloudcontact:tissue>"
                      "<cloudcontact:tissue>b</cloudcontact:tissue>"),
                 "all parts has a tissue already"},
        BadScene{"abilityIsAWord", ours("<cloudcontact:cutter ability=\"sharp\"/>"),
                 "<cloudcontact:cutter> attribute ability"},
        BadScene{"negativeAbility", ours("<cloudcontact:cutter ability=\"-1\"/>"), "ability"},
        BadScene{"tooEfficient", ours("<cloudcontact:cutter efficiency=\"2\"/>"), "efficiency"},
        BadScene{"cutsAndIsCut", ours("<cloudcontact:cutter/><cloudcontact:cuttable/>"),
                 "cannot be cut; leave one out"},
        BadScene{"cutterTwice", ours("<cloudcontact:cutter/><cloudcontact:cutter/>"), "twice"},
        BadScene{"noWindow", ours("<cloudcontact:window>round</cloudcontact:window>"),
                 "<cloudcontact:window>: 'round' is no window"},
        BadScene{"negativeTolerance", ours("<cloudcontact:tolerance>-1</cloudcontact:tolerance>"),
                 "<cloudcontact:tolerance>"},
        BadScene{"flatArea", ours("<cloudcontact:area>box:1,0,1</cloudcontact:area>"),
                 "<cloudcontact:area>"},
        BadScene{"twoNumbers",
                 ours("<cloudcontact:representative>0 1</cloudcontact:representative>"),
                 "<cloudcontact:representative>"},
        BadScene{"emptyDrive", ours("", "<cloudcontact:drive/>"), "has no velocity; give <linear>"},
        BadScene{"infiniteDrive",
                 ours("", "<cloudcontact:drive><angular>0 0 inf</angular></cloudcontact:drive>"),
                 "<cloudcontact:drive> <angular>"},
        BadScene{
            "staticDrive",
            world("<model name=\"m\"><static>true</static><link name=\"l\"><cloudcontact:drive>"
                  "<linear>1 0 0</linear></cloudcontact:drive></link></model>"),
            "leave <static> or the drive out"},
        BadScene{"drivenState",
                 world(ball("<cloudcontact:drive><linear>1 0 0</linear></cloudcontact:drive>") +
                       "<state world_name=\"w\"><model name=\"ball\"><link name=\"l\"><velocity>"
                       "1 2 3 0 0 0</velocity></link></model></state>"),
                 "leave one of them out"},
        BadScene{"drivenAndCut",
                 ours("<cloudcontact:cuttable/>",
                      "<cloudcontact:drive><linear>1 0 0</linear></cloudcontact:drive>"),
                 "<cloudcontact:cuttable>: the link has a drive"},
        BadScene{"planeIsCut",
                 world("<model name=\"m\"><static>true</static><link name=\"l\"><collision "
                       "name=\"c\"><geometry><plane><normal>0 0 1</normal></plane></geometry>"
                       "<cloudcontact:cuttable/></collision></link></model>"),
                 "use a <box>"},
        BadScene{"twoCollisions",
                 ours("<cloudcontact:cuttable/>",
                      "<collision name=\"d\"><geometry><sphere><radius>1</radius></sphere>"
                      "</geometry></collision>"),
                 "one collision"}),
    [](const auto& scene) { return std::string(scene.param.name); });

TEST(SceneFileTest, AMissingFileIsNamed) {
  try {
    loadScene("no_such_scene.sdf");
    FAIL() << "was accepted";
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("no_such_scene.sdf: no such file"), std::string::npos);
  }
}

}  // namespace
}  // namespace cloudcontact::program::sim_scene_test
