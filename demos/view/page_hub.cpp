// The latest of each topic, and the inbox (page_hub.h).
#include "view/page_hub.h"

#include <utility>

namespace cloudcontact::program {

void PageHub::publish(int topic, std::string bytes) {
  auto shared = std::make_shared<const std::string>(std::move(bytes));
  const std::lock_guard lock(mutex_);
  topics_[topic] = {std::move(shared), ++versions_};
}

std::shared_ptr<const std::string> PageHub::next(PageProgress& page) {
  const std::lock_guard lock(mutex_);
  auto at = page.last ? topics_.upper_bound(*page.last) : topics_.begin();
  for (std::size_t looked = 0; looked < topics_.size(); ++looked, ++at) {
    if (at == topics_.end()) at = topics_.begin();
    std::uint64_t& taken = page.taken[at->first];
    if (taken == at->second.version) continue;
    taken = at->second.version;
    page.last = at->first;
    return at->second.bytes;
  }
  return nullptr;
}

bool PageHub::put(PageMessage message) {
  const bool merges = !message.isGone && merges_ && merges_(message.text);
  const std::lock_guard lock(mutex_);
  Waiting& waiting = waiting_[message.page];
  if (merges && waiting.mergeable) {
    inbox_[*waiting.mergeable].text = std::move(message.text);
    return true;
  }
  if (!message.isGone && waiting.messages == kMostWaiting) return false;
  ++waiting.messages;
  waiting.mergeable.reset();
  inbox_.push_back(std::move(message));
  if (merges) waiting.mergeable = inbox_.size() - 1;
  said_.notify_one();
  return true;
}

std::vector<PageMessage> PageHub::messages(std::chrono::steady_clock::duration patience) {
  std::unique_lock lock(mutex_);
  said_.wait_for(lock, patience, [this] { return !inbox_.empty(); });
  waiting_.clear();
  return std::exchange(inbox_, {});
}

}  // namespace cloudcontact::program
