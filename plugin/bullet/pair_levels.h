// PairLevels: which voxels a pair of clouds is searched with. A pair takes the coarsest level of
// each body (FieldLevels) whose surface, where the bodies' boxes overlap, is within half the
// tolerance, and finer ones where its contact states a larger error (docs/engine.md, "Levels").
#pragma once

#include <cloudcontact/bullet/cloud_shape.h>
#include <cloudcontact/contact/contact.h>

#include <cstdint>

namespace cloudcontact {

// The levels of a query. Bodies that are no clouds have level 0.
struct LevelChoice {
  double tolerance = 0;  // [m] 0: the finest voxels, as without levels
  int level[2] = {0, 0};
  std::size_t samples = 0;  // ContactSettings::samples; 0: the world's
  double error = 0;         // [m] of both surfaces, where the bodies' boxes overlap
  double anywhere = 0;      // [m] of both surfaces; infinite if a part of one is not seen
  int eased = 0;            // levels coarser than the tolerance allows, for a budget
  bool isCoarse() const { return level[0] + level[1] > 0; }
  bool operator==(const LevelChoice& other) const {
    return level[0] == other.level[0] && level[1] == other.level[1] && samples == other.samples;
  }
};

class PairLevels {
 public:
  // [m] The smaller of both clouds'; 0: none, and nothing is to choose. Null for what is no cloud.
  // `world`: of shapes without one.
  static double tolerance(const CloudShape* const clouds[2], double world);
  // For the bodies where they are. `reach` [m]: what is nearer than this counts before it touches.
  // Changes nothing, so a query read ahead in another thread is the same.
  LevelChoice choose(const CloudShape* const clouds[2], const Pose poses[2], double world,
                     double reach) const;
  // Sets the fields of the two bodies.
  static void apply(const LevelChoice& choice, const CloudShape* const clouds[2],
                    ContactBody* const bodies[2]);

  // After a search with these levels: whether the contact asks for finer ones. Then choose() again.
  // `error` [m]: depthError().
  bool refines(const LevelChoice& choice, const CloudShape* const clouds[2], double error,
               const ContactResult& contact);
  // Whether the last step's contact is of other levels, so that its depth may jump.
  bool differs(const LevelChoice& choice) const { return known_ && !(choice == last_); }
  const LevelChoice& last() const { return last_; }
  // After a step's last search.
  void learn(const LevelChoice& choice, double error, const ContactResult& contact);

  // For files (base/byte_archive.h).
  template <typename Archive>
  void keepIn(Archive& archive) {
    archive(cap_, coarsest_, tight_, hot_, calm_, loose_, patience_, since_, known_);
    archive(last_.tolerance, last_.level[0], last_.level[1], last_.error, last_.eased);
    for (std::size_t* count : {&samples_, &last_.samples}) {
      auto number = static_cast<std::uint64_t>(*count);
      archive(number);
      *count = static_cast<std::size_t>(number);
    }
  }

  int ease = 0;  // levels coarser than the tolerance allows (WorkBudget)

 private:
  void impatient();
  double sharpness() const { return tight_ ? kTight : 1; }

  // A body held from opposite sides is in a tight fit: a part of the tolerance decides there
  // whether it moves.
  static constexpr double kTight = 0.125;
  static constexpr int kPatience = 60;  // searches in a step, before a coarser level is tried
  static constexpr int kMostPatience = 4096;
  // Coarse surfaces have few samples: those that the error needs are asked, not all.
  static constexpr std::size_t kFewSamples = 24;

  static constexpr double kNoCap = 1e300;
  double cap_ = kNoCap, coarsest_ = 0;  // [m] on voxels; the coarsest that there are
  std::size_t samples_ = kFewSamples;
  bool tight_ = false;
  int hot_ = 0, calm_ = 0, loose_ = 0, patience_ = kPatience, since_ = kMostPatience;
  bool known_ = false;
  LevelChoice last_;
};

}  // namespace cloudcontact
