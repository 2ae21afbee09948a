// `--picture` of contact and digitize: complete PNG and SVG files that show the results, or none.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <string>
#include <vector>

#include "draw/drawing.h"
#include "draw/svg.h"
#include "io/text.h"
#include "program/obj_file.h"
#include "program/program_run.h"
#include "scene/generated_mesh.h"

namespace prog_picture_test {
namespace {

using cloudcontact::program::Drawing;
using cloudcontact::program::Point;
using program_test::Outcome;
using program_test::Workplace;
using Arguments = std::vector<std::string>;

// Small bodies for speed, off the grid for partly covered voxels.
const Arguments kSphereOnPlane = {"contact",  "halfspace", "sphere:0.0101", "--voxel",   "0.001",
                                  "--repeat", "1",         "--pose",        "0 0 0.0095"};
const Arguments kCorner = {"contact",
                           "box:0.0203,0.0203,0.0083",
                           "box:0.0083,0.0083,0.0083",
                           "--voxel",
                           "0.0005",
                           "--repeat",
                           "1",
                           "--pose",
                           "0 0 0.0102 0.3 0.2 0.1 0.93"};
const Arguments kCylinder = {"digitize", "cylinder:0.0043,0.0061", "--voxel", "0.0005"};

Arguments drawn(Arguments arguments, const std::string& file) {
  arguments.insert(arguments.end(), {"--picture", file});
  return arguments;
}

std::string pictureOf(const Arguments& arguments, const std::string& file) {
  const Workplace place;
  const Outcome outcome = place.run(drawn(arguments, file));
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_NE(outcome.out, "") << "the command still prints its result";
  EXPECT_EQ(place.files(), std::set<std::string>{file});
  return place.read(file);
}

// The tags of an XML text. Fails if they do not nest.
std::vector<std::string> openedTags(const std::string& xml) {
  std::vector<std::string> open, all;
  for (std::size_t k = xml.find('<'); k != std::string::npos; k = xml.find('<', k + 1)) {
    const std::size_t end = xml.find('>', k);
    if (end == std::string::npos) {
      ADD_FAILURE() << "a tag without an end";
      break;
    }
    const std::string tag = xml.substr(k + 1, end - k - 1);
    const std::string name = tag.substr(0, tag.find(' '));
    EXPECT_EQ(std::count(tag.begin(), tag.end(), '"') % 2, 0) << tag;
    if (tag[0] == '/') {
      EXPECT_TRUE(!open.empty() && open.back() == tag.substr(1)) << tag;
      if (!open.empty()) open.pop_back();
      continue;
    }
    all.push_back(tag);
    if (tag.back() != '/') open.push_back(name);
  }
  EXPECT_TRUE(open.empty()) << open.size() << " tags stay open";
  return all;
}

// A block of three layers as an OBJ file, one object each, all inside the first.
void writeBlock(const Workplace& place) {
  struct Layer {
    const char* name;
    double x, low, high;  // half width, bottom and top [m]
  };
  std::string text;
  int base = 1;
  for (const Layer& layer : {Layer{"enamel", 0.003, -0.002, 0},
                             {"dentin & co", 0.0029, -0.0019, -0.0004},
                             {"pulp", 0.0012, -0.0018, -0.0009}}) {
    text += "o " + std::string(layer.name) + "\n";
    for (int k = 0; k < 8; ++k)
      text += "v " + std::to_string(k & 4 ? layer.x : -layer.x) + " " +
              std::to_string(k & 2 ? layer.x : -layer.x) + " " +
              std::to_string(k & 1 ? layer.high : layer.low) + "\n";
    for (const char* face :
         {"013", "032", "467", "475", "045", "051", "237", "276", "026", "064", "157", "173"}) {
      text += "f";
      for (int k = 0; k < 3; ++k) text.append(" ").append(std::to_string(base + face[k] - '0'));
      text += "\n";
    }
    base += 8;
  }
  place.write("block.obj", text);
}

// The content of a group by name, up to the first end of a group.
std::string group(const std::string& svg, const std::string& name) {
  const std::size_t start = svg.find("<g id=\"" + name + "\"");
  EXPECT_NE(start, std::string::npos) << "no group " << name;
  if (start == std::string::npos) return {};
  const std::size_t inside = svg.find('>', start) + 1;
  return svg.substr(inside, svg.find("</g>", inside) - inside);
}

std::size_t count(const std::string& text, const std::string& piece) {
  std::size_t found = 0;
  for (std::size_t k = text.find(piece); k != std::string::npos; k = text.find(piece, k + 1))
    ++found;
  return found;
}

// The corners of the first path in an SVG text.
std::vector<Point> firstPath(const std::string& svg) {
  const std::size_t start = svg.find(" d=\"") + 4;
  std::string data = svg.substr(start, svg.find('"', start) - start);
  data = data.substr(1, data.find('z') - 1);
  std::vector<Point> points;
  Point at = Point::Zero();
  for (std::size_t k = 0; k < data.size();) {
    double step[2];
    for (double& s : step) {
      std::size_t read = 0;
      s = std::stod(data.substr(k), &read);
      k += read;
    }
    at += Point(step[0], step[1]);
    points.push_back(at);
    ++k;  // skips the 'l' of the next corner
  }
  return points;
}

TEST(Picture, OfAContactHasEveryPartOfTheMethod) {
  const std::string svg = pictureOf(kCorner, "corner.svg");
  EXPECT_EQ(openedTags(svg).front().rfind("svg xmlns=", 0), 0U);
  for (const char* name :
       {"body-a", "body-b", "surfaces", "collision-voxels", "fitted-normals", "contact-normal",
        "contact-points", "scale-bar", "key", "figures", "overview", "patch"})
    EXPECT_NE(group(svg, name), "") << name;
  EXPECT_GE(count(group(svg, "fitted-normals"), "<path"), 10U);
  EXPECT_GE(count(group(svg, "contact-points"), "<circle"), 1U);
  EXPECT_EQ(count(group(svg, "patch"), "<circle"), 4U);
  for (const char* words :
       {"contact normal", "force on B", "voxel", "mm</text>", "Surface normals"})
    EXPECT_NE(svg.find(words), std::string::npos) << words;
  EXPECT_LT(svg.size(), 200000U);
}

// The half-space pushes the sphere straight up, so the big arrow points up.
TEST(Picture, TheNormalPointsWhereTheForceDoes) {
  for (const auto& [method, name] :
       {std::pair("cloud", "contact-normal"), {"paper", "digital-normal"}}) {
    Arguments arguments = kSphereOnPlane;
    arguments.insert(arguments.end(), {"--method", method});
    if (std::string(method) == "paper")
      arguments.insert(arguments.end(), {"--window", "sphere:0.0025"});
    const std::vector<Point> arrow = firstPath(group(pictureOf(arguments, "sphere.svg"), name));
    ASSERT_EQ(arrow.size(), 7U);
    const Point tip = arrow[3], tail = (arrow[0] + arrow[6]) / 2;
    EXPECT_NEAR(tip.x(), tail.x(), 1);
    EXPECT_LT(tip.y(), tail.y() - 100);
  }
}

// The base vectors of the sphere's collision voxels, and of no other: all lie near its foot and
// point out of it, down.
TEST(Picture, ByThePaperShowsBaseVectors) {
  Arguments arguments = kSphereOnPlane;
  arguments.insert(arguments.end(), {"--method", "paper", "--window", "sphere:0.0025"});
  const std::string svg = pictureOf(arguments, "paper.svg");
  openedTags(svg);
  for (const char* words : {"Base vectors", "Digital normal", "detection area D"})
    EXPECT_NE(svg.find(words), std::string::npos) << words;
  for (const char* words : {"itted normal", "ontact normal"})
    EXPECT_EQ(svg.find(words), std::string::npos) << words;
  const std::string vectors = group(svg, "base-vectors");
  const std::size_t drawn = count(vectors, "<path");
  EXPECT_GE(drawn, 2U);
  EXPECT_LE(drawn, 16U) << "a cap 0.6 voxel deep is 7 voxels wide, in two layers";
  const std::vector<Point> arrow = firstPath(vectors);
  EXPECT_GT(arrow[3].y(), arrow[0].y());
}

TEST(Picture, OfBodiesApartSaysSo) {
  Arguments apart = kSphereOnPlane;
  apart.back() = "0 0 0.02";
  const std::string svg = pictureOf(apart, "apart.svg");
  openedTags(svg);
  EXPECT_NE(svg.find("do not touch"), std::string::npos);
  EXPECT_EQ(svg.find("contact-normal"), std::string::npos);
}

TEST(Picture, OfACloudHasSlicesAndAView) {
  const std::string svg = pictureOf(kCylinder, "cylinder.svg");
  openedTags(svg);
  for (const char* name :
       {"slice-x", "slice-y", "slice-z", "outside", "close-look", "colors", "key", "figures"})
    EXPECT_NE(group(svg, name), "") << name;
  // A cylinder's top has one color, its side many.
  EXPECT_GE(count(group(svg, "outside"), "<path"), 4U);
  EXPECT_GE(count(group(svg, "close-look"), "<path"), 10U);
}

TEST(Picture, PngIsWholeAndOfItsSize) {
  for (const Arguments& arguments : {kCorner, kCylinder}) {
    const std::string png = pictureOf(arguments, "made.png");
    const auto number = [&](std::size_t at) {
      std::uint32_t value = 0;
      for (std::size_t k = 0; k < 4; ++k)
        value = value << 8 | static_cast<unsigned char>(png.at(at + k));
      return value;
    };
    ASSERT_GT(png.size(), 10000U);
    EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
    EXPECT_EQ(png.substr(12, 4), "IHDR");
    EXPECT_EQ(number(16), 2400U);  // 1200 px, twice as fine
    EXPECT_GT(number(20), 1400U);
    EXPECT_EQ(png.substr(png.size() - 8, 4), "IEND");
  }
}

TEST(Picture, TheSameInputGivesTheSameBytes) {
  for (const char* file : {"same.svg", "same.png"})
    for (const Arguments& arguments : {kCorner, kCylinder}) {
      Arguments threaded = arguments;
      threaded.insert(threaded.end(), {"--threads", "2"});
      EXPECT_TRUE(pictureOf(arguments, file) == pictureOf(arguments, file)) << file;
      EXPECT_TRUE(pictureOf(arguments, file) == pictureOf(threaded, file)) << file << ", threads";
    }
}

TEST(Picture, AnyNameOfAFileIsGoodXml) {
  const Workplace place;
  place.write("a<b>&\"\xff.obj",
              "v 0 0 0\nv 0.01 0 0\nv 0 0.01 0\nv 0 0 0.01\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const Outcome outcome = place.run({"digitize", "a<b>&\"\xff.obj", "--picture", "a.svg"});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  openedTags(place.read("a.svg"));
  EXPECT_NE(place.read("a.svg").find("a&lt;b&gt;&amp;&quot;?.obj"), std::string::npos);
}

void expectRefused(const Workplace& place, const Arguments& arguments,
                   const std::vector<std::string>& words, int exitCode = 2) {
  const auto before = place.files();
  const Outcome outcome = place.run(arguments);
  SCOPED_TRACE(arguments.back() + ": " + outcome.err);
  EXPECT_EQ(outcome.exitCode, exitCode);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
  EXPECT_NE(outcome.err.find(';'), std::string::npos) << "says what to do";
  for (const std::string& word : words)
    EXPECT_NE(outcome.err.find(word), std::string::npos) << word;
  EXPECT_EQ(place.files(), before);
}

TEST(Picture, UnwritableFilesAreRefusedByName) {
  const Workplace place;
  std::filesystem::create_directory(place / "folder.png");
  for (const Arguments& arguments : {kSphereOnPlane, kCylinder}) {
    for (const char* file : {"a.jpg", "a", "a.svg.txt"})
      expectRefused(place, drawn(arguments, file), {"--picture", ".png", ".svg"});
    expectRefused(place, drawn(arguments, ""), {"--picture", "empty"});
    expectRefused(place, drawn(arguments, "nowhere/a.png"),
                  {"--picture", "nowhere/a.png", "folder"});
    expectRefused(place, drawn(arguments, "folder.png"), {"--picture", "folder.png", "directory"});
    // Not even root can create files there.
    expectRefused(place, drawn(arguments, "/proc/a.svg"), {"--picture", "/proc/a.svg"});
  }
  Arguments other = kSphereOnPlane;
  other.insert(other.end(), {"--method", "gjk"});
  expectRefused(place, drawn(other, "a.png"), {"--picture", "--method cloud"});
}

// A limit on the size of files simulates a full disk: writing fails half-way.
TEST(Picture, AFullDiskLeavesTheOldPictureAndNothingElse) {
  const Workplace place;
  place.write("old.svg", "the old picture");
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit little{4096, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &little);
  for (const Arguments& arguments : {kSphereOnPlane, kCylinder})
    for (const char* file : {"old.svg", "new.png"})
      expectRefused(place, drawn(arguments, file), {"--picture", file, "space"}, 1);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(place.read("old.svg"), "the old picture");
}

// An M16 nut whose thread hangs on the bolt's by its flanks.
TEST(Picture, ANutNamesItsMostLoadedPatch) {
  using namespace cloudcontact::program;
  const Workplace place;
  const Thread bolt;
  Thread nut;
  nut.clearance = 0.1e-3;
  place.write("bolt.obj", program_test::objText({{"bolt", boltMesh(bolt, 32e-3, 24e-3, 10e-3)}}));
  place.write("nut.obj", program_test::objText({{"nut", nutMesh(nut, 13e-3, 24e-3)}}));
  const Outcome outcome =
      place.run({"contact", "bolt.obj", "nut.obj", "--voxel", "0.0005", "--pose", "0 0 0.0078",
                 "--repeat", "1", "--picture", "nut.svg"});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  const std::string svg = place.read("nut.svg");
  openedTags(svg);
  EXPECT_NE(svg.find("the most loaded of its"), std::string::npos);
  EXPECT_NE(svg.find("nut.obj (B)"), std::string::npos);
}

TEST(Svg, CoordinatesAreShortAndDoNotAddUpTheirRounding) {
  Drawing drawing{100, 50.25, "t", {}};
  cloudcontact::program::Polygons line;
  line.closed = false;
  line.paint.stroke = cloudcontact::program::Color{255, 0, 16, 0.5};
  line.rings = {{{0.04, -0.04}, {0.08, -0.5}, {-10.26, 3}}};
  drawing.add(line);
  const std::string svg = svgText(drawing);
  EXPECT_NE(svg.find("d=\"M0 0l.1-.5l-10.4 3.5\""), std::string::npos) << svg;
  EXPECT_NE(svg.find("stroke=\"#ff0010\" stroke-width=\"1.00\" stroke-opacity=\"0.50\""),
            std::string::npos)
      << svg;
  EXPECT_NE(svg.find("width=\"100\" height=\"50.3\""), std::string::npos) << svg;
}

TEST(Svg, TextIsMadePrintable) {
  using cloudcontact::program::printable;
  EXPECT_EQ(printable("plain \u00b5m"), "plain \u00b5m");
  EXPECT_EQ(printable("a\nb\x7f"), "a?b?");
  EXPECT_EQ(printable("\xc3"), "?");            // cut short
  EXPECT_EQ(printable("\xc0\xaf"), "??");       // overlong
  EXPECT_EQ(printable("\xed\xa0\x80"), "???");  // half a surrogate pair
  EXPECT_EQ(printable("\xf0\x9f\x98\x80"), "\xf0\x9f\x98\x80");
}

// A bur in a layered block: every layer in the cut has its color and name.
TEST(ContactPicture, NamesTheLayersOfABlock) {
  const Workplace place;
  writeBlock(place);
  const Outcome outcome =
      place.run({"contact", "block.obj", "sphere:0.0008", "--voxel", "0.0001", "--repeat", "1",
                 "--pose", "0.0002 0.0001 0.00068", "--picture", "a.svg"});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  const std::string svg = place.read("a.svg");
  openedTags(svg);
  EXPECT_NE(svg.find("A, enamel"), std::string::npos);
  EXPECT_NE(svg.find("A, dentin"), std::string::npos);
  EXPECT_EQ(svg.find("B, "), std::string::npos);
}

TEST(DigitizePicture, NamesTheMaterials) {
  const Workplace place;
  writeBlock(place);
  const Outcome outcome =
      place.run({"digitize", "block.obj", "--voxel", "0.0001", "--picture", "a.svg", "--json"});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_EQ(outcome.json()["materials"].size(), 3u);
  const std::string svg = place.read("a.svg");
  openedTags(svg);
  EXPECT_NE(svg.find("enamel, dentin"), std::string::npos);
}

}  // namespace

}  // namespace prog_picture_test
