// The contact of two bodies: samples of each looked up in the other, gathered in patches, each
// patch reduced to at most four points that keep its force and moment.
// Paper, steps 2 to 5; FORCE.md for the form of the sums.
#pragma once

#include <cloudcontact/field/surface_field.h>
#include <cloudcontact/law/law.h>
#include <cloudcontact/law/solid.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace cloudcontact {

// One side of a query: a cloud's field or a shape (exactly one of the two), where it stands, how it
// moves.
struct ContactBody {
  const SurfaceField* field = nullptr;
  const AnalyticShape* shape = nullptr;
  Pose pose;
  Motion motion;
};

struct ContactSettings {
  LawForm law = LawForm::Paper;
  Material pair{1e4, 0};  // the pair's k and c; ignored by LawForm::Rigid
  // [m] Bodies that do not touch but are nearer than this, two voxels at most, get points with a
  // negative depth where they would touch first: a solver can then stop them there within its step.
  double margin = 0;
  // Model no more than a contact needs: the coarsest of three sets of samples that gives this many
  // hits is taken (a finer one than the coarsest already at a third of it), all samples where none
  // does. Fewer are faster and rougher; README.md charts what they cost and give.
  std::size_t samples = kSamples;
  static constexpr std::size_t kSamples = 300;
  // Between queries that move a pair by less than a hundredth of a voxel, lists what may touch, and
  // looks up nothing else: the same bits in 0.6 of the time. False: each query is a first one, as
  // for a measurement of what that takes.
  bool lists = true;
};

// A place where the bodies touch: what Bullet makes a btManifoldPoint of.
struct ContactPoint {
  Vec3 position = Vec3::Zero();  // world [m], midway between the two surfaces
  Vec3 normal = Vec3::UnitZ();   // world, unit, from A to B
  double depth = 0;              // [m] positive inside; negative: a gap (ContactSettings::margin)
  double stiffness = 0;          // [N/m] this point's share
  double damping = 0;            // [N s/m]
  std::uint32_t id = 0;          // lasts from step to step
  int patch = 0;                 // index into ContactResult::patches
};

enum class Doubt : std::uint8_t { None, FewSamples, Opposed, Deep };  // why a patch is not trusted

struct Patch {
  Vec3 position = Vec3::Zero();  // centre of pressure, world [m]
  Vec3 normal = Vec3::UnitZ();   // the digital normal, from A to B
  double depth = 0;              // [m]
  double stiffness = 0, damping = 0;
  double area = 0;        // [m^2] wetted
  double confidence = 1;  // 0..1
  Doubt doubt = Doubt::None;
  int firstPoint = 0, points = 0;
};

struct ContactResult {
  std::vector<Patch> patches;
  std::vector<ContactPoint> points;
  std::size_t samples = 0;  // found in the other body
  void clear() {
    patches.clear();
    points.clear();
    samples = 0;
  }
};

// Kelvin-Voigt force of the points as they stand on B, and torque about the world's origin.
struct Wrench {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
};
Wrench wrenchOnB(const ContactResult& contact, const Motion& a, const Motion& b);

// Runs task(0) to task(count - 1) on any threads, in any order, and returns when all are done.
using TaskRunner = std::function<void(int count, const std::function<void(int)>& task)>;

// Finds contacts. It keeps its results and their names between calls; what it works with is lent by
// the process, as many times as queries run at once, and kept there, so that a step after the first
// allocates nothing. One finder serves one thread.
class ContactFinder {
 public:
  ContactFinder();
  ~ContactFinder();
  ContactFinder(ContactFinder&&) noexcept;
  ContactFinder& operator=(ContactFinder&&) noexcept;

  // "No contact" is an empty result. Throws std::invalid_argument where a body has neither field
  // nor shape, both bodies are shapes, or a pose is not finite.
  const ContactResult& find(const ContactBody& a, const ContactBody& b,
                            const ContactSettings& settings);

  // find() in two halves, for a question that is worked out before it is asked: search() throws as
  // find() does and remembers nothing of its bodies for a later search, so that it may turn out not
  // to be wanted; named(), once after a search that is, gives its points their ids. With `shareOut`
  // a large search is shared out over it; what is found is the same to the bit.
  void search(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
              const TaskRunner* shareOut = nullptr);
  const ContactResult& named();
  // Samples that the last search looked up: what it cost.
  std::size_t asked() const;

  // Where several threads search: gives what is lent the room that any query has needed, `threads`
  // times, so that none has to ask for more which another thread had asked for before. Between
  // steps.
  static void makeRoom(int threads);

  struct Scratch;  // its memory, which the backends share

 private:
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace cloudcontact
