// FieldData: the data of a SurfaceField as the library reads it, from SurfaceField::data().
#pragma once

#include <cloudcontact/voxels/cloud.h>

#include "field/edge_queue.h"
#include "field/field_records.h"
#include "field/sample_set.h"

#include <memory>
#include <mutex>
#include <vector>

namespace cloudcontact {

// The input of a renewal, kept if FieldSettings::renewable is set.
struct FieldNotes {
  SurfaceBricks bricks;
  std::vector<SampleOrigin> origins;  // of the samples
  EdgeQueue edges;
  LayerBricks layers;

  explicit FieldNotes(const Eigen::Vector3i& size) : edges(size) {}
};

class SurfaceTree;

// Triangles of the surface, made when a query first needs them (surfaceTree()).
struct LazySurfaceTree {
  std::once_flag once;
  std::shared_ptr<const SurfaceTree> made;
};

// The closed form of a cloud that has one (closedForm()).
struct RecognizedShape;
struct LazyClosedForm {
  std::once_flag once;
  std::shared_ptr<const RecognizedShape> made;
};

// The voxels that its samples own (ownedVoxels()).
struct OwnedVoxels;
struct LazyOwnedVoxels {
  std::once_flag once;
  std::shared_ptr<const OwnedVoxels> made;
};

// Balls around its samples (ballTree()).
class BallTree;
struct LazyBallTree {
  std::once_flag once;
  std::shared_ptr<const BallTree> made;
};

class FieldData {
 public:
  // `before`: holds what the band marks kAsBefore.
  FieldData(Cloud cloud, const Band& band, SampleSet samples,
            std::shared_ptr<const FieldNotes> notes, const FieldData& before);
  // `notes` may be null.
  FieldData(Cloud cloud, FieldRecords records, SampleSet samples,
            std::shared_ptr<const FieldNotes> notes = nullptr);

  const Cloud& cloud() const { return cloud_; }
  const FieldRecords& records() const { return records_; }
  const CcVoxel* planes() const { return records_.planes().data(); }
  std::size_t planeCount() const { return records_.planes().size(); }
  const std::vector<std::uint8_t>& brickDistance() const { return records_.brickDistance(); }
  const SampleSet& samples() const { return samples_; }
  const Eigen::AlignedBox3d& bounds() const { return bounds_; }  // of the samples, body's frame [m]
  const FieldNotes* notes() const { return notes_.get(); }
  // Expires with the field, for owners of copies of its data.
  const std::shared_ptr<const int>& life() const { return life_; }

  LazySurfaceTree& lazyTree() const { return *lazyTree_; }
  LazyClosedForm& lazyForm() const { return *lazyForm_; }
  LazyOwnedVoxels& lazyVoxels() const { return *lazyVoxels_; }
  LazyBallTree& lazyBalls() const { return *lazyBalls_; }
  // Whether it was renewed after a cut.
  bool isRenewed() const { return renewed_; }

  std::size_t bytes() const;
  std::uint64_t hash() const;

 private:
  Cloud cloud_;
  FieldRecords records_;
  SampleSet samples_;
  Eigen::AlignedBox3d bounds_;
  std::shared_ptr<const FieldNotes> notes_;
  std::shared_ptr<const int> life_ = std::make_shared<const int>(0);
  std::unique_ptr<LazySurfaceTree> lazyTree_ = std::make_unique<LazySurfaceTree>();
  std::unique_ptr<LazyClosedForm> lazyForm_ = std::make_unique<LazyClosedForm>();
  std::unique_ptr<LazyOwnedVoxels> lazyVoxels_ = std::make_unique<LazyOwnedVoxels>();
  std::unique_ptr<LazyBallTree> lazyBalls_ = std::make_unique<LazyBallTree>();
  bool renewed_ = false;
};

}  // namespace cloudcontact
