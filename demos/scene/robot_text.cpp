// Stand-ins for masses that a URDF robot leaves out (robot_text.h). libsdformat melts the links of
// fixed joints into one, with their masses; so one mass is enough for such a group.
#include "scene/robot_text.h"

#include <boost/property_tree/xml_parser.hpp>
#include <map>
#include <sstream>
#include <stdexcept>

namespace cloudcontact::program {
namespace {

using Tree = boost::property_tree::ptree;

struct Group {
  bool hasMass = false, hasCollision = false, isJointed = false;
};

std::string named(const Tree& element, const char* path) {
  return element.get(std::string(path), std::string());
}

// The joints whose links are not melted: `<gazebo reference="JOINT">` may say so.
std::set<std::string> keptJoints(const Tree& robot) {
  std::set<std::string> kept;
  for (const auto& [kind, element] : robot)
    for (const char* word : {"preserveFixedJoint", "disableFixedJointLumping"})
      if (kind == "gazebo" && named(element, word).find_first_of("1t") != std::string::npos)
        kept.insert(named(element, "<xmlattr>.reference"));
  return kept;
}

// The links and joints of a robot as groups of links that become one.
class Groups {
 public:
  explicit Groups(const Tree& robot) {
    const std::set<std::string> kept = keptJoints(robot);
    for (const auto& [kind, joint] : robot) {
      if (kind != "joint") continue;
      const std::string parent = named(joint, "parent.<xmlattr>.link"),
                        child = named(joint, "child.<xmlattr>.link");
      if (named(joint, "<xmlattr>.type") == "fixed" && parent != "world" &&
          !kept.contains(named(joint, "<xmlattr>.name")))
        holders_[child] = parent;
      else
        jointed_.insert({parent, child});
    }
    for (const auto& [kind, link] : robot) {
      if (kind != "link") continue;
      const std::string name = named(link, "<xmlattr>.name");
      Group& group = groups_[rootOf(name)];
      group.hasMass |= link.get("inertial.mass.<xmlattr>.value", 0.0) != 0;
      group.hasCollision |= link.count("collision") > 0;
      group.isJointed |= jointed_.contains(name);
    }
  }
  const std::map<std::string, Group>& all() const { return groups_; }

 private:
  std::string rootOf(std::string link) const {
    for (std::size_t n = 0; n < holders_.size(); ++n) {  // a ring of joints has no root
      const auto holder = holders_.find(link);
      if (holder == holders_.end()) break;
      link = holder->second;
    }
    return link;
  }

  std::map<std::string, std::string> holders_;  // by a fixed joint
  std::set<std::string> jointed_;
  std::map<std::string, Group> groups_;  // by their roots
};

std::set<std::string> missing(const Tree& robot) {
  std::set<std::string> links;
  const Groups groups(robot);
  for (const auto& [root, group] : groups.all()) {
    if (group.hasMass || root == "world") continue;
    if (group.hasCollision)
      links.insert(root);
    else if (group.isJointed)
      throw std::invalid_argument("link '" + root +
                                  "': has neither <inertial> nor <collision>, but a joint; add an "
                                  "<inertial>");
  }
  return links;
}

Tree standIn() {
  Tree inertial;
  inertial.put("mass.<xmlattr>.value", 1);
  for (const char* axis : {"ixx", "iyy", "izz"})
    inertial.put(std::string("inertia.<xmlattr>.") + axis, 1);
  for (const char* axes : {"ixy", "ixz", "iyz"})
    inertial.put(std::string("inertia.<xmlattr>.") + axes, 0);
  return inertial;
}

}  // namespace

RobotText withMasses(const std::string& text) {
  Tree tree;
  try {
    std::istringstream in(text);
    boost::property_tree::read_xml(in, tree);
  } catch (const boost::property_tree::xml_parser_error&) {
    return {text, {}};  // libsdformat says what is wrong with it
  }
  const auto robot = tree.get_child_optional("robot");
  if (!robot) return {text, {}};
  const std::set<std::string> links = missing(*robot);
  if (links.empty()) return {text, {}};
  for (auto& [kind, link] : *robot) {
    if (kind != "link" || !links.contains(named(link, "<xmlattr>.name"))) continue;
    link.erase("inertial");
    link.add_child("inertial", standIn());
  }
  std::ostringstream out;
  boost::property_tree::write_xml(out, tree);
  return {out.str(), links};
}

}  // namespace cloudcontact::program
