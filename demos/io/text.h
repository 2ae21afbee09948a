// Figures as people read them: three digits, in the unit that suits. And names from files.
#pragma once

#include <Eigen/Core>
#include <string>

namespace cloudcontact::program {

// A length in the unit that suits it (um, mm, m), three digits: "0.25 mm".
std::string lengthText(double metres);
std::string volumeText(double cubicMetres);
std::string forceText(double newtons);
std::string energyText(double joules);
std::string timeText(double seconds);
std::string numberText(double value);  // two digits after the point, one from ten on
// "(0.12, -0.40, 0.91)"
std::string tripleText(const Eigen::Vector3d& v);
// Whole numbers with thin gaps: "25 668".
std::string countText(std::size_t count);
// `text` as UTF-8 without control characters, as all files want it; what is neither is shown as
// '?'.
std::string printable(const std::string& text);
// The last part of a path, shortened in its middle to `most` characters.
std::string shortName(const std::string& path, std::size_t most = 34);

// `text` for HTML, with < and & escaped; not for attributes.
std::string asHtml(const std::string& text);

}  // namespace cloudcontact::program
