// A palette for most color-blind eyes (after Okabe and Ito 2008, softened), used in a cycle.
#include "replay/body_colors.h"

#include <cmath>
#include <cstdio>

namespace cloudcontact::program {
namespace {

constexpr std::array<unsigned, 8> kMoving = {0xe08a2e, 0x3f7fc4, 0x4ca66b, 0xc8577e,
                                             0x7a6bc0, 0xd8b93a, 0x3fa9b5, 0xb5583a};
constexpr std::array<unsigned, 3> kFixed = {0xa9b1bd, 0x8f99a8, 0xc2c0b8};
constexpr unsigned kPlane = 0xdfe2e7;

// The inverse of sRGB's transfer function (IEC 61966-2-1).
double linear(unsigned value) {
  const double v = value / 255.0;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

BodyColor colorOf(unsigned code) {
  char name[8];
  std::snprintf(name, sizeof name, "#%06x", code);
  return {name, {linear(code >> 16 & 255), linear(code >> 8 & 255), linear(code & 255)}};
}

}  // namespace

std::vector<BodyColor> bodyColors(const std::vector<ReplayBody>& bodies) {
  std::vector<BodyColor> colors;
  std::size_t fixed = 0, moving = 0;
  for (const ReplayBody& body : bodies) {
    if (body.drawn.isPlane())
      colors.push_back(colorOf(kPlane));
    else
      colors.push_back(colorOf(body.isStatic ? kFixed[fixed++ % kFixed.size()]
                                             : kMoving[moving++ % kMoving.size()]));
  }
  return colors;
}

}  // namespace cloudcontact::program
