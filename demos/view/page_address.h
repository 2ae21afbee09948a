// Who may ask a PageServer for what: the rules of its address, apart from sockets.
#pragma once

#include <string>
#include <string_view>

namespace cloudcontact::program {

// A request as HTTP states it; a header that is absent is empty.
struct PageRequest {
  std::string_view method, target, host, origin;
  bool isUpgrade = false;  // to a WebSocket
};

enum class PageAnswer {
  Page,          // 200
  Feed,          // 101
  WrongHost,     // 403: not a name of this machine
  WrongToken,    // 403
  WrongOrigin,   // 403: not the page itself
  WrongMethod,   // 405: not GET
  NoSuchThing,   // 404
  NeedsUpgrade,  // 426: the feed is for a WebSocket
};

PageAnswer answerTo(const PageRequest& request, std::string_view token);

// 32 random hexadecimal digits of the system's generator.
std::string newToken();

}  // namespace cloudcontact::program
