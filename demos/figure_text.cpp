// Rounding, units, gaps.
#include "figure_text.h"

#include <cmath>
#include <cstdio>
#include <filesystem>

namespace cloudcontact::program {
namespace {

// Three digits, never an exponent where the number is below a million.
std::string threeDigits(double value) {
  char text[32];
  std::snprintf(text, sizeof text,
                std::abs(value) < 999.5 || std::abs(value) > 1e6 ? "%.3g" : "%.0f", value);
  return text;
}

}  // namespace

std::string lengthText(double metres) {
  const double size = std::abs(metres);
  if (size == 0) return "0 mm";
  if (size < 1e-5) return threeDigits(1e6 * metres) + " \u00b5m";
  if (size < 0.9995) return threeDigits(1e3 * metres) + " mm";
  return threeDigits(metres) + " m";
}

std::string volumeText(double cubicMetres) {
  if (cubicMetres < 1e-6) return threeDigits(1e9 * cubicMetres) + " mm\u00b3";
  if (cubicMetres < 1e-2) return threeDigits(1e6 * cubicMetres) + " cm\u00b3";
  return threeDigits(cubicMetres) + " m\u00b3";
}

std::string forceText(double newtons) {
  const double size = std::abs(newtons);
  if (size > 0 && size < 0.1) return threeDigits(1e3 * newtons) + " mN";
  if (size >= 1000) return threeDigits(1e-3 * newtons) + " kN";
  return threeDigits(newtons) + " N";
}

std::string energyText(double joules) {
  const double size = std::abs(joules);
  if (size > 0 && size < 1e-4) return threeDigits(1e6 * joules) + " \u00b5J";
  if (size > 0 && size < 0.1) return threeDigits(1e3 * joules) + " mJ";
  if (size >= 1000) return threeDigits(1e-3 * joules) + " kJ";
  return threeDigits(joules) + " J";
}

std::string timeText(double seconds) {
  const double size = std::abs(seconds);
  if (size > 0 && size < 1e-4) return threeDigits(1e6 * seconds) + " \u00b5s";
  if (size > 0 && size < 0.1) return threeDigits(1e3 * seconds) + " ms";
  return threeDigits(seconds) + " s";
}

std::string numberText(double value) {
  char text[32];
  std::snprintf(text, sizeof text, std::abs(value) < 9.995 ? "%.2f" : "%.1f", value);
  return text;
}

std::string tripleText(const Eigen::Vector3d& v) {
  std::string text;
  for (int k = 0; k < 3; ++k) {
    char number[48];
    std::snprintf(number, sizeof number, "%.3f", std::abs(v[k]) < 5e-4 ? 0.0 : v[k]);
    text += (k ? ", " : "(") + std::string(number);
  }
  return text + ")";
}

std::string countText(std::size_t count) {
  std::string text = std::to_string(count);
  for (int k = static_cast<int>(text.size()) - 3; k > 0; k -= 3)
    text.insert(static_cast<std::size_t>(k), "\u2009");
  return text;
}

std::string shortName(const std::string& path, std::size_t most) {
  const std::string name = std::filesystem::path(path).filename().string();
  if (name.size() <= most) return name;
  const std::size_t half = (most - 1) / 2;
  return name.substr(0, half) + "\u2026" + name.substr(name.size() - half);
}

}  // namespace cloudcontact::program
