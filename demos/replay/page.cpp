// Fills the template of the page, and packs bytes.
#include "replay/page.h"

#include <zlib.h>

#include <algorithm>
#include <initializer_list>
#include <string_view>
#include <utility>

#include "io/errors.h"
#include "io/text.h"
#include "replay/embedded.h"
#include "replay/gltf.h"
#include "replay/page_record.h"

namespace cloudcontact::program {
namespace {

using Filling = std::pair<std::string_view, std::string_view>;  // a name and its text

// Replaces each {{NAME}} in `text`; `fillings` are in the order of the text.
std::string filled(std::string_view text, std::initializer_list<Filling> fillings) {
  std::size_t size = text.size();
  for (const Filling& f : fillings) size += f.second.size();
  std::string out;
  out.reserve(size);
  for (const auto& [name, value] : fillings) {
    const std::string mark = "{{" + std::string(name) + "}}";
    const std::size_t at = text.find(mark);
    out += text.substr(0, at);
    out += value;
    text.remove_prefix(at + mark.size());
  }
  out += text;
  return out;
}

}  // namespace

std::string pageBytes(const Replay& replay) {
  const std::string gltf = base64(deflated(gltfBytes(replay)));
  const std::string record = base64(deflated(pageRecord(replay)));
  // A served page may connect to its server, and is not asked for an icon.
  const std::string_view connect =
      replay.isLive ? "; connect-src ws://127.0.0.1:* ws://localhost:*" : "";
  const std::string_view icon = replay.isLive ? "<link rel=\"icon\" href=\"data:,\">\n" : "";
  return filled(embedded::page_html(), {{"CONNECT", connect},
                                        {"ICON", icon},
                                        {"TITLE", asHtml(replay.title)},
                                        {"STYLE", embedded::page_css()},
                                        {"GLTF", gltf},
                                        {"RECORD", record},
                                        {"THREE", embedded::three_js()},
                                        {"ORBIT", embedded::orbit_js()},
                                        {"LOADER", embedded::gltf_js()},
                                        {"VIEWER", embedded::page_js()}});
}

std::string deflated(const std::string& bytes) {
  // Half the time of level 6 for 12 % more bytes.
  constexpr int kLevel = 3;
  uLongf size = compressBound(bytes.size());
  std::string out(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(out.data()), &size,
                reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), kLevel) != Z_OK)
    throw WorkFailed("--replay: not enough memory to pack the page");
  out.resize(size);
  return out;
}

std::string base64(const std::string& bytes) {
  static constexpr char kLetters[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    unsigned triple = 0;
    for (std::size_t k = 0; k < 3; ++k)
      triple = triple << 8 | (k < n ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) out += k <= n ? kLetters[triple >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

}  // namespace cloudcontact::program
