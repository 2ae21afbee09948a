// A haptic loop: pose and velocity of the hand in, force and torque on it out, 1,000 to 10,000
// times a second. Paper, Steps 2 to 5, with the workpiece cut as the tool works.
//
// The hand holds the tool by a spring (virtual coupling, Colgate et al. 1995): the tool stands
// where the material's force and the spring's are even, and the hand feels the spring. However
// stiff the material, the device renders no more than the spring's stiffness, which keeps it
// passive.
#pragma once

#include <cloudcontact/workpiece/cutter.h>
#include <cloudcontact/workpiece/embedding.h>
#include <cloudcontact/workpiece/reaction.h>

#include <optional>

namespace cloudcontact {

struct HapticSettings {
  Detection tool;               // D, and how well which part of the tool cuts
  double step = 1e-3;           // [s] between ticks
  double handStiffness = 1000;  // [N/m] of the spring between hand and tool
  double handDamping = 1;       // [N s/m] beside it, while in contact. A spring that is felt a
                           // step late gives back energy; half of stiffness times step takes it
  double release = 0.02;  // [s] in which a force fades that nothing holds any more, by matter cut
                          // away or an edge's end; 0: at once. The default is 5 % a tick at 1 kHz
  double mostForce = 20;  // [N] beyond it the device is not asked for more
  // Empty: Kelvin-Voigt with the tissues' k and c. Else this law; neither Foundation nor Rigid.
  std::optional<Law> law;
  // True: the stiffnesses and dampings in `law` are multiples of the tissues' k and c. For
  // KelvinVoigt, Maxwell and StandardLinearSolid.
  bool perTissue = false;
  EmbeddingSettings embedding;
  std::optional<Cutter> cutter;  // none: the tool touches only
  int voxelsAStep = 8;           // the tool follows the hand by so many voxels a tick, a look at
                                 // each: what is thicker than one is not passed through
};

struct HapticInput {
  Pose hand;
  Vec3 velocity = Vec3::Zero();  // [m/s] of the hand's place, world
};

struct HapticOutput {
  Wrench onHand;         // torque about the hand's place
  Pose tool;             // where the tool is shown: never deeper than its embedding
  double depth = 0;      // d [m]
  double stiffness = 0;  // k of (1) [N/m]
  int iterations = 0;    // of the embedding's search
  EmbeddingEnd end = EmbeddingEnd::NotPressed;
  std::size_t cutVoxels = 0;  // in this tick
  double cutVolume = 0;       // [m^3]
  double energy = 0;          // [J] the hand has given so far, less what it got back
  double leastEnergy = 0;     // [J] its least value: below zero only where the loop was not passive
};

class HapticLoop {
 public:
  // The workpiece must outlive the loop, which cuts it. Throws std::invalid_argument where a
  // setting is not usable.
  HapticLoop(BaseVectorField& workpiece, const Pose& workpiecePose, const HapticSettings& settings);

  // Never allocates after the first contact of a size; never locks. An input that is not finite
  // gives the output before, with the force gone. Throws nothing.
  const HapticOutput& tick(const HapticInput& input) noexcept;

  const Collision& collision() const { return *collision_; }  // of the last tick
  const Reaction& reaction() const { return reaction_; }      // of it, by tissue
  const std::vector<VoxelCut>& lastCut() const { return process_->last(); }

 private:
  bool follow(const Pose& hand);
  Vec3 slide(const Vec3& lead, const Vec3& outward) const;
  double leastLead(const Vec3& lead) const;
  double letGo(const Vec3& lead, const Vec3& step) const;
  void press(const HapticInput& input);
  void calm(const Vec3& step);
  void watchEnergy(const Vec3& hand);
  Law lawNow() const;

  BaseVectorField* workpiece_;
  Pose workpiecePose_;
  HapticSettings settings_;
  CollisionFinder finder_;
  const Collision* collision_ = nullptr;
  std::optional<CuttingProcess> process_;
  Reaction reaction_;
  HapticOutput output_;
  LawState state_;
  Vec3 lastLead_ = Vec3::Zero();  // of the hand before the tool, as far as matter held it
  Vec3 lastStep_ = Vec3::Zero();  // the whole one that the tool wished to take
  double calm_ = 1;               // how much of it is taken
  bool started_ = false;
  Vec3 lastHand_ = Vec3::Zero();
  Collision none_;
};

}  // namespace cloudcontact
