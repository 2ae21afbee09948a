// Headers are lines of text: `field: value` in NRRD, `Key = Value` in MetaImage.
#include "voxels/volume_header.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "base/file_name.h"

namespace cloudcontact {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestLine = 1 << 16;
constexpr double kMostValues = 2147483647;  // along an axis

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// The numbers of a text, in which brackets and commas are blanks; empty where a word is none.
std::vector<double> numbersIn(std::string text) {
  for (char& c : text)
    if (c == '(' || c == ')' || c == ',') c = ' ';
  std::istringstream in(text);
  std::vector<double> numbers;
  for (std::string word; in >> word;) {
    char* end = nullptr;
    numbers.push_back(std::strtod(word.c_str(), &end));
    if (*end != '\0' || !std::isfinite(numbers.back())) return {};
  }
  return numbers;
}

// The fields of a header by their names in small letters, and where it ends.
class Fields {
 public:
  // Reads lines up to `last`, an empty line or a field.
  Fields(const fs::path& file, char separator, const std::string& last)
      : file_(file), separator_(separator) {
    std::ifstream in = openFile(file, "a volume file");
    for (std::string line; nextLine(in, line);) {
      const std::string name = add(line);
      end_ = in.tellg();
      if (name == last && !magic_.empty()) return;
    }
    if (!last.empty())
      refuseFile(file, "is cut short: its header has no " + last + "; save it again");
    end_ = static_cast<std::int64_t>(
        fs::file_size(file));  // a detached header may end without an empty line
  }

  const std::string& magic() const { return magic_; }
  std::int64_t end() const { return end_; }
  bool has(const std::string& name) const { return values_.count(name) > 0; }
  std::string text(const std::string& name) const {
    const auto found = values_.find(name);
    return found == values_.end() ? "" : found->second;
  }
  std::string needed(const std::string& name, const std::string& example) const {
    if (text(name).empty()) refuse(name, "is missing; write " + shown(name) + " " + example);
    return text(name);
  }
  // `count` numbers; empty where the field is missing.
  std::vector<double> numbers(const std::string& name, std::size_t count) const {
    if (!has(name)) return {};
    const std::vector<double> found = numbersIn(text(name));
    if (found.size() != count)
      refuse(name, "is `" + text(name).substr(0, 40) + "`; give " + std::to_string(count) +
                       " finite numbers");
    return found;
  }
  [[noreturn]] void refuse(const std::string& name, const std::string& why) const {
    refuseFile(file_, "field `" + name + "` " + why);
  }

 private:
  std::string shown(const std::string& name) const {
    return separator_ == ':' ? name + ":" : name + " =";
  }
  bool nextLine(std::istream& in, std::string& line) const {
    line.clear();
    for (int c = in.get(); c != EOF; c = in.get()) {
      if (c == '\n') return true;
      if (line.size() == kLongestLine || c == '\0')
        refuseFile(file_, "has no header of text; give an NRRD or MetaImage file");
      line += static_cast<char>(c);
    }
    return !line.empty() && !in.bad() && (in.clear(), in.seekg(0, std::ios::end), true);
  }
  // The name of the field that the line holds; empty where it holds none.
  std::string add(const std::string& line) {
    const std::string content = trimmed(line);
    if (magic_.empty()) magic_ = content.empty() ? "?" : content;
    const auto at = content.find(separator_);
    if (content.empty() || content[0] == '#' || at == std::string::npos) return content;
    if (separator_ == ':' && content.compare(at, 2, ":=") == 0) return content;  // a note
    const std::string name = lower(trimmed(content.substr(0, at)));
    values_[name] = trimmed(content.substr(at + 1));
    return name;
  }

  fs::path file_;
  char separator_;
  std::string magic_;  // the first line
  std::map<std::string, std::string> values_;
  std::int64_t end_ = 0;
};

struct TypeName {
  const char* name;
  ValueType type;
};
constexpr TypeName kNrrdTypes[] = {
    {"signed char", ValueType::I8},   {"int8", ValueType::I8},
    {"int8_t", ValueType::I8},        {"uchar", ValueType::U8},
    {"unsigned char", ValueType::U8}, {"uint8", ValueType::U8},
    {"uint8_t", ValueType::U8},       {"short", ValueType::I16},
    {"short int", ValueType::I16},    {"signed short", ValueType::I16},
    {"int16", ValueType::I16},        {"int16_t", ValueType::I16},
    {"ushort", ValueType::U16},       {"unsigned short", ValueType::U16},
    {"uint16", ValueType::U16},       {"uint16_t", ValueType::U16},
    {"int", ValueType::I32},          {"signed int", ValueType::I32},
    {"int32", ValueType::I32},        {"int32_t", ValueType::I32},
    {"uint", ValueType::U32},         {"unsigned int", ValueType::U32},
    {"uint32", ValueType::U32},       {"uint32_t", ValueType::U32},
    {"longlong", ValueType::I64},     {"long long", ValueType::I64},
    {"int64", ValueType::I64},        {"int64_t", ValueType::I64},
    {"ulonglong", ValueType::U64},    {"unsigned long long", ValueType::U64},
    {"uint64", ValueType::U64},       {"uint64_t", ValueType::U64},
    {"float", ValueType::F32},        {"double", ValueType::F64}};
constexpr TypeName kMetaTypes[] = {
    {"met_char", ValueType::I8},       {"met_uchar", ValueType::U8},
    {"met_short", ValueType::I16},     {"met_ushort", ValueType::U16},
    {"met_int", ValueType::I32},       {"met_uint", ValueType::U32},
    {"met_long_long", ValueType::I64}, {"met_ulong_long", ValueType::U64},
    {"met_float", ValueType::F32},     {"met_double", ValueType::F64}};

template <std::size_t Count>
ValueType typeOf(const Fields& fields, const std::string& field, const std::string& example,
                 const TypeName (&names)[Count]) {
  const std::string text = lower(fields.needed(field, example));
  for (const TypeName& name : names)
    if (text == name.name) return name.type;
  fields.refuse(field, "is `" + text.substr(0, 40) + "`; save the values as " + example);
}

Eigen::Vector3i sizesOf(const Fields& fields, const std::string& field) {
  fields.needed(field, "64 64 64");
  const std::vector<double> n = fields.numbers(field, 3);
  for (const double x : n)
    if (!(x >= 1 && x <= kMostValues && x == std::floor(x)))
      fields.refuse(field, "is `" + fields.text(field).substr(0, 40) +
                               "`; give the number of values along each axis");
  return {static_cast<int>(n[0]), static_cast<int>(n[1]), static_cast<int>(n[2])};
}

Eigen::Matrix3d matrixOf(const std::vector<double>& columns) {
  return Eigen::Map<const Eigen::Matrix3d>(columns.data());
}

// Meters per unit; 0 where the text names no length.
double metersPer(std::string unit) {
  unit = lower(unit);
  static const std::map<std::string, double> kUnits = {{"m", 1},
                                                       {"meter", 1},
                                                       {"cm", 1e-2},
                                                       {"centimeter", 1e-2},
                                                       {"mm", 1e-3},
                                                       {"millimeter", 1e-3},
                                                       {"um", 1e-6},
                                                       {"micron", 1e-6},
                                                       {"micrometer", 1e-6},
                                                       {"in", 0.0254},
                                                       {"inch", 0.0254}};
  const auto found = kUnits.find(unit);
  return found == kUnits.end() ? 0 : found->second;
}

// NRRD writes a unit for each axis, in quotes.
double nrrdUnit(const Fields& fields) {
  const std::string name = fields.has("space units") ? "space units" : "units";
  const std::string text = fields.text(name);
  std::optional<double> unit;
  for (std::size_t at = text.find('"'); at != std::string::npos;) {
    const std::size_t end = text.find('"', at + 1);
    if (end == std::string::npos) break;
    const double meters = metersPer(text.substr(at + 1, end - at - 1));
    if (unit && *unit != meters) fields.refuse(name, "differs by axis; give one unit");
    unit = meters;
    at = text.find('"', end + 1);
  }
  return unit.value_or(0);
}

void placeNrrd(const Fields& fields, VolumeHeader& out) {
  static const std::vector<std::string> kMirrored = {
      "left-anterior-superior", "las", "3d-left-handed", "right-posterior-superior", "rps"};
  const std::string space = lower(fields.text("space"));
  if (std::find(kMirrored.begin(), kMirrored.end(), space) != kMirrored.end())
    fields.refuse("space", "is `" + space +
                               "`, in which bodies are mirrored; save it in "
                               "left-posterior-superior");
  if (lower(fields.text("space directions")).find("none") != std::string::npos)
    fields.refuse("space directions", "has an axis without place; save one grey value a voxel");
  if (const auto directions = fields.numbers("space directions", 9); !directions.empty())
    out.axes = matrixOf(directions);
  else if (const auto spacings = fields.numbers("spacings", 3); !spacings.empty())
    out.axes = Vec3(spacings[0], spacings[1], spacings[2]).asDiagonal();
  else
    fields.needed("spacings", "1 1 1");
  if (const auto first = fields.numbers("space origin", 3); !first.empty())
    out.first = {first[0], first[1], first[2]};
  out.metersPerUnit = nrrdUnit(fields);
}

// Bytes, or lines, to skip before the values; -1: the values are the last bytes.
std::int64_t skipOf(const Fields& fields, const std::string& name) {
  const auto number = fields.numbers(name, 1);
  if (number.empty()) return 0;
  if (!(number[0] >= -1 && number[0] < 1e15 && number[0] == std::floor(number[0])))
    fields.refuse(name, "must be a whole number of -1 or more");
  return static_cast<std::int64_t>(number[0]);
}

// The file of the values, beside the header.
void findData(const Fields& fields, const fs::path& file, const std::string& field,
              VolumeHeader& out) {
  const std::string name = fields.text(field);
  if (lower(name).starts_with("list") || name.find('%') != std::string::npos)
    fields.refuse(field, "names several files; save the volume in one");
  out.data = file.parent_path() / name;
  std::error_code error;
  if (!fs::is_regular_file(out.data, error))
    fields.refuse(field, "names " + out.data.string() + ", which is no file; put it there");
}

bool isTrue(const Fields& fields, const std::string& name) {
  return lower(fields.text(name)) == "true";
}

}  // namespace

std::size_t bytesOf(ValueType type) {
  constexpr std::size_t kBytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kBytes[static_cast<std::size_t>(type)];
}

VolumeHeader readNrrdHeader(const fs::path& file) {
  const Fields fields(file, ':', "");
  if (!fields.magic().starts_with("NRRD000"))
    refuseFile(file, "is no NRRD: it does not begin with `NRRD000`; save it again");
  VolumeHeader out;
  if (fields.needed("dimension", "3") != "3")
    fields.refuse("dimension", "is not 3; save one grey value a voxel");
  out.type = typeOf(fields, "type", "short", kNrrdTypes);
  out.size = sizesOf(fields, "sizes");
  placeNrrd(fields, out);
  const std::string encoding = lower(fields.needed("encoding", "raw"));
  out.isZipped = encoding == "gzip" || encoding == "gz";
  if (!out.isZipped && encoding != "raw")
    fields.refuse("encoding", "is `" + encoding + "`; save it as raw or gzip");
  if (bytesOf(out.type) > 1) out.isBigEndian = lower(fields.needed("endian", "little")) == "big";
  if (skipOf(fields, "line skip") != 0 || skipOf(fields, "lineskip") != 0)
    fields.refuse("line skip", "is not read; use byte skip");
  out.skip = skipOf(fields, fields.has("byteskip") ? "byteskip" : "byte skip");
  if (out.isZipped && out.skip != 0)
    fields.refuse("byte skip", "counts within the compressed data; save it without");
  for (const char* name : {"data file", "datafile"})
    if (fields.has(name)) findData(fields, file, name, out);
  if (!out.data.empty()) return out;
  out.data = file;
  if (out.skip >= 0) out.skip += fields.end();
  return out;
}

VolumeHeader readMetaImageHeader(const fs::path& file) {
  const Fields fields(file, '=', "elementdatafile");
  VolumeHeader out;
  if (fields.needed("ndims", "3") != "3") fields.refuse("ndims", "is not 3; save a volume");
  if (fields.has("elementnumberofchannels") && fields.text("elementnumberofchannels") != "1")
    fields.refuse("elementnumberofchannels", "is not 1; save one grey value a voxel");
  if (fields.has("binarydata") && !isTrue(fields, "binarydata"))
    fields.refuse("binarydata", "is not True; save it in binary");
  out.type = typeOf(fields, "elementtype", "MET_SHORT", kMetaTypes);
  out.size = sizesOf(fields, "dimsize");
  auto spacing = fields.numbers("elementspacing", 3);
  if (spacing.empty()) spacing = fields.numbers("elementsize", 3);
  if (spacing.empty()) fields.needed("elementspacing", "1 1 1");
  out.axes = Vec3(spacing[0], spacing[1], spacing[2]).asDiagonal();
  for (const char* name : {"transformmatrix", "orientation", "rotation"})
    if (const auto turn = fields.numbers(name, 9); !turn.empty())
      out.axes = matrixOf(turn) * Vec3(spacing[0], spacing[1], spacing[2]).asDiagonal();
  for (const char* name : {"offset", "position", "origin"})
    if (const auto first = fields.numbers(name, 3); !first.empty())
      out.first = {first[0], first[1], first[2]};
  out.isBigEndian =
      isTrue(fields, "binarydatabyteordermsb") || isTrue(fields, "elementbyteordermsb");
  out.isZipped = isTrue(fields, "compresseddata");
  out.skip = skipOf(fields, "headersize");
  if (out.isZipped && out.skip < 0) fields.refuse("headersize", "is -1; state the bytes to skip");
  if (lower(fields.text("elementdatafile")) == "local") {
    out.data = file;
    if (out.skip >= 0) out.skip += fields.end();
  } else {
    findData(fields, file, "elementdatafile", out);
  }
  return out;
}

}  // namespace cloudcontact
