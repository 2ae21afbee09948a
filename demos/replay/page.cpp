#include "replay/page.h"

#include <initializer_list>
#include <string_view>
#include <utility>

#include "io/html.h"
#include "replay/embedded.h"
#include "replay/gltf.h"
#include "replay/packed.h"
#include "replay/page_record.h"

namespace cloudcontact::program {
namespace {

using Filling = std::pair<std::string_view, std::string_view>;  // a name and what stands for it

// `text` with each {{NAME}} replaced once, in the order in which they stand in it.
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
  return filled(embedded::page_html(), {{"TITLE", asHtml(replay.title)},
                                        {"STYLE", embedded::page_css()},
                                        {"GLTF", gltf},
                                        {"RECORD", record},
                                        {"THREE", embedded::three_js()},
                                        {"ORBIT", embedded::orbit_js()},
                                        {"LOADER", embedded::gltf_js()},
                                        {"VIEWER", embedded::page_js()}});
}

}  // namespace cloudcontact::program
