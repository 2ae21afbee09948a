// Elements shared by all pictures: colors, titles, scale bars, tables, keys.
#pragma once

#include <Eigen/Core>
#include <string>

#include "draw/drawing.h"
#include "io/text.h"

namespace cloudcontact::program {

inline constexpr Color kInk{32, 36, 44}, kFaintInk{96, 103, 115}, kRule{205, 209, 216};
inline constexpr Color kPaperWhite{255, 255, 255};
inline constexpr double kWidth = 1200, kMargin = 24;  // of a whole picture [px]
inline constexpr double kTextSize = 14, kSmallText = 13;

void addTitle(Drawing& drawing, const std::string& title, const std::string& below);
// Adds a bar of round length in the frame's lower left corner.
void addScaleBar(Drawing& drawing, const Rectangle& frame, double pxPerMeter);
void addFrame(Drawing& drawing, const Rectangle& frame);
Rectangle belowCaption(const Rectangle& frame);  // the frame without its caption
// Adds a line of text and a scale bar at the top of a small frame.
void addCaption(Drawing& drawing, const Rectangle& frame, const std::string& words,
                double pxPerMeter);

// A table, filled from top to bottom: names on the left, figures on the right.
class Table {
 public:
  Table(Drawing& drawing, const Point& at, double width);
  void heading(const std::string& words);
  void row(const std::string& name, const std::string& figure);
  void note(const std::string& words);
  void space(double px) { y_ += px; }

 private:
  Drawing& drawing_;
  double left_, width_, y_;
};

// One entry of a key: a bold term and a line of explanation at `at`, to the right of its symbol.
void addKeyText(Drawing& drawing, const Point& at, const std::string& term,
                const std::string& meaning);

}  // namespace cloudcontact::program
