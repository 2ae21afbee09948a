// VoxelSums: sums over the voxels of one body that lie in the other, or in its D, patch by patch:
// the paper's (1), (2), (5) and (5').
#pragma once

#include <cloudcontact/contact/paper_body.h>

#include <memory>
#include <utility>
#include <vector>

#include "contact/lanes.h"
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
  void add(const search::TouchedSample& touched);
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
  // Of a patch: by (5'), and by (5), whose weight is the share alone.
  struct Sum {
    double hard[kTerms] = {}, plain[kTerms] = {};
  };
  // Voxels that count, side by side.
  struct Columns {
    static constexpr int kRoom = search::kLanes + 8;
    double share[kRoom], stiffness[kRoom], damping[kRoom], weight[kRoom];
    double x[kRoom], y[kRoom], z[kRoom], fx[kRoom], fy[kRoom], fz[kRoom], length[kRoom];
    std::uint32_t patch[kRoom];
    int count = 0;
  };
  // The voxels of a sample, and the other's plane there: depth is `here` - `other` . x at x.
  struct Run {
    std::uint32_t first, last;
    search::V3 other;
    float here;   // [voxels]
    float least;  // [voxels] a voxel is looked up if its depth below the plane is more
    float end;    // [voxels] voxels deeper below the sample are not in the other body
  };

  std::size_t patchAt(const SurfaceSample& s, const search::TouchedSample& t);
  Run runOf(const search::TouchedSample& touched, const SurfaceSample& s) const;
  void take(std::uint32_t voxel);
  void flush();
  void lookUp();
  void findShares();
  void put(double share, std::size_t patch, const Vec3& center, std::uint8_t material,
           const double* f);
  void sumUp();
  static void addTo(double* sum, const Columns& columns, const double* weights, int first,
                    int last);

  const ContactBody *own_ = nullptr, *other_ = nullptr;
  const FoundHits* found_ = nullptr;
  std::unique_ptr<search::Direction> dir_;
  const OwnedVoxels* owned_ = nullptr;
  std::shared_ptr<const OwnedVectors> vectors_;      // null: none are stated
  const PlacedSolid* area_ = nullptr;                // D; null: the other body
  PlacedSolid shape_;                                // the other body, where it has no field
  bool whole_ = false;                               // Membership::Whole
  double ability_ = 1;                               // of the other, outside its parts
  const std::vector<CuttingPart>* parts_ = nullptr;  // null: it cuts alike everywhere
  std::vector<double> hardness_;
  bool mixed_ = false;      // some tissues have no hardness, so (5) may hold
  Pose toFrame_, toOther_;  // from the own grid [m]
  std::vector<Sum> sums_;   // of the patches
  std::size_t patch_ = 0;   // of what is taken now
  std::size_t lookups_ = 0;

  search::Lanes lanes_;
  std::uint32_t voxel_[search::kLanes];
  std::uint32_t patches_[search::kLanes];
  double depth_[search::kLanes];  // [m]
  double coverage_[search::kLanes], share_[search::kLanes];
  std::int32_t counts_[search::kLanes + search::kVector];
  // Samples side by side mostly are of few bins.
  struct KnownBin {
    std::uint64_t key = ~std::uint64_t{0};
    std::size_t patch = 0;
  };
  KnownBin known_[64];
  Columns columns_;
};

}  // namespace cloudcontact
