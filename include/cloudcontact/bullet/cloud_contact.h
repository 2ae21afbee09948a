// One call makes a Bullet world understand CloudShape.
#pragma once

#include <cloudcontact/contact/contact.h>
#include <cloudcontact/law/law.h>

#include <memory>
#include <string>
#include <vector>

class btCollisionDispatcher;
class btDynamicsWorld;
class btSoftBody;

namespace cloudcontact {

struct SoftContactPoint;  // soft_contact.h

// What all cloud pairs of a world share.
struct CloudContactSettings {
  // The law of every pair, whatever its bodies state. Empty: the bodies' laws decide
  // (CloudShape::law, btCollisionObject::setContactStiffnessAndDamping), and pairs without one get
  // an automatic spring (automatic_spring.h). Foundation{}, without a stiffness: the same, but
  // shared out by area. A viscoelastic law is one per pair; its memory lasts while the bodies
  // touch.
  std::optional<Law> law = std::nullopt;
  std::size_t samples = ContactSettings::kSamples;  // ContactSettings::samples, of every pair
  // How many times a pair's own mass an automatic spring may be hard enough for, where a light body
  // bears heavy ones. Bullet's own solver wants 1, ExtrapolatingSolver (extrapolating_solver.h)
  // takes 10. Below 1, NaN or infinite is refused by CloudContact.
  double bears = 1;
  bool lists = true;  // ContactSettings::lists, of every pair
};

// Time spent and work done by the cloud narrow phase since the last reset.
struct CloudContactStatistics {
  double seconds = 0;
  std::size_t pairs = 0, samples = 0, contacts = 0;
  // Pairs that could not be answered (a NaN pose, a flat shape, an exception, which never crosses
  // Bullet), and what the last one said.
  std::size_t failures = 0;
  std::string lastFailure;
};

// Owns the algorithm factories that a dispatcher keeps pointers to: must outlive the dispatcher.
class CloudContact {
 public:
  // Throws std::invalid_argument, naming the field, for an invalid law or setting.
  explicit CloudContact(const CloudContactSettings& settings = {});
  ~CloudContact();
  CloudContact(const CloudContact&) = delete;
  CloudContact& operator=(const CloudContact&) = delete;

  // The one call. For every shape type in both orders, for contacts and for closest-point queries;
  // for soft bodies (soft_contact.h), whose nodes are pushed as contacts are looked for in a step.
  void attach(btCollisionDispatcher& dispatcher);

  const CloudContactSettings& settings() const;
  CloudContactStatistics statistics() const;
  void resetStatistics();
  // Adds the soft body's nodes that touched clouds in the last step.
  void softContacts(const btSoftBody& soft, std::vector<SoftContactPoint>& points) const;

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

// What in a world's solver settings defeats the Kelvin-Voigt law (split impulse, an MLCP solver, no
// warm starting, one friction direction, ...): one sentence each that says what to set. Empty: all
// well.
std::vector<std::string> diagnose(const btDynamicsWorld& world);

// Sets what diagnose() asks for, where it is a setting.
void recommendedSettings(btDynamicsWorld& world);

}  // namespace cloudcontact
