// A cube of 1 kg rests on Bullet's plane, m g / k deep, in whichever precision this is compiled.
#include <btBulletDynamicsCommon.h>
#include <cloudcontact/bullet.h>

#include <cmath>
#include <cstdio>

#include <outside/cube.h>

int main() {
  using namespace cloudcontact;
  btDefaultCollisionConfiguration configuration;
  CloudContact contact;
  CloudDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  contact.attach(dispatcher);
  recommendedSettings(world);
  world.setGravity(btVector3(0, 0, btScalar(-9.81)));

  btStaticPlaneShape plane(btVector3(0, 0, 1), 0);
  btRigidBody floor(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &plane));
  world.addRigidBody(&floor);
  DigitizeSettings settings;
  settings.voxelSize = 0.005;
  CloudShape shape(SurfaceField::build(digitize(cube(0.1), settings)));
  shape.law = KelvinVoigt{1e5, 100};
  btVector3 inertia;
  shape.calculateLocalInertia(1, inertia);
  btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape, inertia));
  body.setWorldTransform(
      btTransform(btQuaternion::getIdentity(), btVector3(0, 0, btScalar(0.051))));
  world.addRigidBody(&body);
  for (int i = 0; i < 240; ++i) world.stepSimulation(btScalar(1) / 240, 0, btScalar(1) / 240);

  const double sag = 0.05 - body.getWorldTransform().getOrigin().z();
  std::printf("%zu bytes a number, %.4f mm deep\n", sizeof(btScalar), 1e3 * sag);
  world.removeRigidBody(&body);
  world.removeRigidBody(&floor);
  return std::abs(sag - 9.81 / 1e5) < 5e-5 && sizeof(btScalar) == NUMBER_BYTES ? 0 : 1;
}
