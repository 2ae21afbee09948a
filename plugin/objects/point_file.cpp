// Reads files of points: see point_file.h.
#include <cloudcontact/objects/point_file.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <stdexcept>

#include "base/file_name.h"
#include "mesh/ply.h"
#include "objects/pcd.h"

namespace cloudcontact {

namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

std::string bytesOf(const fs::path& file) {
  if (!fs::exists(file)) refuseFile(file, "no such file; check its name");
  if (!fs::is_regular_file(file)) refuseFile(file, "is not a file; give a file of points");
  std::ifstream in(file, std::ios::binary);
  if (!in) refuseFile(file, "cannot be read; check its permissions");
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (bytes.empty()) refuseFile(file, "is empty; save it again");
  return bytes;
}

// The raw contents of a file.
struct Read {
  std::vector<Vector3d> positions, normals;  // normals: none, or one per point
};

// The indices of coordinates among the properties of a vertex.
struct VertexPlaces {
  std::optional<std::size_t> xyz[3], normal[3];
  static bool all(const std::optional<std::size_t> (&p)[3]) { return p[0] && p[1] && p[2]; }
};

VertexPlaces placesIn(const PlyElement& vertex) {
  VertexPlaces places;
  for (std::size_t i = 0; i < vertex.properties.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::string& name = vertex.properties[i].name;
      if (name == std::string(1, "xyz"[k])) places.xyz[k] = i;
      if (name == std::string("n") + "xyz"[k]) places.normal[k] = i;
    }
  return places;
}

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
  if (header.format != "ascii" && !header.format.starts_with("binary_"))
    return "has a PLY header without a known format; export it again";
  PlyNumbers numbers(bytes.substr(header.length), header.format);
  for (const PlyElement& element : header.elements) {
    const bool isVertex = element.name == "vertex";
    const VertexPlaces places = placesIn(element);
    if (isVertex && !VertexPlaces::all(places.xyz))
      return "has vertices without x, y and z; export them too";
    const bool withNormals = VertexPlaces::all(places.normal);
    const auto take = [&](const std::vector<double>& v) {
      const auto three = [&](const std::optional<std::size_t>(&p)[3]) {
        return Vector3d(v[*p[0]], v[*p[1]], v[*p[2]]);
      };
      if (!isVertex) return;
      read.positions.push_back(three(places.xyz));
      if (withNormals) read.normals.push_back(three(places.normal));
    };
    if (!readElement(numbers, element, take))
      return "is cut short: its data end early; export it again";
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

DepthImage asImage(const fs::path& file, PcdPoints pcd, double metersPerUnit) {
  DepthImage image;
  image.width = pcd.width, image.height = pcd.height;
  image.viewpoint = metersPerUnit * pcd.viewpoint;
  image.points = std::move(pcd.positions);
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
  const std::string bytes = bytesOf(file), extension = lowerExtension(file);
  Read read;
  std::string fault;
  PcdPoints pcd;
  if (extension == ".pcd")
    fault = readPcd(bytes, pcd);
  else if (extension == ".ply")
    fault = readPly(bytes, read);
  else if (extension == ".xyz")
    fault = readXyz(bytes, read);
  else
    fault = "is of no known format; give a PLY, PCD or XYZ file";
  if (!fault.empty()) refuseFile(file, fault);
  if (extension == ".pcd" && pcd.height > 1) return asImage(file, std::move(pcd), metersPerUnit);
  if (extension == ".pcd") read = {std::move(pcd.positions), std::move(pcd.normals)};
  return asPoints(file, std::move(read), metersPerUnit);
}

}  // namespace cloudcontact
