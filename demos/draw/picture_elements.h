// What all our pictures share: colours, scale bars, tables, keys.
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
// A bar of a round length in the frame's lower left corner.
void addScaleBar(Drawing& drawing, const Rectangle& frame, double pxPerMetre);
void addFrame(Drawing& drawing, const Rectangle& frame);
Rectangle belowCaption(const Rectangle& frame);  // what a caption leaves of it
// A line on top of a small frame: what it shows, and a bar of a round length.
void addCaption(Drawing& drawing, const Rectangle& frame, const std::string& words,
                double pxPerMetre);

// Lines of a table from its top downward: names on the left, figures on the right.
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

// One entry of a key: a bold term and a line that explains it, right of a symbol `at`.
void addKeyText(Drawing& drawing, const Point& at, const std::string& term,
                const std::string& meaning);

}  // namespace cloudcontact::program
