// WorldCutter: tools that cut CuttableBody's and SoftTissue's in a running Bullet world. Paper,
// Step 3: cutting ability and cutting difficulty. Matter goes by Archard's law (cutter.h) from the
// collision voxels of each tool, under the force that the solver found between tool and body. The
// pair's own contact stays as it is: the law pushes, the cutter takes away what is in the tool's
// area.
#pragma once

#include <cloudcontact/bullet/cuttable_body.h>
#include <cloudcontact/bullet/soft_tissue.h>
#include <cloudcontact/law/tissue.h>
#include <cloudcontact/workpiece/cutter.h>

#include <memory>
#include <vector>

class btCollisionObject;

namespace cloudcontact {

// A body that was cut.
struct WorldCut {
  CuttableBody* body = nullptr;
  double volume = 0;   // cut by tools in this step [m^3]
  CutOutcome outcome;  // what fell off, and the momentum of the matter cut away
};

// A soft tissue that was cut.
struct SoftCut {
  SoftTissue* tissue = nullptr;
  std::size_t links = 0;  // cut in this step
};

// Tools may be moving bodies, or driven ones of mass 0 that have a velocity. Tools and bodies must
// outlive the cutter or leave it first.
class WorldCutter {
 public:
  WorldCutter();
  ~WorldCutter();
  WorldCutter(const WorldCutter&) = delete;
  WorldCutter& operator=(const WorldCutter&) = delete;

  // `tool`: D and cutting abilities, in the object's frame. The cutting speed is that of the
  // tool's surface over the matter, its spin included, plus Cutter::edgeSpeed. Throws
  // std::invalid_argument for an invalid area or cutter.
  void addTool(const btCollisionObject& object, const Detection& tool, const Cutter& cutter);
  void removeTool(const btCollisionObject& object);

  // `tissues`: one for each of the cloud's materials, or one for all; their hardnesses resist the
  // cutter. Takes 0.6 ms a thousand voxels, but for a piece that fell off in the last
  // after(), whose base vectors are known by then. Throws as BaseVectorField does.
  void addBody(CuttableBody& body, const TissueTable& tissues);
  void removeBody(const CuttableBody& body);

  // Its links are cut (SoftTissue::cut) where a tool passes, by the tool's hardness and ability.
  void addTissue(SoftTissue& tissue);
  void removeTissue(const SoftTissue& tissue);

  // Call after each step of the world, with its length [s]. Cuts are gradual
  // (CuttableBody::cutGradually()), so that no step waits for a large one; the list therefore also
  // holds bodies that earlier cuts have parted now. The caller owns what fell off; add those pieces
  // to have them cut, too. A body of which nothing is left has left the cutter.
  std::vector<WorldCut> after(double step);
  // What the last call of after() cut in soft tissue.
  const std::vector<SoftCut>& softCuts() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
