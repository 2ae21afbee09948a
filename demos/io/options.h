// Options shared by several commands, and strict readers of their values.
#pragma once

#include <cloudcontact/base/pose.h>
#include <cloudcontact/contact/paper_body.h>
#include <cloudcontact/device/contact_batch.h>
#include <cloudcontact/law/law.h>
#include <cloudcontact/law/solid.h>
#include <cloudcontact/law/tissue.h>
#include <cloudcontact/voxels/ct_volume.h>
#include <cloudcontact/voxels/digitize_settings.h>

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/progress.h"

namespace cloudcontact::program {

class ShapeCache;  // scene/shape_cache.h

// Cloud; Paper: the same with what PaperOptions state; the others are Bullet's own.
enum class Method { Cloud, Paper, Gjk, Gimpact, Hacd, Primitive, Sdf };
bool usesClouds(Method method);

std::string_view nameOf(Method method);
std::string_view nameOf(Backend backend);

// What only --method paper takes, and all that it states (PaperSettings).
struct PaperOptions {
  std::optional<Solid> window;         // C; empty: the usual one
  std::optional<Vec3> representative;  // Gr from the center of C [m]
  bool hardness = false;
  Membership membership = Membership::Shared;
  std::string areaA, areaB;  // D of A and of B, bodies as typed; empty: the whole body
};

// Tissues of the bodies' parts.
struct TissueOptions {
  std::string table;                                         // dental or FILE.json; empty: none
  TissueTable made = {};                                     // the table, where it is no file's
  std::vector<std::pair<std::string, std::string>> ofParts;  // part and tissue
  bool hasTable() const { return !table.empty() || !made.empty(); }
  bool given() const { return hasTable() || !ofParts.empty(); }
};

// Values of the common options. An empty optional was not given; the command picks a default.
struct CommonOptions {
  std::optional<double> voxel;      // [m]
  double metersPerUnit = 1;         // of files that state no unit: --unit
  std::vector<CtRange> thresholds;  // of volumes, ascending: --threshold
  std::size_t maxBytes = DigitizeSettings{}.maxBytes;
  std::optional<double> shell;  // thickness of a sheet [m]; default three voxels
  // --law: paper|foundation|rigid (without k and c) or maxwell:K,C or solid:K,K1,C1
  Law law = KelvinVoigt{};
  std::optional<double> stiffness;  // the pair's k: [N/m], [N/m^3] with foundation
  std::optional<double> damping;    // the pair's c: [N s/m], [N s/m^3] with foundation
  std::optional<double> friction;   // the pair's coefficient
  std::optional<int> samples;       // ContactSettings::samples
  std::optional<double> reuse;      // CloudContactSettings::reuseMotion [voxels]
  Method method = Method::Cloud;
  PaperOptions paper;
  TissueOptions tissues;
  Backend backend = Backend::Cpu;
  double tolerance = 0;  // Fidelity::tolerance [m]
  bool exact = false;    // Fidelity::exact
  double budget = 0;     // Fidelity::budget [s per step]
  int threads = 0;       // 0: all cores
  bool json = false;
  bool explain = false;                    // CloudContactSettings::keepReports
  ProgressMaker progress = progressBar;    // of work that takes long
  std::shared_ptr<ShapeCache> cache = {};  // of clouds and fields; null: none
};

// Whether --law names a law with its own values and a memory.
bool isViscoelastic(const Law& law);

// Says on stderr why the CPU replaces --backend opencl.
void reportCpuFallback(const std::string& why);

// Throws BadInput for options that exclude each other, or that the method does not use.
void checkTogether(const CommonOptions& options);

// Readers. They throw BadInput with a message that starts with the option's name.
Law readLaw(const std::string& text);  // of --law
Method readMethod(const std::string& text);
Backend readBackend(const std::string& text);
double readUnit(const std::string& text);                             // meters per unit, of --unit
double readNumber(std::string_view option, const std::string& text);  // finite
double readPositive(std::string_view option, const std::string& text);  // finite, > 0
double readNotNegative(std::string_view option, const std::string& text);
int readCount(std::string_view option, const std::string& text, int least, int most);
// "x y z" or "x y z qx qy qz qw"; the quaternion is normalized.
Pose readPose(std::string_view option, const std::string& text);
// "x y z"
Vec3 readVector(std::string_view option, const std::string& text);
// "PART=TISSUE"
std::pair<std::string, std::string> readTissueName(const std::string& option,
                                                   const std::string& text);
// "T" or "NAME=T": the grey value from which on there is material, or that of the name.
CtRange readThreshold(const std::string& option, const std::string& text);
// Adds a threshold in its place. Throws BadInput where two are of one value or name, or where one
// of several has no name.
void addThreshold(const std::string& option, CtRange threshold, std::vector<CtRange>& to);
// "vx vy vz wx wy wz"
Motion readVelocity(std::string_view option, const std::string& text);

}  // namespace cloudcontact::program
