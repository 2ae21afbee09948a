// A query: search, hits, bins, patches, points.
#include <cloudcontact/contact/contact_finder.h>

#include "contact/border_hits.h"
#include "contact/contact_builder.h"
#include "contact/query_memory.h"
#include "contact/verlet_lists.h"

#include <algorithm>

namespace cloudcontact {

struct ContactWorkspace::State {
  QueryMemoryPool memory;
};

ContactWorkspace::ContactWorkspace() : state_(std::make_unique<State>()) {}
ContactWorkspace::~ContactWorkspace() = default;
ContactWorkspace::ContactWorkspace(ContactWorkspace&&) noexcept = default;
ContactWorkspace& ContactWorkspace::operator=(ContactWorkspace&&) noexcept = default;

void ContactWorkspace::reserve(int threads) {
  state_->memory.reserve(threads);
}

struct ContactFinder::State {
  std::shared_ptr<ContactWorkspace> workspace;
  ContactBuilder builder;
  VerletLists lists;
  std::size_t lookups = 0;
};

ContactFinder::ContactFinder() : ContactFinder(std::make_shared<ContactWorkspace>()) {}
ContactFinder::ContactFinder(std::shared_ptr<ContactWorkspace> workspace)
    : state_(std::make_unique<State>()) {
  state_->workspace = std::move(workspace);
}
ContactFinder::~ContactFinder() = default;
ContactFinder::ContactFinder(ContactFinder&&) noexcept = default;
ContactFinder& ContactFinder::operator=(ContactFinder&&) noexcept = default;

const ContactResult& ContactFinder::find(const ContactBody& a, const ContactBody& b,
                                         const ContactSettings& settings) {
  search(a, b, settings);
  return withIds();
}

void ContactFinder::search(const ContactBody& a, const ContactBody& b,
                           const ContactSettings& settings, const TaskRunner* runner) {
  State& s = *state_;
  const PairFrame frame = s.builder.begin(a, b, settings);
  BorrowedMemory memory(s.workspace->state_->memory);
  HitColumns& hits = memory->hits;
  const int level = memory->search.run(a, b, frame, settings.margin, enoughFor(settings), hits,
                                       runner, settings.verletLists ? &s.lists : nullptr);
  double gap = memory->search.gap();
  if (addBorderHits(a, b, frame, gap > 0, hits) > 0) gap = 0;
  const auto build = [&] {
    const std::vector<CcSums>& patches =
        memory->binner.patches(hits, cellOf(frame, level), a.shape || b.shape, runner);
    std::span<const PatchMatter> matter;
    if (TouchedMatter::wanted(a, b, settings))
      matter = memory->matter.of(
          a, b, settings, frame,
          {hits, memory->binner.bins(), patches.size(), level, cellOf(frame, level), gap});
    return s.builder.build(a, b, settings, frame, {level, hits.size(), gap}, memory->binner, hits,
                           memory->wet, matter);
  };
  // Hits that press nothing must not hide a gap that closes within the step.
  if (!build() && !hits.empty() && settings.margin > 0 && gap == 0) {
    memory->search.runApart(a, b, frame, settings.margin, hits);
    gap = memory->search.gap();
    s.builder.begin(a, b, settings);
    build();
  }
  s.lookups = memory->search.lookups();
}

namespace {

// Most directions beside those of the touches: a peg in its hole has a wall behind it and a floor.
constexpr int kMostBeside = 3;

// Adds the directions in which the patches from `first` on face.
void addFaced(const ContactBody& a, const ContactBody& b, const ContactResult& contact,
              std::size_t first, FacedWays& faced) {
  for (std::size_t i = first; i < contact.patches.size(); ++i) {
    const Vec3& normal = contact.patches[i].normal;
    faced.of[kA].emplace_back((a.pose.orientation.conjugate() * normal).cast<float>());
    faced.of[kB].emplace_back((b.pose.orientation.conjugate() * -normal).cast<float>());
  }
}

}  // namespace

void ContactFinder::lookBeside(const ContactBody& a, const ContactBody& b,
                               const ContactSettings& settings) {
  State& s = *state_;
  const ContactResult& contact = s.builder.latest();
  if (contact.patches.empty() || !(settings.margin > 0)) return;
  const PairFrame frame = frameOf(a, b);
  BorrowedMemory memory(s.workspace->state_->memory);
  HitColumns& hits = memory->hits;
  FacedWays& faced = memory->faced;
  for (auto& ways : faced.of) ways.clear();
  std::size_t known = 0;
  for (int pass = 0; pass < kMostBeside; ++pass) {
    addFaced(a, b, contact, known, faced);
    known = contact.patches.size();
    const bool any = memory->search.runBeside(a, b, frame, settings.margin, faced, hits) && [&] {
      const int level = 0;
      const double gap = memory->search.gap(), cell = cellOf(frame, level);
      const std::vector<CcSums>& patches = memory->binner.patches(hits, cell, a.shape || b.shape);
      std::span<const PatchMatter> matter;
      if (TouchedMatter::wanted(a, b, settings))
        matter = memory->matter.of(a, b, settings, frame,
                                   {hits, memory->binner.bins(), patches.size(), level, cell, gap});
      return s.builder.append(a, b, settings, frame, {level, hits.size(), gap}, memory->binner,
                              hits, memory->wet, matter);
    }();
    s.lookups += memory->search.lookups();
    if (!any) return;
  }
}

const ContactResult& ContactFinder::withIds() {
  return state_->builder.withIds();
}

const ContactResult& ContactFinder::latest() const {
  return state_->builder.latest();
}

std::size_t ContactFinder::sampleLookups() const {
  return state_->lookups;
}

ContactBuilder& ContactFinder::builder() {
  return state_->builder;
}

double depthOf(const ContactResult& contact) {
  double sum = 0, weight = 0;
  for (const Patch& patch : contact.patches) {
    if (isBeside(contact, patch)) continue;
    sum += patch.stiffness * patch.depth;
    weight += patch.stiffness;
  }
  return weight > 0 ? sum / weight : 0;
}

Wrench wrenchOnB(const ContactResult& contact, const Motion& a, const Motion& b) {
  Wrench w;
  for (const ContactPoint& p : contact.points) {
    const double closing = (a.at(p.position) - b.at(p.position)).dot(p.normal);
    const double size =
        p.depth < 0 ? 0.0 : std::max(0.0, p.stiffness * p.depth + p.damping * closing);
    const Vec3 force = size * p.normal;
    w.force += force;
    w.torque += p.position.cross(force);
  }
  return w;
}

}  // namespace cloudcontact
