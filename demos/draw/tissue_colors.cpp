// Known tissues by name, others by their place in the list.
#include "draw/tissue_colors.h"

#include <array>
#include <utility>

#include "draw/picture_elements.h"

namespace cloudcontact::program {

std::vector<Color> tissueColors(const std::vector<std::string>& names) {
  static const std::array<std::pair<const char*, Color>, 7> kKnown = {{{"enamel", {150, 185, 220}},
                                                                       {"dentin", {232, 196, 106}},
                                                                       {"pulp", {214, 84, 84}},
                                                                       {"caries", {122, 78, 48}},
                                                                       {"skin", {231, 178, 148}},
                                                                       {"fat", {240, 220, 130}},
                                                                       {"muscle", {178, 72, 66}}}};
  static const std::array<Color, 6> kOthers = {{{110, 160, 120},
                                                {160, 130, 190},
                                                {90, 165, 175},
                                                {205, 140, 90},
                                                {150, 150, 160},
                                                {190, 120, 150}}};
  std::vector<Color> colors;
  for (std::size_t k = 0; k < names.size(); ++k) {
    colors.push_back(kOthers[k % kOthers.size()]);
    for (const auto& [name, color] : kKnown)
      if (names[k].starts_with(name)) colors.back() = color;  // "enamel (part 1)" too
  }
  return colors;
}

double addTissueKey(Drawing& drawing, const Point& at, const std::string& name,
                    const Color& color) {
  const std::string words = shortName(printable(name), 20);
  drawing.add(Polygons{{ringOf({at - Point(0, 12), at + Point(14, 2)})}, {color, kRule, 1}});
  drawing.add(Text{at + Point(20, 0), words, kTextSize, kInk});
  return at.x() + 20 + widthOf(words, kTextSize) + 22;
}

}  // namespace cloudcontact::program
