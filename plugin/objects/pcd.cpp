// Reads PCD: see pcd.h.
#include "objects/pcd.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <sstream>

#include "mesh/ply.h"

namespace cloudcontact {

namespace {

constexpr const char* kCutShort = "is cut short: its data end early; save it again";

struct Field {
  std::string name;
  std::size_t size = 4, count = 1;
  char kind = 'f';
};

struct Header {
  std::vector<Field> fields;
  std::uint64_t width = 0, height = 1, points = 0;
  Eigen::Vector3d viewpoint = Eigen::Vector3d::Zero();
  std::string data;
  std::size_t length = 0;
};

// Reads one word per field; false where words are missing or malformed.
template <typename Take>
bool forEachField(std::istringstream& words, std::vector<Field>& fields, Take&& take) {
  for (Field& field : fields)
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
bool readLine(const std::string& line, Header& header) {
  std::istringstream words(line);
  std::string key;
  words >> key;
  if (key == "FIELDS" || key == "COLUMNS") {
    header.fields.clear();
    for (std::string name; words >> name;) header.fields.push_back({name});
    return !header.fields.empty();
  }
  if (key == "SIZE")
    return forEachField(words, header.fields, [](Field& f, const std::string& w) {
      return takeCount(w, 8, f.size) && (f.size & (f.size - 1)) == 0;
    });
  if (key == "TYPE")
    return forEachField(words, header.fields,
                        [](Field& f, const std::string& w) { return takeKind(w, f.kind); });
  if (key == "COUNT")
    return forEachField(words, header.fields, [](Field& f, const std::string& w) {
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

std::string readHeader(std::string_view bytes, Header& header) {
  std::size_t at = 0;
  while (header.data.empty()) {
    const std::size_t end = bytes.find('\n', at);
    if (end == std::string_view::npos)
      return "is no PCD, or cut short: its header has no DATA; save it again";
    std::string line(bytes.substr(at, end - at));
    at = end + 1;
    if (const std::size_t comment = line.find('#'); comment != std::string::npos)
      line.resize(comment);
    if (!readLine(line, header)) return "has a PCD header with a bad line: " + line.substr(0, 60);
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

// The indices of coordinates among the numbers of a point.
struct Places {
  std::optional<std::size_t> xyz[3], normal[3];
  std::size_t numbers = 0, bytes = 0;  // of one point
};

Places placesIn(const Header& header) {
  Places places;
  for (const Field& f : header.fields) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (f.name == std::string(1, "xyz"[k])) places.xyz[k] = places.numbers;
      if (f.name == std::string("normal_") + "xyz"[k]) places.normal[k] = places.numbers;
    }
    places.numbers += f.count;
    places.bytes += f.count * f.size;
  }
  return places;
}

bool all(const std::optional<std::size_t> (&three)[3]) {
  return three[0] && three[1] && three[2];
}

}  // namespace

std::string readPcd(std::string_view bytes, PcdPoints& points) {
  Header header;
  if (std::string fault = readHeader(bytes, header); !fault.empty()) return fault;
  const Places places = placesIn(header);
  if (!all(places.xyz)) return "has no fields x, y and z; save it with them";
  const std::size_t left = bytes.size() - header.length;
  // A number takes at least a digit and a blank, but for the last. Checked before anything is
  // allocated.
  const bool isText = header.data == "ascii";
  const std::size_t least = isText ? 2 * places.numbers : places.bytes;
  if (header.points > (isText ? left + 1 : left) / least) return kCutShort;
  PlyNumbers numbers(bytes.substr(header.length), header.data);
  points.width = static_cast<int>(header.width);
  points.height = static_cast<int>(header.height);
  points.viewpoint = header.viewpoint;
  points.positions.reserve(header.points);
  std::vector<double> one(places.numbers);
  for (std::uint64_t i = 0; i < header.points; ++i) {
    std::size_t at = 0;
    for (const Field& f : header.fields)
      for (std::size_t k = 0; k < f.count; ++k) {
        const std::optional<double> value = numbers.next(f.size, f.kind);
        if (!value) return kCutShort;
        one[at++] = *value;
      }
    const auto three = [&](const std::optional<std::size_t>(&which)[3]) {
      return Eigen::Vector3d(one[*which[0]], one[*which[1]], one[*which[2]]);
    };
    points.positions.push_back(three(places.xyz));
    if (all(places.normal)) points.normals.push_back(three(places.normal));
  }
  return "";
}

}  // namespace cloudcontact
