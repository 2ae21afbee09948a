// One pair of a CloudAlgorithm: what it keeps between steps, and what it does in one.
#pragma once

#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <cloudcontact/contact/contact_finder.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "bullet/box_gap.h"
#include "bullet/leaving.h"
#include "bullet/level_switch.h"
#include "bullet/look_ahead.h"
#include "bullet/manifold_writer.h"
#include "bullet/narrow_phase.h"
#include "bullet/pair_query.h"
#include "bullet/pair_sweep.h"
#include "contact/moved_contact.h"
#include "contact/shape_contact.h"

namespace cloudcontact {

struct PairState {
  using Clock = std::chrono::steady_clock;
  static double since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  }

  // `dispatched`: a CloudDispatcher's, or null.
  PairState(btDispatcher& dispatcher, NarrowPhase& shared, LookAhead* dispatched)
      : narrowPhase(shared),
        lookAhead(dispatched),
        writer(dispatcher),
        reader(shared.reading()),
        finder(shared.workspace()) {
    narrowPhase.add(summary);
    narrowPhase.budget().add(work);
  }
  ~PairState() {
    narrowPhase.remove(summary);
    narrowPhase.budget().remove(work);
  }

  template <typename Archive>
  void keepIn(Archive& archive) {
    finder.builder().ids().keepIn(archive);
    shapes.ids().keepIn(archive);
    leaving.keepIn(archive);
    memory.keepIn(archive);
    archive(apart, touched);
  }

  void process(AheadPair& self, const btCollisionObjectWrapper& a,
               const btCollisionObjectWrapper& b, const btDispatcherInfo& info,
               btManifoldResult& result);
  PairQuery read(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b, double step,
                 bool steps, double gap, const Touch* touch = nullptr) {
    const auto lock = narrowPhase.lockToRead();
    return reader.read(narrowPhase.settings(), a, b, step, steps, gap, touch);
  }
  // Whether the query is now where the pair touches later in the step, and where that is.
  std::optional<Touch> sweepOn(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                               const btDispatcherInfo& info, PairQuery& query);
  double search(const PairQuery& query);
  // The last search's contact of faces, with what touches within the step.
  void lookAround(const PairQuery& query);
  void lookBeside(const PairQuery& query, double step);
  // The contact at the step's end (turning.h), and the query with it; empty: there is none.
  std::optional<Touch> lookOn(PairQuery& query, double step);
  // Of the last query, if its contact was not moved.
  Answer answeredBy() const {
    return answeredByShapes ? Answer::Shapes : onDevice ? Answer::Device : Answer::Searched;
  }
  // `query`: with finer levels afterwards, if its contact asks for them; at the step's end, if
  // `turned` is set.
  const ContactResult& find(PairQuery& query, const btCollisionObjectWrapper& a,
                            const btCollisionObjectWrapper& b, double step, bool swept,
                            double& earlier);
  // The contact of a query, how it came about, and the time [s] that it took ahead of the walk.
  struct Answered {
    const ContactResult* contact = nullptr;
    Answer how = Answer::Searched;
    double earlier = 0;
  };
  // `step` [s]; 0: no step of the world.
  Answered answer(PairQuery& query, const btCollisionObjectWrapper& a,
                  const btCollisionObjectWrapper& b, double step, bool swept);
  // Before a step's query is read, and after its answer; see WorkBudget.
  void openStep() {
    if (!narrowPhase.budget().isLimited()) return;
    narrowPhase.budget().open(work);
    reader.levels().ease = work.ease;
  }
  void closeStep(const PairQuery& query, const PairSides& sides, Answer how);
  // Whether prepare() moved the last contact for this query in this step.
  bool isMoved(const PairQuery& query) {
    const std::uint64_t step = std::exchange(movedStep, 0);
    return step > 0 && step == lookAhead->step() && sameQuery(query, ahead);
  }
  bool isKnown(const PairQuery& query) const {
    return !query.byShapes && sameMatter(query, asked) &&
           moved.holds(query.a, query.b, query.settings.margin);
  }
  void keep(const PairQuery& query, const ContactResult& contact, bool swept);
  // Whether the last step found nothing, and the bodies' boxes are too far from each other for this
  // one to find more. Such a step changes nothing.
  bool staysApart(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                  double step) const {
    return clearVoxel > 0 && boxesStayApart(a, b, kClear * clearVoxel, step);
  }
  // The voxel if the next step may begin with staysApart().
  double clearAfter(const PairQuery& query, const PairSides& sides,
                    const ContactResult& contact) const;
  std::size_t bytesKept() const {
    return sizeof *this + finder.bytesKept() + moved.bytesKept() + writer.bytesKept();
  }
  void count(const PairQuery& query, const PairSides& sides, const Answered& found, double seconds);
  LevelCount levelsOf(const PairQuery& query, Answer how) const {
    if (how == Answer::Shapes || !(query.levels.tolerance > 0)) return {};
    return {query.levels.level[0] + query.levels.level[1] > 0, query.levels.eased > 0,
            how == Answer::Moved ? 0 : levels.refined()};
  }
  // Returns whether the bodies leave an overlap, and so must not fall asleep.
  bool write(const PairQuery& query, const PairSides& sides, const ContactResult& contact,
             double step);
  bool finish(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b, double step);
  bool takeFinished(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                    double step);

  NarrowPhase& narrowPhase;
  LookAhead* const lookAhead;
  ManifoldWriter writer;
  PairReader reader;
  ContactFinder finder;  // one per pair: it keeps the last step's patches and their IDs
  ShapeContact shapes;
  Leaving leaving;
  std::unique_ptr<PairSweep> sweep;  // made for the first fast motion
  LevelSwitch levels;
  WorkBudget::Pair work;
  PairMemory memory;
  bool answeredByShapes = false;  // the last query
  PairReport summary;
  PairQuery asked;     // the last query that was searched in a step
  MovedContact moved;  // its contact

  PairQuery ahead;             // the query that is searched ahead
  double aheadSeconds = 0;     // time of that search
  bool aheadOnDevice = false;  // the device made it
  std::uint32_t deviceRoom = SearchTask::kFirstRoom;
  bool onDevice = false;        // it answered the last query
  bool apart = false;           // the last search in a step found no touch of two clouds
  bool touched = false;         // the last search in a step found a touch
  std::optional<Touch> turned;  // the step's end, if its contact is the one there
  // [m] The voxel if the last step that asked found nothing; 0: it did.
  double clearVoxel = 0;
  static constexpr double kClear = 1.1;  // voxels; a query asks for one, and boxes are rounded
  std::uint64_t searchedStep = 0;        // the step in which the finder has searched it; 0: none
  std::uint64_t movedStep = 0;           // the step in which `moved` has answered it; 0: none
  std::uint64_t readyStep = 0;           // the step in which finish() may answer `ahead`; 0: none
  // What finish() made of `ahead`, for the walk.
  struct Finished {
    std::uint64_t step = 0;  // 0: nothing
    Answered found;
    bool written = false, leaves = false;
    double seconds = 0;
  };
  Finished finished;
  bool processed = true;    // processCollision() ran after the last prepare()
  bool weighed = false;     // the bodies' matter was checked
  int slot = -1;            // in CompoundChildren
  int child[2] = {-1, -1};  // of compounds, in the last query
};

}  // namespace cloudcontact
