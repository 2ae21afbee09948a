// A drawing as a list of primitives, from which svg.h and png.h make files that look alike. Lengths
// in px at 96 dpi, x to the right, y down.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace cloudcontact::program {

using Point = Eigen::Vector2d;

struct Color {
  std::uint8_t red = 0, green = 0, blue = 0;
  double alpha = 1;  // 0 clear .. 1 opaque
};

// Fill and outline of a shape; none if empty.
struct Paint {
  std::optional<Color> fill, stroke;
  double width = 1;  // of the stroke [px]
};

struct Rectangle {
  Point low = Point::Zero(), high = Point::Zero();  // upper left and lower right corner

  Point size() const { return high - low; }
  Point center() const { return (low + high) / 2; }
  bool contains(const Point& p) const {
    return (p.array() >= low.array()).all() && (p.array() <= high.array()).all();
  }
};

// Polygons with the same paint, so that a thousand voxels of one shade are one element.
struct Polygons {
  std::vector<std::vector<Point>> rings;
  Paint paint;
  bool closed = true;  // false: lines through the points
};

struct Circle {
  Point center = Point::Zero();
  double radius = 1;
  Paint paint;
};

enum class Align { Left, Middle, Right };

// One line of text; `at` is on its baseline.
struct Text {
  Point at = Point::Zero();
  std::string words;  // UTF-8
  double size = 14;
  Color color;
  Align align = Align::Left;
  bool bold = false;
  bool halo = false;  // a white outline, for text over other shapes
};

// Items between a begin and its end form a named group, clipped at `clip`. Groups may nest.
struct GroupBegin {
  std::string name;
  std::optional<Rectangle> clip;
};
struct GroupEnd {};

using DrawingItem = std::variant<Polygons, Circle, Text, GroupBegin, GroupEnd>;

struct Drawing {
  double width = 0, height = 0;
  std::string title;
  std::vector<DrawingItem> items;

  void add(DrawingItem item) { items.push_back(std::move(item)); }
};

// The font of all text and of widthOf().
inline constexpr const char* kFontFamily = "DejaVu Sans";
// Approximate upper bound for the width of a line of text, for placing it. [px]
double widthOf(const std::string& words, double size, bool bold = false);

std::vector<Point> ringOf(const Rectangle& rectangle);
Polygons line(const Point& from, const Point& to, const Color& color, double width);
// A filled arrow with a shaft of `width` and a head in proportion.
Polygons arrow(const Point& from, const Point& to, const Color& color, double width);

}  // namespace cloudcontact::program
