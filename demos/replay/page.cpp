#include "replay/page.h"

#include "replay/embedded.h"
#include "replay/gltf.h"
#include "replay/packed.h"
#include "replay/page_record.h"

namespace cloudcontact::program {
namespace {

std::string asHtml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '&')
      out += "&amp;";
    else
      out += c;
  }
  return out;
}

// The template with each {{NAME}} replaced once, in the order in which they stand in it.
class Template {
 public:
  explicit Template(std::string_view text) : rest_(text) {}
  void put(const std::string& name, std::string_view value) {
    const std::string mark = "{{" + name + "}}";
    const std::size_t at = rest_.find(mark);
    out_ += rest_.substr(0, at);
    out_ += value;
    rest_.remove_prefix(at + mark.size());
  }
  std::string text() const { return out_ + std::string(rest_); }

 private:
  std::string_view rest_;
  std::string out_;
};

}  // namespace

std::string pageBytes(const Replay& replay) {
  Template page(embedded::page_html());
  page.put("TITLE", asHtml(replay.title));
  page.put("STYLE", embedded::page_css());
  page.put("GLTF", base64(deflated(gltfBytes(replay))));
  page.put("RECORD", base64(deflated(pageRecord(replay))));
  page.put("THREE", embedded::three_js());
  page.put("ORBIT", embedded::orbit_js());
  page.put("LOADER", embedded::gltf_js());
  page.put("VIEWER", embedded::page_js());
  return page.text();
}

}  // namespace cloudcontact::program
