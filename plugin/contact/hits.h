// The first half of a query: which samples of either body lie in the other, and how deep.
// Everything in the frame of one of the two bodies (the "frame body"), metres.
#pragma once

#include <cloudcontact/base/task_runner.h>
#include <cloudcontact/contact/contact.h>

#include "contact/hit_columns.h"
#include "field/field_data.h"

#include <vector>

namespace cloudcontact {

class ShortlistMaker;
class Shortlists;

struct PairFrame {
  Side body = kA;    // the frame body; always one with a field
  Pose pose;         // its pose
  double voxel = 0;  // the larger of the bodies' voxels [m]
};

// The frame does not depend on which body is called A: the one with fewer samples, and of two
// equals the one that sees the other on the greater side.
PairFrame frameOf(const ContactBody& a, const ContactBody& b);
// The way of a field's samples into the other body.
CcWay wayOf(const ContactBody& own, const ContactBody& other, const PairFrame& frame);
// Hits that make a level fine enough, of those that the coarsest needs.
std::size_t neededOf(int level, std::size_t enough);
// ContactSettings::margin as a search uses it [m].
float marginOf(double margin, const PairFrame& frame);

// Searches both bodies' samples; keeps its memory.
class HitSearch {
 public:
  HitSearch();
  ~HitSearch();

  // The hits of the coarsest level that gives `enough` of them (ContactSettings::samples), or of
  // all samples. Returns the level. Each level tells which cells of the next need be looked at.
  // Where nothing is hit and the bodies are nearer than `margin` [m], the hits are those of bodies
  // moved together until they touch lightly, by gap().
  // With `lists`, the pair's own, samples that cannot touch are passed over.
  int run(const ContactBody& a, const ContactBody& b, const PairFrame& frame, double margin,
          std::size_t enough, HitColumns& hits, const TaskRunner* shareOut = nullptr,
          Shortlists* lists = nullptr);
  static constexpr std::size_t kAll = ~std::size_t{0};
  double gap() const { return gap_; }  // [m] 0: the hits are real
  // Samples that the last run looked up, of all levels.
  std::size_t asked() const { return cells_[0].asked + cells_[1].asked; }
  // Room for what the other has room for.
  void fit(const HitSearch& other);

  // The record that a part of a sample is measured by, and its place from that voxel's centre.
  struct Part {
    CcVoxel record;
    float x, y, z;
  };
  // Samples whose cells' finer ones are to be looked at, and those found so on this level.
  struct Candidates {
    bool all = true;  // of the coarsest level: every brick
    std::vector<std::uint32_t> now, next;
    std::vector<std::uint32_t> bricks;  // that may touch
    std::size_t asked = 0;              // samples looked up so far
    std::vector<std::uint32_t> deep;    // samples below the band
    SampleColumns parts;                // of samples over an edge, and where they lie
    std::vector<Part> places;

    void fit(const Candidates& other);
  };
  // The samples that come nearest without touching.
  struct Misses {
    float margin = 0;        // [m] farther ones are not kept; 0: none is
    float within = 0;        // [m] nor those farther by this than the nearest
    float nearest = -1e30f;  // greatest depth so far, negative [m]
    std::vector<Hit> list;
  };
  // Of a large level: runs of samples, and what each part of them came to.
  struct Share {
    std::size_t last = 0;  // of the runs, behind it
    Candidates cells;
    Misses misses;
    HitColumns hits;
  };
  struct Shares {
    const TaskRunner* run = nullptr;  // null: nothing is shared out
    std::vector<SampleRun> runs;
    std::vector<Share> all;
  };

 private:
  struct Query;
  int look(const Query& query, HitColumns& hits, const Shortlists* lists);
  void lookUp(const Query& query, Side side, int level, HitColumns& hits, const Shortlists* lists);
  void touchLightly(HitColumns& hits);

  std::unique_ptr<ShortlistMaker> maker_;
  Candidates cells_[2];
  Misses misses_;
  Shares shares_;
  double gap_ = 0;
};

}  // namespace cloudcontact
