// Finds the contact of two bodies: looks up samples of each in the other, groups the hits into
// patches, and reduces each patch to four points that keep its force and torque.
// docs/method.md, "Step 2: interference" to "Step 5: direction".
#pragma once

#include <cloudcontact/base/task_runner.h>
#include <cloudcontact/contact/contact.h>

#include <memory>

namespace cloudcontact {

// Finds contacts. It keeps its results and their names between calls; what it works with is lent by
// the process, as many times as queries run at once, and kept there, so that a step after the first
// allocates nothing. One finder serves one thread.
class ContactFinder {
 public:
  ContactFinder();
  ~ContactFinder();
  ContactFinder(ContactFinder&&) noexcept;
  ContactFinder& operator=(ContactFinder&&) noexcept;

  // "No contact" is an empty result. Throws std::invalid_argument where a body has neither field
  // nor shape, both bodies are shapes, or a pose is not finite.
  const ContactResult& find(const ContactBody& a, const ContactBody& b,
                            const ContactSettings& settings);

  // find() in two halves, for a question that is worked out before it is asked: search() throws as
  // find() does and remembers nothing of its bodies for a later search, so that it may turn out not
  // to be wanted; named(), once after a search that is, gives its points their ids. With `shareOut`
  // a large search is shared out over it; what is found is the same to the bit.
  void search(const ContactBody& a, const ContactBody& b, const ContactSettings& settings,
              const TaskRunner* shareOut = nullptr);
  const ContactResult& named();
  // Samples that the last search looked up: what it cost.
  std::size_t asked() const;

  // Where several threads search: gives what is lent the room that any query has needed, `threads`
  // times, so that none has to ask for more which another thread had asked for before. Between
  // steps.
  static void makeRoom(int threads);

  struct Scratch;  // its memory, which the backends share

 private:
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace cloudcontact
