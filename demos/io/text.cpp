// Rounds numbers, picks units and checks UTF-8.
#include "io/text.h"

#include <cmath>
#include <cstdio>
#include <filesystem>

namespace cloudcontact::program {
namespace {

// Three digits, without an exponent below a million.
std::string threeDigits(double value) {
  char text[32];
  std::snprintf(text, sizeof text,
                std::abs(value) < 999.5 || std::abs(value) > 1e6 ? "%.3g" : "%.0f", value);
  return text;
}

// Length in bytes of the UTF-8 character at `k`; 0 if there is no valid one.
std::size_t characterAt(const std::string& text, std::size_t k) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(k);
  if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
  // 0xC0, 0xC1 and bytes above 0xF4 never start a character. Overlong and surrogate forms are
  // invalid too.
  const std::size_t length = first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
  if (length == 0 || first > 0xF4 || k + length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(k + i) & 0xC0) != 0x80) return 0;
  const unsigned char second = byte(k + 1);
  const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool outside = (first == 0xED && second > 0x9F) || (first == 0xF4 && second > 0x8F);
  // C1 control characters, and the two that XML does not allow.
  const bool control = first == 0xC2 && second < 0xA0;
  const bool noCharacter = first == 0xEF && second == 0xBF && byte(k + 2) >= 0xBE;
  return overlong || outside || control || noCharacter ? 0 : length;
}

}  // namespace

std::string lengthText(double meters) {
  const double size = std::abs(meters);
  if (size == 0) return "0 mm";
  if (size < 1e-5) return threeDigits(1e6 * meters) + " \u00b5m";
  if (size < 0.9995) return threeDigits(1e3 * meters) + " mm";
  return threeDigits(meters) + " m";
}

std::string volumeText(double cubicMeters) {
  if (cubicMeters < 1e-6) return threeDigits(1e9 * cubicMeters) + " mm\u00b3";
  if (cubicMeters < 1e-2) return threeDigits(1e6 * cubicMeters) + " cm\u00b3";
  return threeDigits(cubicMeters) + " m\u00b3";
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

std::string printable(const std::string& text) {
  std::string clean;
  for (std::size_t k = 0; k < text.size();) {
    const std::size_t length = characterAt(text, k);
    clean += length ? text.substr(k, length) : "?";
    k += std::max<std::size_t>(length, 1);
  }
  return clean;
}

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

}  // namespace cloudcontact::program
