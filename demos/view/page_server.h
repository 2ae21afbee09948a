// A page for browsers of this machine, and what goes to and fro while it is open: HTTP and
// WebSocket, by Boost.Beast. Knows nothing of worlds.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "view/page_hub.h"

namespace cloudcontact::program {

// Listens to 127.0.0.1 alone, in a thread of its own. It answers those who know this run's token,
// which is a part of the address: GET /TOKEN/ is the page, /TOKEN/feed the WebSocket. The Host must
// be 127.0.0.1 or localhost (another name that leads here is a page's trick), and a WebSocket must
// come from the page itself, as its Origin says. All else is refused with a status and a sentence.
class PageServer {
 public:
  static constexpr int kMostPages = 16;            // open at once
  static constexpr std::size_t kMostBytes = 4096;  // of a message from a page

  static constexpr std::chrono::seconds kPatience{10};

  // Takes the port (0: a free one) and keeps those waiting who come before serve(). Throws BadInput
  // where it cannot be had. A connection that makes no progress is dropped after the patience: a
  // request that does not come, a page that nobody reads.
  explicit PageServer(int port, std::chrono::steady_clock::duration patience = kPatience);
  // Sends what is published, then closes the pages; those that do not answer within a second are
  // left.
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  // From now on, once. `merges` says which messages PageHub::mergeThose() means.
  void serve(std::string page, std::function<bool(const std::string&)> merges = {});

  const std::string& url() const;  // with the token
  int port() const;
  int pages() const;  // open now

  // The latest bytes of a topic, for every page that is open or opens later. A page gets the
  // topics in turn, and misses what is replaced before its turn: a slow page slows nobody.
  void publish(int topic, std::string bytes);

  // PageHub::messages(): what the pages said.
  std::vector<PageMessage> messages(std::chrono::steady_clock::duration patience);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cloudcontact::program
