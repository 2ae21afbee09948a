// EdgeQueue: the edge searches that a renewed field still owes. A search depends on the voxel's
// block and on what earlier passes found within reach; a change there marks it. A search that finds
// what was there before marks nothing. So the queue runs dry, and the order of the searches does
// not matter to what is found in the end.
#pragma once

#include "field/field_draft.h"
#include "voxels/brick_grid.h"

#include <cstdint>
#include <vector>

namespace cloudcontact {

class EdgeQueue {
 public:
  explicit EdgeQueue(const Eigen::Vector3i& bricks) : marks_(bricks, Mark{}) {}

  std::size_t voxels() const { return voxels_; }  // that wait
  std::size_t bytes() const { return marks_.cells().size() * sizeof(marks_.cells()[0]); }
  void nextRenewal() { ++renewal_; }

  // The passes that a voxel waits for, one bit each.
  int passes(const DraftVoxel& v) const { return marks_.at(v.x, v.y, v.z).passes; }
  void add(const DraftVoxel& v, int passes);
  // The same, where the surface beside the voxel was cut in this renewal.
  void addFresh(const DraftVoxel& v, int passes);
  void done(const DraftVoxel& v, int passes);
  void drop(std::int32_t brick);  // no voxel of it waits any longer
  // Waiting voxels, by brick and cell. Without those whose surroundings were cut in the last `rest`
  // renewals.
  std::vector<DraftVoxel> waiting(const FieldDraft& draft, int rest) const;

 private:
  struct Mark {
    std::uint16_t passes = 0;
    std::uint32_t fresh = 0;  // renewal that last cut the surface beside the voxel; 0: none
  };

  void freeIfEmpty();

  BrickGrid<Mark> marks_;
  std::size_t voxels_ = 0;
  std::uint32_t renewal_ = 0;
};

}  // namespace cloudcontact
