// CloudContact: makes a Bullet world understand CloudShape, with one call.
#pragma once

#include <cloudcontact/bullet/cloud_contact_settings.h>
#include <cloudcontact/bullet/diagnosis.h>
#include <cloudcontact/bullet/pair_report.h>

#include <memory>
#include <vector>

class btCollisionDispatcher;
class btSoftBody;

namespace cloudcontact {

struct SoftContactPoint;  // soft_contact_point.h

// Owns the algorithm factories that a dispatcher points to, so it must outlive the dispatcher.
class CloudContact {
 public:
  // Throws std::invalid_argument, naming the field, for an invalid law or setting.
  explicit CloudContact(const CloudContactSettings& settings = {});
  ~CloudContact();
  CloudContact(const CloudContact&) = delete;
  CloudContact& operator=(const CloudContact&) = delete;

  // Registers clouds for every shape type in both orders, for contacts and for closest-point
  // queries, and for soft bodies (soft_contact_point.h), which are pushed while a step looks for
  // contacts. Call it after other registrations, such as that of GImpact's own algorithm. What has
  // neither volume nor triangles counts as a failure.
  void attach(btCollisionDispatcher& dispatcher);

  const CloudContactSettings& settings() const;
  CloudContactStatistics statistics() const;
  void resetStatistics();
  // Each pair that Bullet's broadphase holds now, and with CloudContactSettings::keepReports each
  // that it has held; in the order in which they met.
  std::vector<PairReport> pairs() const;
  // Appends the soft body's nodes that touched clouds in the last step.
  void softContacts(const btSoftBody& soft, std::vector<SoftContactPoint>& points) const;

 private:
  friend struct ContactRecords;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
