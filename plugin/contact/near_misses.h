// The samples that come nearest to the other body without touching it.
//
// Asking all samples costs a hundred times a contact: in a nut's play every sample is near. So the
// search goes from few samples to many, but keeps the most promising only. A coarse sample stands
// for finer ones, of which the nearest is at most as near as its cluster allows (CcCluster).
// Searched on are the cells of the samples with the best such estimates, edges among them, and of
// those that are nearest themselves, so that a face is found over its whole width. Where the gap is
// even, any sample tells it. The gap is within 0.05 voxel of that of all samples on smooth bodies,
// and within 0.1 of the bodies' own at edges and corners (tests/contact/near_misses_test.cpp).
//
// What is as near as the nearest but not searched on, as the rest of a face whose gap is even,
// counts by its coarse samples. So what is found is all that is near, and no part of it that the
// order of the samples or a tilt of no size picks: bodies would turn about that part.
//
// Beside touches, the search leaves out samples that face where the touches do: a peg that lies on
// one wall of its hole is near the wall behind it (ContactFinder::lookBeside()).
//
// A touch is never left to this search: HitSearch asks every sample that may touch.
#pragma once

#include "contact/near_miss.h"
#include "contact/pair_frame.h"
#include "contact/sample_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace cloudcontact {

namespace search {
struct Lanes;
struct CoarseFound;
}  // namespace search

// Where two bodies are known to meet, and how they move, as samples of either body see it.
struct KnownMeets {
  // A patch and the ellipse that its points say that it covers: the smallest around a rectangle
  // with their spread. Where a body rolls they are in one place, and it covers that alone.
  struct Meet {
    Eigen::Vector3f place;   // its middle, in the samples' grid [own voxels]
    Eigen::Vector3f normal;  // outward unit vector
    // From the middle to the ellipse, the longer first; zero where the points are in one place.
    Eigen::Vector3f axes[2] = {Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()};  // [own voxels]
    // How far a place is from what it covers, or little more, squared.
    float apartFrom(const Eigen::Vector3f& other) const {
      Eigen::Vector3f way = other - place;
      float most = 1;
      for (const Eigen::Vector3f& axis : axes) {
        const float length = axis.squaredNorm();
        if (!(length > 0)) continue;
        const float part = std::clamp(way.dot(axis) / length, -most, most);
        way -= part * axis;
        most = std::sqrt(std::max(0.0f, 1 - part * part));
      }
      return way.squaredNorm();
    }
  };
  // A sample at x [own voxels] moves by turn x + shift [m] against the other body within the step.
  struct Way {
    Eigen::Matrix3f turn;
    Eigen::Vector3f shift;
  };
  struct Side {
    std::vector<Meet> meets;
    Way arc, line;  // as the bodies turn, and on at the velocity of the step's beginning
  };
  // Which samples count beside the meets.
  enum class Look : std::uint8_t {
    Beside,  // those that face another way than any meet
    Far,     // those that face as some do, but are far from them: the other end of a wall
    Apart,   // those that are in other places, whichever way they face: another foot
    Ahead    // those that touch within the step in other places, whichever way they face
  };
  Side of[2];
  Look look = Look::Beside;
  bool again = false;  // the bodies stand as in the last search: its coarsest samples are known
};

class NearMissSearch {
 public:
  NearMissSearch();
  ~NearMissSearch();

  // The samples of either body that are nearer to the other than `margin` [m], and at most kLightly
  // voxels of the frame farther than the nearest. `ways`: of each body's samples, where it has a
  // field. `coarse`: of both bodies' samples, if known. With `known`, the search is beside a touch.
  // It leaves out samples that touch; that do not face the other surface, as the sides of a box on
  // a table do not; and that KnownMeets::look leaves out. Ahead, it takes them by their depths at
  // the step's end. Valid until the next run.
  const std::vector<NearMiss>& run(const ContactBody* const* bodies, const CcWay* ways,
                                   const PairFrame& frame, float margin,
                                   const search::CoarseFound* coarse,
                                   const KnownMeets* known = nullptr);
  static constexpr float kLightly = 0.1f;
  static constexpr float kSameWay = 0.26f;     // cosine of 75 deg
  static constexpr float kSamePlace = 8;       // [own voxels]
  static constexpr float kFarPlace = 40;       // [own voxels]
  static constexpr float kFacing = 0.5f;       // of samples beside a touch, to the other surface
  double nearest() const { return nearest_; }  // depth of the nearest, negative [m]
  const WorkCounts& work() const { return work_; }  // of the last run
  // Reserves what `other` has reserved.
  void reserveLike(const NearMissSearch& other);

 private:
  struct Candidate {
    float estimate;  // [m] the largest depth that a sample may have for which this one stands
    float depth;     // [m] its own
    std::uint32_t sample;
    std::int8_t side;
  };
  // One of the coarsest samples that may count beside a touch, with `there`, the other's normal as
  // the sample's grid sees it.
  struct Coarsest : Candidate {
    Eigen::Vector3f place, normal, there;
  };
  // A sample that may count, once it is weighed.
  struct Near {
    float most;  // [m] the depth that no part of it exceeds, at the step's end where it counts
    float way;   // [m] how much deeper it gets within the step, if that counts
    std::uint32_t sample;
    float depth;            // [m] by the other's plane
    Eigen::Vector3f other;  // its normal
  };
  struct OneSide;

  void scan(const OneSide& side, const search::CoarseFound& coarse);
  void searchOn(const OneSide& side, int level);
  template <typename Target>
  void look(const search::Direction& dir, const Target& target, const SampleRun* first,
            const SampleRun* last);
  void take(const search::Direction& dir, const FieldData* other);
  void keepNear(const search::Direction& dir, const FieldData* other);
  void findNearest(const search::Direction& dir, const FieldData* other, std::size_t from);
  std::optional<NearMiss> weighed(const search::Direction& dir, const FieldData* other,
                                  const Near& near);
  void takeMisses(const OneSide& side, int level);
  void takeCoarsest(const search::Direction& dir, const float* estimates, const float* depths);
  void considerCoarsest();
  bool looks(KnownMeets::Look look) const { return known_ && known_->look == look; }
  bool isWanted(float estimate, float depth) const {
    return (estimate >= leastEstimate_) | ((estimate > least_) & (depth >= leastDepth_));
  }
  template <typename Sample>
  void consider(const search::Direction& dir, const float* estimates, const float* depths,
                int count, const Sample& sample);
  float wayOf(int side, const Eigen::Vector3f& place, const Eigen::Vector3f& there) const;
  bool isBeside(int side, const Eigen::Vector3f& place, const Eigen::Vector3f& normal,
                float depth) const;
  float wayOf(const search::Direction& dir, int lane) const;
  bool isBeside(const search::Direction& dir, int lane, float depth) const;
  void keepOthers(const search::Direction& dir, const float* depths, int count,
                  const std::uint32_t* samples, std::uint32_t first);
  void leaveOutSearchedOn(const OneSide& side, int level);
  void takeOthers(const OneSide& side, int level);
  void keepBest();
  void keepFirst(std::size_t from, float Candidate::*by);
  void keepNearest();

  const KnownMeets* known_ = nullptr;
  float margin_ = 0, least_ = 0, within_ = 0, nearest_ = 0;
  float leastEstimate_ = 0, leastDepth_ = 0;  // of candidates that may be kept
  WorkCounts work_;
  std::vector<Candidate> now_, next_;
  std::vector<Coarsest> coarsest_;
  // Coarse samples whose cells are not searched on, but which are as near as the nearest: they
  // stand for their cells themselves.
  struct Other {
    float depth;  // [m]
    std::uint32_t sample;
    std::int8_t side;
  };
  std::vector<Other> others_[kLevels];  // by level
  float othersFrom_ = 0;                // [m] the least depth of those that may count
  bool takingOthers_ = false;
  std::vector<std::uint32_t> bricks_;
  std::vector<SampleRun> runs_;
  std::vector<Near> near_[2];  // by side
  std::vector<NearMiss> found_;
  std::vector<float> ranks_;  // of found_: depths of ends, at the step's end where it counts [m]
  std::unique_ptr<search::Lanes> lanes_;
};

}  // namespace cloudcontact
