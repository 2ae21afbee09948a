// The haptic loop: pose and velocity of the hand in, force and torque on the hand out, 1,000 to
// 10,000 times a second. Paper, Steps 2 to 5; the tool may cut the workpiece.
//
// The hand holds the tool by a spring (virtual coupling, Colgate et al. 1995). The tool is where
// the material's force equals the spring's, and the hand feels the spring. So the device renders no
// more than the spring's stiffness, however stiff the material. Where the model itself would give
// energy, as with a representative point off center, the loop bounds its force (energy_watch.h).
#pragma once

#include <cloudcontact/workpiece/cutter.h>
#include <cloudcontact/workpiece/embedding.h>
#include <cloudcontact/workpiece/energy_watch.h>
#include <cloudcontact/workpiece/reaction.h>

#include <optional>

namespace cloudcontact {

// The tool, the hand's spring and how material is felt and cut.
struct HapticSettings {
  Detection tool;               // D, and the cutting ability of the tool's parts
  double step = 1e-3;           // time between ticks [s]
  double handStiffness = 1000;  // of the spring between hand and tool [N/m]
  // Parallel to the spring, while in contact [N s/m]. A spring that acts a step late adds energy;
  // damping of half of stiffness times step removes it.
  double handDamping = 1;
  // Time constant of the force's decay where the material that held the tool is gone, by a cut or
  // at the end of an edge; 0: at once [s]. The default is 5 % per tick at 1 kHz.
  double release = 0.02;
  double mostForce = 20;  // limit of the force on the hand [N]
  // Empty: Kelvin-Voigt with the tissues' k and c. Else this law; neither Foundation nor Rigid.
  std::optional<Law> law;
  // True: the stiffnesses and dampings in `law` are multiples of the tissues' k and c. For
  // KelvinVoigt, Maxwell and StandardLinearSolid.
  bool perTissue = false;
  // If given, the index in place of `law`: it may use speed, acceleration, hardness and ability.
  InteractionIndex index;
  EmbeddingSettings embedding;
  // (6). Unscaled: the material's force is the law's times |F|, F in voxels.
  Direction direction = Direction::Unit;
  // None: the tool touches only. A tool that cuts measures its depth by DepthTo::Nearest, so that
  // the force does not jump in its own hole.
  std::optional<Cutter> cutter;
  // Most voxels that the tool follows the hand per tick, with a collision search after each: it
  // cannot pass through walls thicker than a voxel.
  int voxelsAStep = 8;
};

// The hand at a tick.
struct HapticInput {
  Pose hand;
  Vec3 velocity = Vec3::Zero();  // of the hand's position, world [m/s]
};

// What a tick returns.
struct HapticOutput {
  Wrench onHand;         // torque about the hand's position
  Pose tool;             // for display: never deeper than its embedding depth
  double depth = 0;      // d [m]
  double stiffness = 0;  // k of (1) [N/m]
  int iterations = 0;    // of the search for the embedding depth
  EmbeddingEnd end = EmbeddingEnd::NotPressed;
  std::size_t cutVoxels = 0;  // in this tick
  double cutVolume = 0;       // [m^3]
  double energy = 0;          // net work of the hand since the start [J]
  // Its minimum [J]. Below zero by no more than the hand's change of speed in a tick makes of it.
  double leastEnergy = 0;
  double withheld = 0;  // of the force, so that the energy stays above zero; else 0 [N]
};

class HapticLoop {
 public:
  // The loop cuts `workpiece`, which must outlive it. Throws std::invalid_argument where a setting
  // is not valid.
  HapticLoop(BaseVectorField& workpiece, const Pose& workpiecePose, const HapticSettings& settings);

  // Does not lock, and allocates only where a contact is larger than any before. For an input that
  // is not finite, returns the previous output with zero force.
  const HapticOutput& tick(const HapticInput& input) noexcept;

  const Collision& collision() const { return *collision_; }  // of the last tick
  const Reaction& reaction() const { return reaction_; }      // of the last tick, by tissue
  const std::vector<VoxelCut>& lastCut() const { return process_->last(); }

 private:
  bool follow(const Pose& hand);
  Vec3 slide(const Vec3& lead, const Vec3& outward) const;
  double leastLead(const Vec3& lead) const;
  double letGo(const Vec3& lead, const Vec3& step) const;
  void press(const HapticInput& input);
  void calm(const Vec3& step);
  Embedding search(double reach);
  Embedding searchTable(const HandSpring& hand, const Index& index);
  Interaction interactionNow() const;
  double scale() const;
  void limit(Vec3& force);
  void updateLaw();

  BaseVectorField* workpiece_;
  Pose workpiecePose_;
  HapticSettings settings_;
  CollisionFinder finder_;
  const Collision* collision_ = nullptr;
  std::optional<CuttingProcess> process_;
  Reaction reaction_;
  HapticOutput output_;
  Law law_;  // of this tick
  LawState state_;
  double speed_ = 0;      // of the depth in the last tick [m/s]
  EmbeddingTable table_;  // for Search::Table, of the law or index as it was when last filled
  KelvinVoigt tabulated_;
  EnergyWatch watch_;
  Vec3 lastLead_ = Vec3::Zero();  // from the tool to the hand, as far as material held it
  Vec3 lastStep_ = Vec3::Zero();  // the full step toward equilibrium
  double calm_ = 1;               // share of the step that is taken
  bool started_ = false;
  Collision none_;
};

}  // namespace cloudcontact
