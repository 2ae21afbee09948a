// The table of our elements, and the readers of their values.
#include "scene/scene_elements.h"

#include <cloudcontact/voxels/volume_file.h>

#include <algorithm>
#include <span>
#include <vector>

#include "io/errors.h"
#include "io/options.h"
#include "io/solid_text.h"
#include "io/text.h"
#include "scene/scene_text.h"

namespace cloudcontact::program {
namespace {

const std::string kPrefix = "cloudcontact:";

struct OwnElement {
  std::string name, place;
  std::vector<std::string> attributes, parts;
};

const OwnElement kOwnElements[] = {
    {"tissue", "collision", {"part", "from"}, {}},
    {"threshold", "collision", {}, {}},
    {"cutter", "collision", {"ability", "hardness", "efficiency", "edge_speed"}, {}},
    {"cuttable", "collision", {}, {}},
    {"soft", "collision", {"spacing", "held"}, {}},
    {"window", "collision", {}, {}},
    {"representative", "collision", {}, {}},
    {"area", "collision", {}, {}},
    {"tolerance", "collision", {}, {}},
    {"drive", "link", {}, {"linear", "angular"}},
};

bool isOneOf(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string listOf(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? "none" : list;
}

std::string tag(const std::string& name) {
  return "<" + printable(name) + ">";
}

void checkOwn(const std::string& file, const sdf::ElementPtr& element, const std::string& place) {
  const std::string name = element->GetName().substr(kPrefix.size());
  const std::string where = file + ": " + tag(element->GetName());
  std::vector<std::string> names;
  for (const OwnElement& own : kOwnElements) names.push_back(own.name);
  const auto own = std::find_if(std::begin(kOwnElements), std::end(kOwnElements),
                                [&](const OwnElement& e) { return e.name == name; });
  if (own == std::end(kOwnElements))
    throw BadInput(where + ": is not known; after " + kPrefix + " use one of " + listOf(names));
  if (own->place != place)
    throw BadInput(where + ": stands in a <" + printable(place) + ">; move it into a <" +
                   own->place + ">");
  for (std::size_t i = 0; i < element->GetAttributeCount(); ++i) {
    const std::string key = element->GetAttribute(static_cast<unsigned>(i))->GetKey();
    if (!isOneOf(own->attributes, key))
      throw BadInput(where + ": attribute " + printable(key) +
                     " is not known; it has: " + listOf(own->attributes));
  }
  for (auto part = element->GetFirstElement(); part; part = part->GetNextElement())
    if (!isOneOf(own->parts, part->GetName()))
      throw BadInput(where + ": " + tag(part->GetName()) +
                     " in it is not known; it has: " + listOf(own->parts));
}

// The only element of a name, or null.
sdf::ElementPtr single(const std::string& where, const sdf::ElementPtr& in,
                       const std::string& name) {
  if (!in->HasElement(name)) return nullptr;
  const auto found = in->GetElement(name);
  if (found->GetNextElement(name))
    throw BadInput(where + " " + tag(name) + ": is there twice; leave one out");
  return found;
}

std::string textOf(const sdf::ElementPtr& element) {
  const auto value = element->GetValue();
  const std::string text = value ? value->GetAsString() : "";
  const auto first = text.find_first_not_of(" \t\r\n"), last = text.find_last_not_of(" \t\r\n");
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

// An attribute that is a number of 0 or more.
double attribute(const std::string& where, const sdf::ElementPtr& element, const std::string& name,
                 double missing) {
  if (!element->HasAttribute(name)) return missing;
  return readNotNegative(where + " attribute " + name, element->GetAttribute(name)->GetAsString());
}

// The geometry of a collision that must be a volume.
SceneMesh& volumeOf(const std::string& at, SceneCollision& collision) {
  auto* mesh = std::get_if<SceneMesh>(&collision.geometry);
  if (!mesh || !isVolumeFile(mesh->file))
    throw BadInput(at +
                   ": grey values are those of a volume (.nrrd, .nhdr, .mha, .mhd); leave it "
                   "out, or name such a file in <uri>");
  return *mesh;
}

SceneCutter cutterOf(const std::string& where, const sdf::ElementPtr& element) {
  SceneCutter out;
  out.ability = attribute(where, element, "ability", out.ability);
  out.cutter.hardness = attribute(where, element, "hardness", out.cutter.hardness);
  out.cutter.efficiency = attribute(where, element, "efficiency", out.cutter.efficiency);
  out.cutter.edgeSpeed = attribute(where, element, "edge_speed", out.cutter.edgeSpeed);
  if (out.cutter.efficiency > 1)
    throw BadInput(where + " attribute efficiency: is above 1; give the share that comes off");
  return out;
}

// The grey values of a volume, in which the part has the tissue's name.
void readRange(const std::string& at, const sdf::ElementPtr& element, SceneTissue& tissue,
               SceneCollision& out) {
  if (!tissue.part.empty())
    throw BadInput(at + ": has part and from; leave one out, a volume has no parts but its ranges");
  tissue.part = tissue.name;
  const double from =
      readNumber(at + " attribute from", element->GetAttribute("from")->GetAsString());
  addThreshold(at + " attribute from", {from, tissue.name}, volumeOf(at, out).thresholds);
}

// All tissues of a volume have ranges or none has. A single one is that of the whole body.
void checkRanges(const std::string& at, SceneCollision& out) {
  const auto* mesh = std::get_if<SceneMesh>(&out.geometry);
  const std::size_t ranges = mesh ? mesh->thresholds.size() : 0;
  if (ranges == 0) return;
  if (ranges != out.tissues.size())
    throw BadInput(at + ": some say from which grey value on they are, some do not; add from");
  if (ranges == 1) out.tissues[0].part.clear();
}

SceneSoft softOf(const std::string& where, const sdf::ElementPtr& element) {
  SceneSoft out;
  const std::string spacing = where + " attribute spacing";
  if (!element->HasAttribute("spacing"))
    throw BadInput(spacing + ": is missing; give the way between nodes [m], some voxels");
  out.spacing = readPositive(spacing, element->GetAttribute("spacing")->GetAsString());
  if (element->HasAttribute("held"))
    out.held = sidesOf(where + " attribute held", element->GetAttribute("held")->GetAsString());
  return out;
}

void readTissues(const std::string& where, const sdf::ElementPtr& collision, SceneCollision& out) {
  const std::string name = kPrefix + "tissue", at = where + " " + tag(name);
  if (!collision->HasElement(name)) return;
  for (auto e = collision->GetElement(name); e; e = e->GetNextElement(name)) {
    SceneTissue tissue;
    if (e->HasAttribute("part")) tissue.part = e->GetAttribute("part")->GetAsString();
    tissue.name = textOf(e);
    if (tissue.name.empty()) throw BadInput(at + ": is empty; give the name of a tissue");
    if (e->HasAttribute("from")) readRange(at, e, tissue, out);
    for (const SceneTissue& other : out.tissues)
      if (other.part == tissue.part)
        throw BadInput(at + ": " + (tissue.part.empty() ? "all parts" : printable(tissue.part)) +
                       " has a tissue already; leave one out");
    out.tissues.push_back(tissue);
  }
  checkRanges(at, out);
}

void readThreshold(const std::string& where, const sdf::ElementPtr& collision,
                   SceneCollision& out) {
  const std::string name = kPrefix + "threshold", at = where + " " + tag(name);
  const auto element = single(where, collision, name);
  if (!element) return;
  SceneMesh& volume = volumeOf(at, out);
  if (!volume.thresholds.empty())
    throw BadInput(at + ": its tissues say from which values on they are; leave one out");
  volume.thresholds = {{readNumber(at, textOf(element)), ""}};
}

}  // namespace

void checkOwnElements(const std::string& file, const sdf::ElementPtr& root) {
  for (auto child = root->GetFirstElement(); child; child = child->GetNextElement()) {
    if (child->GetName().starts_with(kPrefix))
      checkOwn(file, child, root->GetName());
    else
      checkOwnElements(file, child);
  }
}

void readOwnElements(const std::string& where, const sdf::ElementPtr& collision,
                     SceneCollision& out) {
  readTissues(where, collision, out);
  readThreshold(where, collision, out);
  const auto find = [&](const char* name) { return single(where, collision, kPrefix + name); };
  const auto at = [&](const char* name) { return where + " " + tag(kPrefix + name); };
  if (const auto cutter = find("cutter")) out.cutter = cutterOf(at("cutter"), cutter);
  out.isCuttable = find("cuttable") != nullptr;
  if (const auto soft = find("soft")) out.soft = softOf(at("soft"), soft);
  if (out.soft && (out.cutter || out.isCuttable))
    throw BadInput(at("soft") + ": soft tissue neither cuts nor wears; leave the other out");
  if (out.cutter && out.isCuttable)
    throw BadInput(at("cutter") + ": a collision that cuts cannot be cut; leave one out");
  if (const auto window = find("window"))
    out.paper.window = readWindow(at("window"), textOf(window));
  if (const auto gr = find("representative"))
    out.paper.representative = readVector(at("representative"), textOf(gr));
  if (const auto tolerance = find("tolerance"))
    out.tolerance = readNotNegative(at("tolerance"), textOf(tolerance));
  if (const auto area = find("area")) out.paper.area = readWindow(at("area"), textOf(area));
}

std::optional<SceneDrive> readDrive(const std::string& where, const sdf::ElementPtr& link,
                                    const Pose& linkInBody) {
  const std::string name = kPrefix + "drive", at = where + " " + tag(name);
  const auto element = single(where, link, name);
  if (!element) return {};
  SceneDrive drive;
  drive.place = linkInBody;
  const auto linear = single(at, element, "linear"), angular = single(at, element, "angular");
  if (!linear && !angular)
    throw BadInput(at + ": has no velocity; give <linear> [m/s], <angular> [rad/s] or both");
  if (linear) drive.linear = readVector(at + " <linear>", textOf(linear));
  if (angular) drive.angular = readVector(at + " <angular>", textOf(angular));
  return drive;
}

}  // namespace cloudcontact::program
