// Finds the contact of two bodies: looks up samples of each in the other, groups the hits into
// patches, and reduces each patch to four points that keep its force and torque.
// docs/method.md, "Step 2: interference" to "Step 5: direction".
#pragma once

#include <cloudcontact/base/task_runner.h>
#include <cloudcontact/contact/contact.h>
#include <cloudcontact/contact/work_counts.h>

#include <memory>

namespace cloudcontact {

class ContactBuilder;

// The memory that queries work in. Finders that share a workspace need one set of memory for each
// query that runs at the same time, not one for each finder. A workspace grows to the largest query
// and keeps that memory until its end. It may be shared by finders of any threads.
class ContactWorkspace {
 public:
  ContactWorkspace();
  ~ContactWorkspace();
  ContactWorkspace(ContactWorkspace&&) noexcept;
  ContactWorkspace& operator=(ContactWorkspace&&) noexcept;

  // Makes a set of memory for each of `threads` threads, as large as the largest query so far
  // needed, so that later queries of that size allocate nothing in any thread. Call it while no
  // query runs.
  void reserve(int threads);

  // What all searches in it have taken.
  WorkCounts work() const;

 private:
  friend class ContactFinder;
  struct State;
  std::unique_ptr<State> state_;
};

// Finds the contacts of one pair, step by step. It keeps the points' IDs between calls, and
// no result. One finder serves one thread at a time.
class ContactFinder {
 public:
  ContactFinder();  // with a workspace of its own
  explicit ContactFinder(std::shared_ptr<ContactWorkspace> workspace);  // not null
  ~ContactFinder();
  ContactFinder(ContactFinder&&) noexcept;
  ContactFinder& operator=(ContactFinder&&) noexcept;

  // Finds the contact; without contact the result is empty. Throws std::invalid_argument if a body
  // has neither a field nor a shape or has both, if both bodies are shapes, if a pose is not finite
  // or its quaternion not of length 1, if `settings` have a negative margin or no samples, and as
  // validateBody() of a shape and validate() of a law do; Foundation{} is for bodies with tissues.
  ContactResult find(const ContactBody& a, const ContactBody& b, const ContactSettings& settings);
  // The same into `found`, whose memory is used again: from the second query on, none is allocated.
  void find(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
            ContactResult& found);

  // find() in two halves, for queries made ahead of time. search() finds the contact without the
  // points' IDs, and throws as find() does. Call giveIds() once for the last result, if used; those
  // that are not used leave the IDs as they were. With `runner`, large searches run in parallel;
  // the result is the same to the bit.
  void search(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
              ContactResult& found, const TaskRunner* runner = nullptr);
  void giveIds(ContactResult& found);
  // A search whose result takes the place of `found` if the bodies touch. Whether they do.
  bool searchTouch(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
                   ContactResult& found);
  // Widens what a search has found, of bodies that touch lightly, to all that is at most a tenth of
  // a voxel behind the deepest place, with negative depths where it does not touch: a face that has
  // touched by one edge meets the other within the step. Only where that is broad both ways, at
  // least `broad` [m^2]: curved surfaces meet as they did without. Same bodies and settings as the
  // search's.
  void lookAround(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
                  double broad, ContactResult& found);
  // Adds to what a search has found points with negative depths where the bodies are about to meet
  // in other directions or places, within ContactSettings::margin: a peg that lies on one wall of
  // its hole is near the wall behind it, and where it leans, near the other end of the one that it
  // touches (sought with a margin of two voxels or more). `step` [s]: until when the bodies move on
  // as they do (ContactBody::motion). Same bodies and settings as the search's.
  void lookBeside(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
                  double step, ContactResult& found);
  // The same where they are near in other places, whichever way they face: the other feet of a
  // table that stands on some.
  void lookApart(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
                 ContactResult& found);
  // What all searches of this finder have taken, and how much of that were samples that the last
  // one looked up, with what was looked up around and beside it.
  const WorkCounts& work() const;
  std::size_t sampleLookups() const;
  // Memory that it keeps between searches, without the workspace's.
  std::size_t bytesKept() const;

  ContactBuilder& builder();  // internal: ContactBatch builds results of the device with it

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact
