// Numbers with units as text, three digits each, and text that is safe in files.
#pragma once

#include <Eigen/Core>
#include <string>

namespace cloudcontact::program {

// A length in um, mm or m: "0.25 mm".
std::string lengthText(double meters);
std::string volumeText(double cubicMeters);
std::string forceText(double newtons);
std::string energyText(double joules);
std::string timeText(double seconds);
std::string numberText(double value);  // two decimals below 10, else one
// "(0.12, -0.40, 0.91)"
std::string tripleText(const Eigen::Vector3d& v);
// Digits grouped in threes by thin spaces: "25 668".
std::string countText(std::size_t count);
// `text` as UTF-8 without control characters. Replaces each other byte by '?'.
std::string printable(const std::string& text);
// The file name of a path, shortened in the middle to `most` bytes.
std::string shortName(const std::string& path, std::size_t most = 34);

// `text` for HTML, with < and & escaped; not for attributes.
std::string asHtml(const std::string& text);

}  // namespace cloudcontact::program
