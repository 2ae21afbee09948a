// MuJoCo 2.2 (Debian's libmujoco-dev 2.2.2).
//
// A model of two geoms with an explicit pair, margin and gap 0. B is a mocap body, whose pose can
// be set directly. Timed are setting the pose, mj_kinematics and mj_collision. MuJoCo replaces a
// mesh by its convex hull ("hull" in the settings), which fills holes. Hulls use libccd's MPR at
// MuJoCo's default tolerance, which returns one point, or up to four more with the flag multiccd,
// meant for flat contacts. Primitives are MuJoCo's sphere, box, capsule, cylinder and plane. Box
// against box reports half the depth in this version (fixed upstream in 2025, pull request 822 of
// google-deepmind/mujoco_warp), and often an extra point at a far corner; the chart shows it
// unchanged.
#include <mujoco/mujoco.h>

#include <cstdio>
#include <memory>
#include <sstream>
#include <utility>

#include "lab/peer_pairs.h"

namespace cloudcontact::program::lab {

namespace {

constexpr int kMaxContacts = 100;  // a pair has at most 50 (mjMAXCONPAIR)

// XML of a geom and of its mesh.
struct GeomText {
  std::string geom, asset;
};

struct PrimitiveText {
  std::string operator()(const HalfSpace& s) const {
    const Vec3 p = s.offset * s.normal;
    return "type='plane' size='1 1 1' pos='" + list(p) + "' zaxis='" + list(s.normal) + "'";
  }
  std::string operator()(const Sphere& s) const {
    return "type='sphere' size='" + number(s.radius) + "'";
  }
  std::string operator()(const Box& s) const {
    return "type='box' size='" + list(s.halfExtents) + "'";
  }
  std::string operator()(const Capsule& s) const {
    return "type='capsule' size='" + number(s.radius) + " " + number(s.halfHeight) + "'";
  }
  std::string operator()(const Cylinder& s) const {
    return "type='cylinder' size='" + number(s.radius) + " " + number(s.halfHeight) + "'";
  }
  std::string operator()(const Cone&) const { throw CannotDo("MuJoCo has no cone"); }
  std::string operator()(const Hull&) const {
    throw CannotDo("MuJoCo takes a hull as a mesh, another setting");
  }
  template <class Other>
  std::string operator()(const Other&) const {
    throw CannotDo("the laboratory has no such body");
  }

  static std::string number(double value) {
    std::ostringstream text;
    text.precision(17);
    text << value;
    return text.str();
  }
  static std::string list(const Vec3& v) {
    return number(v.x()) + " " + number(v.y()) + " " + number(v.z());
  }
};

GeomText primitiveText(const std::string&, const LabBody& body, double) {
  return {std::visit(PrimitiveText{}, primitiveOf(body)), {}};
}

// Only vertices: MuJoCo builds the hull's faces.
GeomText hullText(const std::string& name, const LabBody& body, double tolerance) {
  if (isHalfSpace(body)) return primitiveText(name, body, tolerance);
  std::string vertices;
  for (const Vec3& v : body.mesh(tolerance).vertices) vertices += PrimitiveText::list(v) + " ";
  return {"type='mesh' mesh='" + name + "'",
          "<mesh name='" + name + "' vertex='" + vertices + "'/>\n"};
}

std::string modelText(const GeomText& a, const GeomText& b, bool manyPoints) {
  return "<mujoco><option collision='predefined'><flag multiccd='" +
         std::string(manyPoints ? "enable" : "disable") + "'/></option>\n<size nconmax='" +
         std::to_string(kMaxContacts) + "'/>\n<asset>\n" + a.asset + b.asset +
         "</asset>\n<worldbody><geom name='a' " + a.geom +
         "/>\n<body name='b' mocap='true'><geom name='b' " + b.geom +
         "/></body></worldbody>\n<contact><pair geom1='a' geom2='b'/></contact></mujoco>\n";
}

// MuJoCo reads the model from its virtual file system, which is too large for the stack.
std::shared_ptr<mjModel> modelOf(const std::string& text) {
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "pair.xml", int(text.size()));
  text.copy(static_cast<char*>(files->filedata[0]), text.size());
  char error[500] = "";
  mjModel* model = mj_loadXML("pair.xml", files.get(), error, sizeof error);
  mj_deleteVFS(files.get());
  if (model == nullptr) throw CannotDo(std::string("MuJoCo: ") + error);
  return {model, mj_deleteModel};
}

class MujocoPair {
 public:
  explicit MujocoPair(const std::string& text)
      : model_(modelOf(text)),
        data_(mj_makeData(model_.get()), mj_deleteData),
        a_(mj_name2id(model_.get(), mjOBJ_GEOM, "a")) {}

  void collide(const Pose& b) const {
    const Eigen::Quaterniond& q = b.orientation;
    const mjtNum quaternion[4] = {q.w(), q.x(), q.y(), q.z()};
    mju_copy3(data_->mocap_pos, b.position.data());
    mju_copy4(data_->mocap_quat, quaternion);
    mj_kinematics(model_.get(), data_.get());
    mj_collision(model_.get(), data_.get());
  }

  std::vector<LabPoint> find(const Pose& b) const {
    collide(b);
    std::vector<LabPoint> points;
    for (int k = 0; k < data_->ncon; ++k) {
      const mjContact& c = data_->contact[k];
      const double sign = c.geom1 == a_ ? 1 : -1;  // MuJoCo orders geoms by type
      points.push_back({Vec3(c.pos[0], c.pos[1], c.pos[2]),
                        sign * Vec3(c.frame[0], c.frame[1], c.frame[2]), -c.dist, 0});
    }
    return points;
  }

 private:
  std::shared_ptr<mjModel> model_;
  std::shared_ptr<mjData> data_;
  int a_;
};

using TextMaker = GeomText (*)(const std::string& name, const LabBody& body, double tolerance);

LabMethod mujocoMethod(const std::string& setting, double detail, TextMaker text, bool manyPoints) {
  const auto prepare = [text, manyPoints](const LabBody& a, const LabBody& b, double tolerance) {
    const MujocoPair pair(modelText(text("a", a, tolerance), text("b", b, tolerance), manyPoints));
    return pairOf([pair](const Pose& pose) { return pair.find(pose); },
                  [pair](const Pose& pose) { pair.collide(pose); });
  };
  const std::string what = detail > 0 ? "convex hull of " + facetsWithin(detail) +
                                            " through libccd's MPR at MuJoCo's default tolerance"
                                      : "MuJoCo's sphere, box, capsule, cylinder and plane";
  return {"mujoco",
          setting,
          detail,
          prepare,
          what + ", margin and gap 0, multiccd " + (manyPoints ? "on" : "off") +
              "; timed with mj_kinematics of the two bodies",
          detail > 0};
}

}  // namespace

std::vector<LabMethod> mujocoMethods() {
  const std::string facets = "facets " + fraction(kCoarseFacets);
  return {mujocoMethod("primitives", 0, primitiveText, true),
          mujocoMethod("hull, " + facets, kCoarseFacets, hullText, false),
          mujocoMethod("hull, multiccd, " + facets, kCoarseFacets, hullText, true)};
}

Version mujocoVersion() {
  return {"MuJoCo", mj_versionString()};
}

}  // namespace cloudcontact::program::lab
