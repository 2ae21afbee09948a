// Fills tinygltf's model: one buffer, and a view for each accessor.
#include "replay/gltf.h"

#include <tiny_gltf.h>

#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <sstream>

#include "io/errors.h"
#include "io/text.h"
#include "replay/body_colors.h"
#include "replay/shaded_mesh.h"

namespace cloudcontact::program {
namespace {

constexpr double kPlaneSpan = 14;  // edge of a plane's square, in diagonals of the take
constexpr const char* kGenerator = "CloudContact";

std::vector<double> numbers(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

std::vector<double> numbers(const Eigen::Quaterniond& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}

// The visible part of an infinite plane.
Mesh planeMesh(const Vec3& normal, const Vec3& about, double span) {
  const Eigen::Quaterniond turn = shortestTurn(Vec3::UnitZ(), normal);
  const Vec3 middle = about - normal.dot(about) * normal;
  Mesh mesh;
  for (const auto& [x, y] : {std::pair(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
    mesh.vertices.push_back(middle + turn * Vec3(x * span / 2, y * span / 2, 0));
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

bool same(const Mesh& a, const Mesh& b) {
  return &a == &b || (a.vertices == b.vertices && a.triangles == b.triangles);
}

class Writer {
 public:
  explicit Writer(const Replay& replay) : replay_(replay) {
    model_.asset.version = "2.0";
    model_.asset.generator = kGenerator;
    model_.buffers.emplace_back();
  }

  std::string bytes() {
    tinygltf::Node root;
    root.name = printable(replay_.title);
    root.rotation =
        numbers(Eigen::Quaterniond(Eigen::AngleAxisd(-std::numbers::pi / 2, Vec3::UnitX())));
    tinygltf::Animation motion;
    motion.name = "simulation";
    for (const ReplayTake& take : replay_.takes) root.children.push_back(addTake(take, motion));
    if (!motion.channels.empty()) model_.animations.push_back(motion);
    model_.scenes.emplace_back();
    model_.scenes[0].name = printable(replay_.title);
    model_.scenes[0].nodes = {add(root)};
    model_.defaultScene = 0;
    std::ostringstream out;
    if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&model_, out, false, true))
      throw WorkFailed("--replay: tinygltf could not write the glTF");
    return out.str();
  }

 private:
  int add(const tinygltf::Node& node) {
    model_.nodes.push_back(node);
    return static_cast<int>(model_.nodes.size()) - 1;
  }

  int addTake(const ReplayTake& take, tinygltf::Animation& motion) {
    tinygltf::Node node;
    node.name = printable(take.label);
    node.translation = numbers(take.offset);
    const std::vector<BodyColor> colors = bodyColors(take.bodies);
    for (std::size_t i = 0; i < take.bodies.size(); ++i)
      node.children.push_back(addBody(take, i, materialOf(colors[i]), motion));
    return add(node);
  }

  int addBody(const ReplayTake& take, std::size_t index, int material,
              tinygltf::Animation& motion) {
    const ReplayBody& body = take.bodies[index];
    const Pose& start = body.keys.front().pose;
    tinygltf::Node node;
    node.name = printable(body.name);
    node.translation = numbers(start.position);
    node.rotation = numbers(start.orientation);
    for (std::size_t k = 0; k < body.drawn.parts.size(); ++k)
      node.children.push_back(addPart(take, body, k, material));
    if (!body.surface.empty()) node.children.push_back(addSurface(body, material, motion));
    const int at = add(node);
    if (body.keys.size() > 1) addMotion(body, at, motion);
    return at;
  }

  int addPart(const ReplayTake& take, const ReplayBody& body, std::size_t index, int material) {
    const DrawnPart& part = body.drawn.parts[index];
    tinygltf::Node node;
    node.name = printable(body.name) + (part.planeNormal ? " (plane)" : " (mesh)");
    node.translation = numbers(part.pose.position);
    node.rotation = numbers(part.pose.orientation);
    if (part.planeNormal) {
      const Pose at = body.keys.front().pose * part.pose;
      const Mesh plane = planeMesh(*part.planeNormal, at.toLocal(take.extent.center()),
                                   kPlaneSpan * take.extent.diagonal().norm());
      node.mesh = addMesh(geometryOf(plane), material, "plane");
    } else {
      node.mesh = meshOf(*part.mesh, material, body.name);
    }
    return add(node);
  }

  // A node for each piece of surface, of scale 1 while it is there and 0 otherwise.
  int addSurface(const ReplayBody& body, int material, tinygltf::Animation& motion) {
    tinygltf::Node all;
    all.name = printable(body.name) + " (matter)";
    all.translation = numbers(body.surfacePlace.position);
    all.rotation = numbers(body.surfacePlace.orientation);
    for (const SurfacePiece& piece : body.surface) {
      tinygltf::Node mesh, there;
      mesh.name = there.name = printable(body.name) + " (surface)";
      mesh.mesh = addMesh(geometryOf(piece.mesh), material, body.name);
      there.children = {add(mesh)};
      if (piece.from > 0) there.scale = numbers(Vec3(0, 0, 0));
      const int at = add(there);
      all.children.push_back(at);
      if (piece.from > 0 || std::isfinite(piece.to)) addPresence(piece, at, motion);
    }
    return add(all);
  }

  void addPresence(const SurfacePiece& piece, int node, tinygltf::Animation& motion) {
    std::vector<float> times;
    std::vector<Eigen::Vector3f> scales;
    const auto key = [&](double time, float scale) {
      times.push_back(static_cast<float>(time));
      scales.push_back(Eigen::Vector3f::Constant(scale));
    };
    if (piece.from > 0) key(0, 0);
    key(piece.from, 1);
    if (std::isfinite(piece.to)) key(piece.to, 0);
    const int input = timesOf(times);
    const int scale = accessor(scales.data(), scales.size(), scales.size() * sizeof scales[0],
                               TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT, 0);
    addChannel(motion, node, "scale", "STEP", input, scale);
  }

  // Stores equal meshes of several worlds once.
  int meshOf(const Mesh& mesh, int material, const std::string& name) {
    std::size_t which = 0;
    while (which < known_.size() && !same(*known_[which].mesh, mesh)) ++which;
    if (which == known_.size()) known_.push_back({&mesh, geometryOf(mesh)});
    const auto [at, isNew] = meshes_.try_emplace({which, material}, -1);
    if (isNew) at->second = addMesh(known_[which].geometry, material, name);
    return at->second;
  }

  struct Geometry {
    int positions, normals, corners;
  };

  Geometry geometryOf(const Mesh& mesh) { return geometryOf(shaded(mesh)); }
  Geometry geometryOf(const ShadedMesh& shade) {
    const auto floats = [&](const std::vector<Eigen::Vector3f>& v) {
      return accessor(v.data(), v.size(), v.size() * sizeof v[0], TINYGLTF_TYPE_VEC3,
                      TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TARGET_ARRAY_BUFFER);
    };
    Geometry g{floats(shade.positions), floats(shade.normals), -1};
    Eigen::AlignedBox3f box;
    for (const auto& p : shade.positions) box.extend(p);
    if (!box.isEmpty()) {
      model_.accessors[g.positions].minValues = numbers(Vec3(box.min().cast<double>()));
      model_.accessors[g.positions].maxValues = numbers(Vec3(box.max().cast<double>()));
    }
    g.corners =
        accessor(shade.corners.data(), shade.corners.size(),
                 shade.corners.size() * sizeof shade.corners[0], TINYGLTF_TYPE_SCALAR,
                 TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    return g;
  }

  int addMesh(const Geometry& geometry, int material, const std::string& name) {
    tinygltf::Primitive primitive;
    primitive.attributes = {{"POSITION", geometry.positions}, {"NORMAL", geometry.normals}};
    primitive.indices = geometry.corners;
    primitive.material = material;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    tinygltf::Mesh mesh;
    mesh.name = printable(name);
    mesh.primitives.push_back(primitive);
    model_.meshes.push_back(mesh);
    return static_cast<int>(model_.meshes.size()) - 1;
  }

  int materialOf(const BodyColor& color) {
    const auto known = materials_.find(color.name);
    if (known != materials_.end()) return known->second;
    tinygltf::Material material;
    material.name = color.name;
    material.pbrMetallicRoughness.baseColorFactor = {color.linear[0], color.linear[1],
                                                     color.linear[2], 1};
    material.pbrMetallicRoughness.metallicFactor = 0.1;
    material.pbrMetallicRoughness.roughnessFactor = 0.6;
    model_.materials.push_back(material);
    return materials_[color.name] = static_cast<int>(model_.materials.size()) - 1;
  }

  // Both channels of a body share its times.
  void addMotion(const ReplayBody& body, int node, tinygltf::Animation& motion) {
    std::vector<float> times;
    std::vector<Eigen::Vector3f> places;
    std::vector<Eigen::Vector4f> turns;
    for (const PoseKey& key : body.keys) {
      times.push_back(static_cast<float>(key.time));
      places.push_back(key.pose.position.cast<float>());
      turns.push_back(key.pose.orientation.coeffs().cast<float>());
    }
    const int input = timesOf(times);
    const int place = accessor(places.data(), places.size(), places.size() * sizeof places[0],
                               TINYGLTF_TYPE_VEC3, TINYGLTF_COMPONENT_TYPE_FLOAT, 0);
    const int turn = accessor(turns.data(), turns.size(), turns.size() * sizeof turns[0],
                              TINYGLTF_TYPE_VEC4, TINYGLTF_COMPONENT_TYPE_FLOAT, 0);
    addChannel(motion, node, "translation", "LINEAR", input, place);
    addChannel(motion, node, "rotation", "LINEAR", input, turn);
  }

  int timesOf(const std::vector<float>& times) {
    const int input = accessor(times.data(), times.size(), times.size() * sizeof times[0],
                               TINYGLTF_TYPE_SCALAR, TINYGLTF_COMPONENT_TYPE_FLOAT, 0);
    model_.accessors[input].minValues = {times.front()};
    model_.accessors[input].maxValues = {times.back()};
    return input;
  }

  static void addChannel(tinygltf::Animation& motion, int node, const char* path,
                         const char* interpolation, int input, int output) {
    tinygltf::AnimationSampler sampler;
    sampler.input = input;
    sampler.output = output;
    sampler.interpolation = interpolation;
    motion.samplers.push_back(sampler);
    tinygltf::AnimationChannel channel;
    channel.sampler = static_cast<int>(motion.samplers.size()) - 1;
    channel.target_node = node;
    channel.target_path = path;
    motion.channels.push_back(channel);
  }

  int accessor(const void* data, std::size_t count, std::size_t size, int type, int component,
               int target) {
    auto& blob = model_.buffers[0].data;
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = blob.size();
    view.byteLength = size;
    view.target = target;
    blob.resize(blob.size() + size);
    if (size > 0) std::memcpy(blob.data() + view.byteOffset, data, size);
    model_.bufferViews.push_back(view);
    tinygltf::Accessor accessor;
    accessor.bufferView = static_cast<int>(model_.bufferViews.size()) - 1;
    accessor.componentType = component;
    accessor.count = count;
    accessor.type = type;
    model_.accessors.push_back(accessor);
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  const Replay& replay_;
  tinygltf::Model model_;
  struct Known {
    const Mesh* mesh;
    Geometry geometry;
  };
  std::vector<Known> known_;
  std::map<std::pair<std::size_t, int>, int> meshes_;  // by known_ and material
  std::map<std::string, int> materials_;
};

}  // namespace

std::string gltfBytes(const Replay& replay) {
  return Writer(replay).bytes();
}

}  // namespace cloudcontact::program
