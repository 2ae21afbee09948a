// VoxelSums: sums over the voxels of one body that lie in the other, or in its D, patch by patch:
// the paper's (1), (2), (5) and (5').
#pragma once

#include <cloudcontact/contact/paper_body.h>

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "contact/owned_lanes.h"
#include "contact/pair_frame.h"
#include "contact/patch_matter.h"
#include "field/owned_voxels.h"
#include "kernels/cut/digital_normal.h"

namespace cloudcontact {

struct BaseVectorBricks;

class VoxelSums {
 public:
  // `own` has a field; its pair is in `frame`.
  void begin(const ContactBody& own, const ContactBody& other, Side side, const PairFrame& frame,
             const FoundHits& found);
  // The samples whose voxels may lie in the other's D.
  void touchedByArea(std::vector<search::TouchedSample>& touched) const;
  void add(std::span<const search::TouchedSample> touched);
  // Where the bodies are apart: of each hit the voxel below it.
  void addNear();
  // Adds what was summed to the patches.
  void finish(std::vector<PatchMatter>& matter);
  // Number of voxels looked up since the last call.
  std::size_t takeLookups() { return std::exchange(lookups_, 0); }

 private:
  // What is summed over voxels, in the own grid [voxels]: share, share times k and c of the tissue,
  // weight, and weight times base vector, its moment about the grid's origin and its length.
  enum Term { kCount, kStiffness, kDamping, kWeight, kVector, kMoment = 7, kLength = 10, kTerms };
  // Of a patch, eight voxels side by side: by (5'), and by (5), whose weight is the share alone.
  static constexpr int kAtOnce = search::kVector;
  // [voxels] Some of a voxel is in the other body where its center is half a voxel outside, and
  // what the other's plane at the sample, continued, tells of it may be wrong by 0.15.
  static constexpr float kLeast = -0.65f;
  // Of a patch, lanes of voxels side by side: by (5'), and by (5), whose weight is the share alone.
  using Lanes8 = double[8];
  struct Sum {
    Lanes8 hard[kTerms] = {}, plain[kTerms] = {};
  };
  // Voxels side by side, those of a patch together: whole vectors, filled up with shares of 0.
  struct Columns {
    // Not a multiple of a page, so that the columns do not contend for the same lines of a cache.
    static constexpr int kRoom = search::kLanes * kAtOnce + kAtOnce;
    float share[kRoom], weight[kRoom], x[kRoom], y[kRoom], z[kRoom], fx[kRoom], fy[kRoom],
        fz[kRoom], length[kRoom];
    float stiffness[kRoom], damping[kRoom];  // where tissues differ
  };
  // The voxels of a patch among them.
  struct Segment {
    std::uint32_t patch;
    int first, last;
  };

  // Some voxels of a sample that waits.
  struct Box {
    int pending;
    std::uint32_t first, count, below;  // `below`: a bit for each voxel below the plane
  };
  static constexpr int kPending = 64;

  std::size_t patchAt(const search::TouchedSample& touched);
  search::OwnedPlane planeAt(const search::TouchedSample& touched, const OwnedRun& run) const;
  void lookAtPending();
  void take(const Box& box);
  void loadVoxels();
  void flush();
  void lookUp();
  void findShares();
  void sortByPatch(int counted);
  void put(int counted);
  void weigh(int counted);
  void sumUp();
  void addTo(Lanes8* sum, const float* weights, const Segment& segment) const;
  void addOne(std::size_t patch, double share, const VoxelIndex& v);

  const ContactBody *own_ = nullptr, *other_ = nullptr;
  const FoundHits* found_ = nullptr;
  std::unique_ptr<search::Direction> dir_;
  const OwnedVoxels::Level* level_ = nullptr;        // of the own samples
  std::shared_ptr<const OwnedVectors> vectors_;      // null: none are stated
  const PlacedSolid* area_ = nullptr;                // D; null: the other body
  PlacedSolid shape_;                                // the other body, where it has no field
  bool whole_ = false;                               // Membership::Whole
  double ability_ = 1;                               // of the other, outside its parts
  const std::vector<CuttingPart>* parts_ = nullptr;  // null: it cuts alike everywhere
  std::vector<double> hardness_;
  bool mixed_ = false;      // some tissues have no hardness, so (5) may hold
  bool tissues_ = false;    // they differ
  bool various_ = false;    // voxels differ in hardness, or in the ability that meets them
  Pose toFrame_, toOther_;  // from the own grid [m]
  std::vector<Sum> sums_;   // of the patches
  std::size_t patch_ = 0;   // of what is taken now
  std::size_t lookups_ = 0;

  search::TouchedSample pendingSample_[kPending];
  search::OwnedPlane pendingPlane_[kPending];
  int pending_ = 0;
  std::vector<Box> boxes_;
  search::Lanes lanes_;
  std::uint32_t voxel_[search::kLanes + kAtOnce], patches_[search::kLanes + kAtOnce];
  float depth_[search::kLanes];  // [voxels]
  float coverage_[search::kLanes], share_[search::kLanes];
  std::int32_t counts_[search::kLanes + search::kVector];
  int place_[search::kLanes];  // of the lanes that count, in the columns
  std::vector<int> next_;      // of each patch the next place
  Segment segments_[search::kLanes];
  int segmentCount_ = 0;
  Columns columns_;
  // Samples side by side mostly are of few bins.
  struct KnownBin {
    std::uint64_t key = ~std::uint64_t{0};
    std::size_t patch = 0;
  };
  KnownBin known_[256];
};

}  // namespace cloudcontact
