// The rules of a PageServer's address (page_address.h).
#include "view/page_address.h"

#include <random>

namespace cloudcontact::program {
namespace {

// 127.0.0.1 or localhost, with any port: a tunnel's may differ.
bool isThisMachine(std::string_view host) {
  const std::size_t colon = host.rfind(':');
  const std::string_view name = host.substr(0, colon);
  if (colon != std::string_view::npos &&
      host.substr(colon + 1).find_first_not_of("0123456789") != std::string_view::npos)
    return false;
  return name == "127.0.0.1" || name == "localhost";
}

// Takes the same time for all texts of one length, so that time tells nothing of the token.
bool same(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned differ = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    differ |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return differ == 0;
}

}  // namespace

PageAnswer answerTo(const PageRequest& request, std::string_view token) {
  if (!isThisMachine(request.host)) return PageAnswer::WrongHost;
  std::string_view target = request.target.substr(0, request.target.find('?'));
  if (target.size() < token.size() + 2 || target[0] != '/' || target[token.size() + 1] != '/' ||
      !same(target.substr(1, token.size()), token))
    return PageAnswer::WrongToken;
  target.remove_prefix(token.size() + 2);
  if (request.method != "GET") return PageAnswer::WrongMethod;
  if (target.empty()) return PageAnswer::Page;
  if (target != "feed") return PageAnswer::NoSuchThing;
  if (!request.isUpgrade) return PageAnswer::NeedsUpgrade;
  return request.origin == "http://" + std::string(request.host) ? PageAnswer::Feed
                                                                 : PageAnswer::WrongOrigin;
}

std::string newToken() {
  std::random_device system;
  std::string token;
  for (int word = 0; word < 4; ++word) {
    const unsigned bits = system();
    for (int digit = 0; digit < 8; ++digit) token += "0123456789abcdef"[bits >> 4 * digit & 15];
  }
  return token;
}

}  // namespace cloudcontact::program
