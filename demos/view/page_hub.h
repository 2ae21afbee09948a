// What goes between a simulation and its pages, apart from sockets: the latest of each topic for
// them, their messages for it. For several threads.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cloudcontact::program {

// What an open page says.
struct PageMessage {
  int page = 0;      // its number
  std::string text;  // empty where the page is gone
  bool isGone = false;
};

// What a page has got so far.
struct PageProgress {
  std::optional<int> last;             // topic
  std::map<int, std::uint64_t> taken;  // version of each topic
};

class PageHub {
 public:
  static constexpr std::size_t kMostWaiting = 256;  // messages of a page that nobody has taken

  void publish(int topic, std::string bytes);
  // The next topic in turn of which the page lacks the latest bytes; null where it has all. A topic
  // that changes all the time does not keep the others from their turn.
  std::shared_ptr<const std::string> next(PageProgress& page);

  // Which messages take the place of one of their like that waits as its page's latest, such as
  // where a hand is by now. Of these no page has too many. None, if this is not called. Before the
  // first put().
  void mergeThose(std::function<bool(const std::string&)> merges) { merges_ = std::move(merges); }

  // False where too many of this page's messages wait; the message is then dropped. That a page is
  // gone is never dropped.
  bool put(PageMessage message);
  // Those since the last call, in order; waits for the first until `patience` is over.
  std::vector<PageMessage> messages(std::chrono::steady_clock::duration patience);

 private:
  struct Topic {
    std::shared_ptr<const std::string> bytes;
    std::uint64_t version = 0;
  };

  struct Waiting {
    std::size_t messages = 0;              // in inbox_
    std::optional<std::size_t> mergeable;  // the latest, by its place in inbox_
  };

  std::function<bool(const std::string&)> merges_;
  std::mutex mutex_;
  std::condition_variable said_;
  std::uint64_t versions_ = 0;
  std::map<int, Topic> topics_;
  std::vector<PageMessage> inbox_;
  std::map<int, Waiting> waiting_;  // of each page
};

}  // namespace cloudcontact::program
