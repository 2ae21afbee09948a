// Reads files of points: see point_file.h.
#include <cloudcontact/objects/point_file.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "base/file_name.h"
#include "mesh/ply.h"

namespace cloudcontact {

namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

// The raw contents of a file.
struct Read {
  std::vector<Vector3d> positions, normals;  // normals: none, or one per point
};

// The indices of coordinates among the numbers of a point. PLY and PCD call normals differently.
struct Places {
  std::optional<std::size_t> xyz[3], normal[3];
  const char* normals;

  void note(const std::string& name, std::size_t index) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (name == std::string(1, "xyz"[k])) xyz[k] = index;
      if (name == std::string(normals) + "xyz"[k]) normal[k] = index;
    }
  }
  static bool all(const std::optional<std::size_t> (&p)[3]) { return p[0] && p[1] && p[2]; }
  void take(const std::vector<double>& numbers, Read& read) const {
    const auto three = [&](const std::optional<std::size_t>(&p)[3]) {
      return Vector3d(numbers[*p[0]], numbers[*p[1]], numbers[*p[2]]);
    };
    read.positions.push_back(three(xyz));
    if (all(normal)) read.normals.push_back(three(normal));
  }
};

// Reads a whole element; false where the file ends early.
template <typename Take>
bool readElement(PlyNumbers& numbers, const PlyElement& element, Take&& take) {
  std::vector<double> values(element.properties.size());
  for (std::uint64_t i = 0; i < element.count && !values.empty(); ++i) {
    for (std::size_t k = 0; k < values.size(); ++k) {
      const PlyProperty& p = element.properties[k];
      const bool list = p.countSize > 0;
      const auto value = numbers.next(list ? p.countSize : p.size, list ? p.countKind : p.kind);
      if (!value) return false;
      values[k] = *value;
      if (!list) continue;
      for (double n = 0; n < *value; ++n)
        if (!numbers.next(p.size, p.kind)) return false;
    }
    take(values);
  }
  return true;
}

std::string readPly(std::string_view bytes, Read& read) {
  PlyHeader header;
  if (std::string fault = readPlyHeader(bytes, header); !fault.empty()) return fault;
  PlyNumbers numbers(bytes.substr(header.length), header.format);
  for (const PlyElement& element : header.elements) {
    const bool isVertex = element.name == "vertex";
    Places places{{}, {}, "n"};
    for (std::size_t i = 0; i < element.properties.size(); ++i)
      places.note(element.properties[i].name, i);
    if (isVertex && !Places::all(places.xyz))
      return "has vertices without x, y and z; export them too";
    const auto take = [&](const std::vector<double>& v) {
      if (isVertex) places.take(v, read);
    };
    if (!readElement(numbers, element, take))
      return "is cut short: its data end early; export it again";
  }
  return "";
}

constexpr const char* kCutShort = "is cut short: its data end early; save it again";

struct PcdField {
  std::string name;
  std::size_t size = 4, count = 1;
  char kind = 'f';
};

// The PCD format of the Point Cloud Library, versions .6 and .7, text and binary.
struct PcdHeader {
  std::vector<PcdField> fields;
  std::uint64_t width = 0, height = 1, points = 0;
  Vector3d viewpoint = Vector3d::Zero();
  std::string data;
  std::size_t length = 0;
};

// Reads one word per field; false where words are missing or malformed.
template <typename Take>
bool forEachField(std::istringstream& words, std::vector<PcdField>& fields, Take&& take) {
  for (PcdField& field : fields)
    if (std::string word; !(words >> word) || !take(field, word)) return false;
  return true;
}

bool takeCount(const std::string& word, std::size_t most, std::size_t& value) {
  char* end = nullptr;
  const long long number = std::strtoll(word.c_str(), &end, 10);
  if (*end != '\0' || number < 1 || static_cast<unsigned long long>(number) > most) return false;
  value = static_cast<std::size_t>(number);
  return true;
}

bool takeKind(const std::string& word, char& kind) {
  if (word != "F" && word != "I" && word != "U") return false;
  kind = word == "F" ? 'f' : word == "I" ? 'i' : 'u';
  return true;
}

// Reads a line of the header; false where it is malformed. Unknown lines are ignored.
bool readPcdLine(const std::string& line, PcdHeader& header) {
  std::istringstream words(line);
  std::string key;
  words >> key;
  if (key == "FIELDS" || key == "COLUMNS") {
    header.fields.clear();
    for (std::string name; words >> name;) header.fields.push_back({name});
    return !header.fields.empty();
  }
  if (key == "SIZE")
    return forEachField(words, header.fields, [](PcdField& f, const std::string& w) {
      return takeCount(w, 8, f.size) && (f.size & (f.size - 1)) == 0;
    });
  if (key == "TYPE")
    return forEachField(words, header.fields,
                        [](PcdField& f, const std::string& w) { return takeKind(w, f.kind); });
  if (key == "COUNT")
    return forEachField(words, header.fields, [](PcdField& f, const std::string& w) {
      return takeCount(w, 1u << 20, f.count);
    });
  if (key == "WIDTH") return bool(words >> header.width);
  if (key == "HEIGHT") return bool(words >> header.height);
  if (key == "POINTS") return bool(words >> header.points);
  if (key == "VIEWPOINT")
    return bool(words >> header.viewpoint[0] >> header.viewpoint[1] >> header.viewpoint[2]);
  if (key == "DATA") return bool(words >> header.data);
  return true;
}

std::string readPcdHeader(std::string_view bytes, PcdHeader& header) {
  std::size_t at = 0;
  while (header.data.empty()) {
    const std::size_t end = bytes.find('\n', at);
    if (end == std::string_view::npos)
      return "is no PCD, or cut short: its header has no DATA; save it again";
    std::string line(bytes.substr(at, end - at));
    at = end + 1;
    if (const std::size_t comment = line.find('#'); comment != std::string::npos)
      line.resize(comment);
    if (!readPcdLine(line, header))
      return "has a PCD header with a bad line: " + line.substr(0, 60);
  }
  header.length = at;
  if (header.data == "binary_compressed")
    return "is a compressed PCD; save it as ascii or binary (pcl_convert_pcd_ascii_binary)";
  if (header.data != "ascii" && header.data != "binary")
    return "has PCD data of no known kind; save it as ascii or binary";
  constexpr std::uint64_t kMost = std::uint64_t{1} << 31;
  if (header.width == 0 || header.height == 0 || header.width >= kMost || header.height >= kMost)
    return "has no points, or impossible sizes; save it again";
  if (header.points != 0 && header.points != header.width * header.height)
    return "says " + std::to_string(header.points) + " points, but its width and height others";
  header.points = header.width * header.height;
  return "";
}

std::string readPcd(std::string_view bytes, PcdHeader& header, Read& read) {
  if (std::string fault = readPcdHeader(bytes, header); !fault.empty()) return fault;
  Places places{{}, {}, "normal_"};
  std::size_t numbersOfPoint = 0, bytesOfPoint = 0;
  for (const PcdField& f : header.fields) {
    places.note(f.name, numbersOfPoint);
    numbersOfPoint += f.count;
    bytesOfPoint += f.count * f.size;
  }
  if (!Places::all(places.xyz)) return "has no fields x, y and z; save it with them";
  const std::size_t left = bytes.size() - header.length;
  // A number takes at least a digit and a blank, but for the last. Checked before anything is
  // allocated.
  const bool isText = header.data == "ascii";
  const std::size_t least = isText ? 2 * numbersOfPoint : bytesOfPoint;
  if (header.points > (isText ? left + 1 : left) / least) return kCutShort;
  PlyNumbers numbers(bytes.substr(header.length), header.data);
  read.positions.reserve(header.points);
  std::vector<double> one(numbersOfPoint);
  for (std::uint64_t i = 0; i < header.points; ++i) {
    std::size_t at = 0;
    for (const PcdField& f : header.fields)
      for (std::size_t k = 0; k < f.count; ++k) {
        const std::optional<double> value = numbers.next(f.size, f.kind);
        if (!value) return kCutShort;
        one[at++] = *value;
      }
    places.take(one, read);
  }
  return "";
}

// Rows of numbers. Empty rows and text after # are ignored.
std::string readXyz(std::string_view text, Read& read) {
  std::size_t row = 0;
  for (std::size_t at = 0; at < text.size(); ++row) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string line(text.substr(at, end - at));
    at = end + 1;
    if (const std::size_t comment = line.find('#'); comment != std::string::npos)
      line.resize(comment);
    std::replace_if(
        line.begin(), line.end(), [](char c) { return c == ',' || c == ';'; }, ' ');
    std::string_view words = line;
    double values[6];
    int count = 0;
    for (std::string_view word = nextWord(words); !word.empty(); word = nextWord(words)) {
      if (!isNumber(word))
        return "has `" + std::string(word.substr(0, 20)) + "` where a number should be, in row " +
               std::to_string(row + 1) + "; give rows of x y z";
      if (count < 6) values[count++] = std::strtod(std::string(word).c_str(), nullptr);
    }
    if (count == 0) continue;
    if (count < 3)
      return "has fewer than three numbers in row " + std::to_string(row + 1) +
             "; give rows of x y z";
    read.positions.emplace_back(values[0], values[1], values[2]);
    if (count == 6) read.normals.emplace_back(values[3], values[4], values[5]);
  }
  return "";
}

// Columns after x y z may be colors; they are normals where all are of length 1.
bool areNormals(const Read& read) {
  if (read.normals.size() != read.positions.size()) return false;
  return std::all_of(read.normals.begin(), read.normals.end(),
                     [](const Vector3d& n) { return std::abs(n.norm() - 1) < 0.05; });
}

PointCloud asPoints(const fs::path& file, Read read, double metersPerUnit) {
  if (read.positions.empty()) refuseFile(file, "has no points; export it again");
  PointCloud points;
  if (areNormals(read))
    for (const Vector3d& n : read.normals) points.normals.push_back(n.normalized().cast<float>());
  points.positions = std::move(read.positions);
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    Vector3d& p = points.positions[i];
    p *= metersPerUnit;
    if (!p.allFinite())
      refuseFile(file,
                 "point " + std::to_string(i) +
                     " is NaN or infinite; take such points away (a PCD with rows keeps them as "
                     "holes)");
  }
  return points;
}

DepthImage asImage(const fs::path& file, const PcdHeader& pcd, Read read, double metersPerUnit) {
  DepthImage image;
  image.width = static_cast<int>(pcd.width), image.height = static_cast<int>(pcd.height);
  image.viewpoint = metersPerUnit * pcd.viewpoint;
  image.points = std::move(read.positions);
  for (Vector3d& p : image.points) {
    p *= metersPerUnit;
    // Cameras mark pixels without a point by NaN or infinity, some by the viewpoint itself.
    if (!p.allFinite() || p == image.viewpoint)
      p.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  try {
    validate(image);
  } catch (const std::invalid_argument& e) {
    refuseFile(file, e.what());
  }
  return image;
}

}  // namespace

bool isPointFile(const fs::path& file) {
  const std::string extension = lowerExtension(file);
  if (extension == ".pcd" || extension == ".xyz") return true;
  std::error_code error;
  if (extension != ".ply" || !fs::is_regular_file(file, error)) return false;
  std::ifstream in(file, std::ios::binary);
  std::string start(1 << 16, '\0');
  in.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(in.gcount());
  PlyHeader header;
  if (!readPlyHeader(start, header).empty()) return false;
  const auto count = [&](const char* name) {
    for (const PlyElement& e : header.elements)
      if (e.name == name) return e.count;
    return std::uint64_t{0};
  };
  return count("vertex") > 0 && count("face") == 0 && count("tristrips") == 0;
}

PointFile loadPoints(const fs::path& file, double metersPerUnit) {
  if (!(metersPerUnit > 0) || !std::isfinite(metersPerUnit))
    refuseFile(file, "metersPerUnit must be positive and finite");
  const std::string bytes = bytesOfFile(file, "a file of points"), extension = lowerExtension(file);
  Read read;
  std::string fault;
  PcdHeader pcd;
  if (extension == ".pcd")
    fault = readPcd(bytes, pcd, read);
  else if (extension == ".ply")
    fault = readPly(bytes, read);
  else if (extension == ".xyz")
    fault = readXyz(bytes, read);
  else
    fault = "is of no known format; give a PLY, PCD or XYZ file";
  if (!fault.empty()) refuseFile(file, fault);
  if (extension == ".pcd" && pcd.height > 1)
    return asImage(file, pcd, std::move(read), metersPerUnit);
  return asPoints(file, std::move(read), metersPerUnit);
}

}  // namespace cloudcontact
