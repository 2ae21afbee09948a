// Writes one element per primitive, with coordinates rounded to 0.1 px to keep files small.
#include "draw/svg.h"

#include <cmath>
#include <cstdio>

#include "io/text.h"

namespace cloudcontact::program {

namespace {

// At most one decimal, no locale and no "-0", so that the text is the same on every machine.
std::string shortNumber(double value) {
  const long long tenths = std::llround(10 * value);
  const long long size = tenths < 0 ? -tenths : tenths;
  std::string text = tenths < 0 ? "-" : "";
  if (size >= 10 || size % 10 == 0) text += std::to_string(size / 10);
  if (size % 10 != 0) text += "." + std::to_string(size % 10);
  return text;
}

std::string twoDecimals(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%d.%02d", static_cast<int>(value),
                static_cast<int>(std::lround(100 * value)) % 100);
  return text;
}

std::string escaped(const std::string& words) {
  std::string text;
  for (const char c : printable(words)) {
    if (c == '&') {
      text += "&amp;";
    } else if (c == '<') {
      text += "&lt;";
    } else if (c == '>') {
      text += "&gt;";
    } else if (c == '"') {
      text += "&quot;";
    } else {
      text += c;
    }
  }
  return text;
}

std::string attribute(const char* name, const std::string& value) {
  return std::string(" ") + name + "=\"" + value + "\"";
}

std::string colorText(const Color& c) {
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", c.red, c.green, c.blue);
  return text;
}

std::string paintText(const Paint& paint) {
  std::string text = attribute("fill", paint.fill ? colorText(*paint.fill) : "none");
  if (paint.fill && paint.fill->alpha < 1)
    text += attribute("fill-opacity", twoDecimals(paint.fill->alpha));
  if (!paint.stroke) return text;
  text += attribute("stroke", colorText(*paint.stroke)) +
          attribute("stroke-width", twoDecimals(paint.width));
  if (paint.stroke->alpha < 1)
    text += attribute("stroke-opacity", twoDecimals(paint.stroke->alpha));
  return text;
}

// The path's data. Steps connect rounded points, so that rounding errors do not add up.
std::string pathData(const Polygons& polygons) {
  std::string data;
  for (const auto& ring : polygons.rings) {
    Point last = Point::Zero();
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Point here = (10 * ring[k]).array().round() / 10;
      const std::string y = shortNumber(here.y() - last.y());
      data +=
          (k == 0 ? "M" : "l") + shortNumber(here.x() - last.x()) + (y[0] == '-' ? "" : " ") + y;
      last = here;
    }
    if (polygons.closed) data += "z";
  }
  return data;
}

struct SvgWriter {
  std::string body, definitions;
  int clips = 0;

  void operator()(const Polygons& p) {
    if (p.rings.empty()) return;
    body += "<path" + attribute("d", pathData(p)) + paintText(p.paint) + "/>\n";
  }
  void operator()(const Circle& c) {
    body += "<circle" + attribute("cx", shortNumber(c.center.x())) +
            attribute("cy", shortNumber(c.center.y())) + attribute("r", shortNumber(c.radius)) +
            paintText(c.paint) + "/>\n";
  }
  void operator()(const Text& t) {
    constexpr const char* anchors[] = {"start", "middle", "end"};
    body += "<text" + attribute("x", shortNumber(t.at.x())) +
            attribute("y", shortNumber(t.at.y())) + attribute("font-size", shortNumber(t.size)) +
            attribute("fill", colorText(t.color));
    if (t.align != Align::Left)
      body += attribute("text-anchor", anchors[static_cast<int>(t.align)]);
    if (t.bold) body += attribute("font-weight", "bold");
    if (t.halo)
      body += attribute("stroke", "#ffffff") + attribute("stroke-width", shortNumber(t.size / 4)) +
              attribute("paint-order", "stroke");
    body += ">" + escaped(t.words) + "</text>\n";
  }
  void operator()(const GroupBegin& g) {
    body += "<g" + attribute("id", escaped(g.name));
    if (g.clip) {
      const std::string name = "clip-" + std::to_string(++clips);
      const Point size = g.clip->size();
      definitions += "<clipPath" + attribute("id", name) + "><rect" +
                     attribute("x", shortNumber(g.clip->low.x())) +
                     attribute("y", shortNumber(g.clip->low.y())) +
                     attribute("width", shortNumber(size.x())) +
                     attribute("height", shortNumber(size.y())) + "/></clipPath>\n";
      body += attribute("clip-path", "url(#" + name + ")");
    }
    body += ">\n";
  }
  void operator()(const GroupEnd&) { body += "</g>\n"; }
};

}  // namespace

std::string svgText(const Drawing& drawing) {
  SvgWriter writer;
  for (const DrawingItem& item : drawing.items) std::visit(writer, item);
  const std::string width = shortNumber(drawing.width), height = shortNumber(drawing.height);
  // Fallback fonts: Verdana is as wide and Helvetica narrower, so that text still fits without
  // DejaVu.
  return "<svg xmlns=\"http://www.w3.org/2000/svg\"" + attribute("width", width) +
         attribute("height", height) + attribute("viewBox", "0 0 " + width + " " + height) +
         attribute("font-family", std::string(kFontFamily) + ", Verdana, Helvetica, sans-serif") +
         attribute("stroke-linejoin", "round") + attribute("stroke-linecap", "round") +
         ">\n<title>" + escaped(drawing.title) + "</title>\n" +
         (writer.definitions.empty() ? "" : "<defs>\n" + writer.definitions + "</defs>\n") +
         "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n" + writer.body + "</svg>\n";
}

}  // namespace cloudcontact::program
