// The report of `contact` on a pair, by clouds or by Bullet's own methods.
#pragma once

#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/contact/contact.h>

#include <optional>
#include <vector>

#include "draw/contact_scene.h"
#include "scene/body.h"

namespace cloudcontact::program {

struct ContactQuery {
  Body a, b;
  Pose pose;                                // of B; A is at the origin
  Motion motion;                            // of B; A is at rest
  std::optional<PlacedSolid> areaA, areaB;  // D of A and of B, where it is not the whole body
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
  std::vector<double> microseconds;  // of each repetition
  Backend backend = Backend::Cpu;    // that found the contacts
};

// The voxel size of both bodies [m]; a saved cloud keeps its own.
double sharedVoxel(const ContactQuery& query);

// The pair's k and c: from the options, else 1e4 N/m (1e9 N/m^3 with foundation) without damping.
Law pairLaw(const CommonOptions& options);

// By clouds: ContactFinder's points in double, and the time of the same pair in Bullet. Fills
// `scene`, if given, for a picture.
ContactReport cloudContact(const ContactQuery& query, ContactScene* scene = nullptr);
// By Bullet's own shapes. Divides k and c equally among the touching points.
ContactReport bulletContact(const ContactQuery& query);

}  // namespace cloudcontact::program
