// One pair of a CloudAlgorithm: what it keeps between steps, and what it does in one.
#pragma once

#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <cloudcontact/contact/contact_finder.h>

#include <chrono>
#include <cstdint>
#include <memory>

#include "bullet/leaving.h"
#include "bullet/level_switch.h"
#include "bullet/look_ahead.h"
#include "bullet/manifold_writer.h"
#include "bullet/narrow_phase.h"
#include "bullet/pair_step.h"
#include "bullet/pair_sweep.h"
#include "bullet/staying_apart.h"
#include "contact/contact_builder.h"
#include "contact/moved_contact.h"

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
    shapeIds.keepIn(archive);
    leaving.keepIn(archive);
    memory.keepIn(archive);
    archive(apart, touched, held, turned);
    turns.keepIn(archive);
    moved.keepIn(archive);
    levels.keepIn(archive);
    reader.keepIn(archive);
    if constexpr (Archive::kReads) {
      restored = processed = true;
      staying.forget();
      setStage(Stage::None);
    }
  }

  // Bullet's call.
  void process(AheadPair& self, const btCollisionObjectWrapper& a,
               const btCollisionObjectWrapper& b, const btDispatcherInfo& info,
               btManifoldResult& result);
  // A CloudDispatcher's calls ahead of it (AheadPair), in this order.
  std::size_t prepare(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                      const btDispatcherInfo& info);
  void searched(double seconds, Answer how);
  bool finish(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b);

  // What of the step is done ahead of Bullet's walk.
  enum class Stage : std::uint8_t { None, Read, Searched, Found };
  Stage stage() const {
    return lookAhead && number == lookAhead->step() ? stageInStep : Stage::None;
  }
  void setStage(Stage reached) {
    number = lookAhead ? lookAhead->step() : 0;
    stageInStep = reached;
  }

  void ask(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
           const btDispatcherInfo& info, btManifoldResult& result);
  void walk(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
            const btDispatcherInfo& info);
  PairQuery read(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b, double step,
                 bool steps, double gap = 0, const Touch* touch = nullptr) {
    const auto lock = narrowPhase.lockToRead();
    return reader.read(narrowPhase.settings(), a, b, step, steps, gap, touch);
  }
  // Where the pair touches later in the step; the query is then there.
  std::optional<Touch> sweepOn(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                               const btDispatcherInfo& info, PairQuery& query);
  void aim(PairStep& step, const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b);
  // The contact of the step's query; `known`: it is searched already.
  void find(PairStep& step, const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
            bool known);
  void search(PairStep& step, const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b);
  // What the step adds to it, but for what is written of single points (step_adjustments.h).
  void adjust(PairStep& step, const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b);
  bool findByShapes(const PairQuery& query, bool lightly, ContactResult& found) const;
  bool lookAtEnd(PairStep& step, const btCollisionObjectWrapper& a,
                 const btCollisionObjectWrapper& b);
  void lookFurther(PairStep& step, const btCollisionObjectWrapper& a,
                   const btCollisionObjectWrapper& b);
  void keepSupport(PairStep& step);
  void lookBeside(PairStep& step);
  void write(PairStep& step, const PairSides& sides);
  // After a step's answer: reports, budget, and what the next step asks.
  void close(const PairStep& step, const PairSides& sides, double seconds);
  void count(const PairStep& step, const PairSides& sides, double seconds);
  // By which states and files know the pair; also of one that is too far apart to be asked.
  void setName(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b);

  // Before a step's query is read; see WorkBudget.
  void openStep() {
    if (!narrowPhase.budget().isLimited()) return;
    narrowPhase.budget().open(work);
    reader.levels().ease = work.ease;
  }
  void closeStep(const PairStep& step, const PairSides& sides);
  bool isKnown(const PairQuery& query) const {
    return !query.byShapes && (restored || sameMatter(query, asked)) &&
           moved.holds(query.a, query.b, query.settings.margin);
  }
  void keep(const PairStep& step);
  // Whether a step found nothing that the next one must take up.
  bool clearAfter(const PairStep& step) const;
  std::size_t bytesKept() const {
    return sizeof *this + finder.bytesKept() + moved.bytesKept() + writer.bytesKept() +
           now.contact.bytesKept();
  }

  NarrowPhase& narrowPhase;
  LookAhead* const lookAhead;
  ManifoldWriter writer;
  PairReader reader;
  ContactFinder finder;  // one per pair: it keeps the last step's patches and their IDs
  PatchIds shapeIds;     // of contacts by shapes
  Leaving leaving;
  std::unique_ptr<PairSweep> sweep;  // made for the first fast motion
  LevelSwitch levels;
  WorkBudget::Pair work;
  PairMemory memory;
  PairReport summary;
  PairQuery asked;        // the last query that was searched in a step
  MovedContact moved;     // its contact, the one that is kept between steps
  bool restored = false;  // `moved` is from a file: `asked` is not known before the next query

  PairStep now;              // the step
  std::uint64_t number = 0;  // the dispatcher's, of stageInStep
  Stage stageInStep = Stage::None;
  std::uint32_t deviceRoom = SearchTask::kFirstRoom;
  bool apart = false;    // the last search in a step found no touch of two clouds
  bool touched = false;  // the last search in a step found a touch
  bool held = false;     // its contact bears weight on all sides
  bool turned = false;   // the last step's contact is that at its end (turning.h)
  TurningPlace turns;    // then
  StayingApart staying;
  bool processed = true;    // processCollision() ran after the last prepare()
  bool weighed = false;     // the bodies' matter was checked
  int slot = -1;            // in CompoundChildren
  int child[2] = {-1, -1};  // of compounds, in the last query
};

}  // namespace cloudcontact
