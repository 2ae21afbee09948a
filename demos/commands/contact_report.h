// What `contact` tells of a pair, whichever method found it.
#pragma once

#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/contact/contact.h>

#include <vector>

#include "draw/contact_scene.h"
#include "scene/body.h"

namespace cloudcontact::program {

struct ContactQuery {
  Body a, b;
  Pose pose;      // of B; A stands at the origin
  Motion motion;  // of B; A is at rest
  int repeat = 100;
  CommonOptions common;
};

struct ReportedContact {
  Vec3 position = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  // from A to B
  double depth = 0;             // [m] positive inside
  double stiffness = 0, damping = 0;
  int patch = 0;
  double confidence = 1;
};

struct ContactReport {
  std::vector<ReportedContact> contacts;
  std::size_t patches = 0, samples = 0;
  Wrench onB;                        // torque about the world's origin
  std::vector<double> microseconds;  // of each repeat
  Backend backend = Backend::Cpu;    // that found them
};

// The pair's k and c: as given, else 1e4 N/m (1e9 N/m^3 with foundation) without damping.
Law pairLaw(const CommonOptions& options);

// By clouds: ContactFinder's points in double, and the time of the same pair through Bullet. Fills
// `scene`, where there is one, with what a picture needs.
ContactReport cloudContact(const ContactQuery& query, ContactScene* scene = nullptr);
// By Bullet's own shapes, k and c shared equally among the points that touch.
ContactReport bulletContact(const ContactQuery& query);

}  // namespace cloudcontact::program
