// Reads a body's specification and turns the body into a cloud or a mesh.
#include "scene/body.h"

#include <cloudcontact/device/digitizer.h>
#include <cloudcontact/mesh/mesh_file.h>
#include <cloudcontact/mesh/mesh_repair.h>
#include <cloudcontact/objects/object_file.h>
#include <cloudcontact/objects/point_file.h>
#include <cloudcontact/voxels/volume_file.h>
#include <cloudcontact/workpiece/cloud_solid.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iostream>
#include <new>
#include <sstream>
#include <vector>

#include "io/errors.h"
#include "io/progress.h"
#include "io/solid_text.h"
#include "scene/primitive_mesh.h"
#include "scene/shape_cache.h"

namespace cloudcontact::program {

namespace {

// Facets of a primitive stay this close to its surface: below the digitizer's own error, 0.004
// voxels at best.
constexpr double kFacetTolerance = 0.002;  // [voxels]

constexpr const char* kNoMemory =
    "needs more memory than there is; give a larger --voxel, or fewer triangles or points";

std::string lowerExtension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

// A line on stderr, written whole when it goes: two bodies may be read at the same time.
class Notice {
 public:
  ~Notice() { std::cerr << "cloudcontact: " + text_.str() + '\n'; }
  template <class Value>
  Notice& operator<<(const Value& value) {
    text_ << value;
    return *this;
  }

 private:
  std::ostringstream text_;
};

// Turns the library's exceptions about a file into BadInput, lack of memory included. Appends
// `advice` to messages without any.
template <class Load>
auto asBadInput(const std::string& name, const std::string& advice, Load load) {
  try {
    return load();
  } catch (const std::bad_alloc&) {
    throw BadInput(name + ": " + kNoMemory);
  } catch (const BadInput&) {
    throw;
  } catch (const std::length_error& error) {
    const std::string message = error.what();
    const bool isNamed = message.starts_with(name);
    throw BadInput("--voxel: " + (isNamed ? message : name + ": " + message));
  } catch (const std::exception& error) {
    std::string message = error.what();
    if (message.find("bad_alloc") != std::string::npos)  // Assimp's message
      throw BadInput(name + ": " + kNoMemory);
    if (message.find(name) == std::string::npos) message = name + ": " + message;
    if (message.find(';') == std::string::npos) message += "; " + advice;
    throw BadInput(message);
  }
}

const char* const kMeshAdvice =
    "give an STL, OBJ, PLY or glTF file with triangles, or points as PLY, PCD or XYZ";

void refuseUnusable(const std::string& name) {
  namespace fs = std::filesystem;
  const fs::path file(name);
  std::error_code error;
  if (!fs::exists(file, error))
    throw BadInput(name +
                   ": no such file; give a mesh file, a point file, a volume, a .cloud file, "
                   "sphere:R, box:X,Y,Z, "
                   "cylinder:R,H, capsule:R,H, cone:R,H or halfspace");
  if (fs::is_directory(file, error)) throw BadInput(name + ": is a directory; give a file in it");
}

// The body's mesh, repaired; thickened where it is a sheet.
Mesh withInside(const Body& body, double voxel, const CommonOptions& options) {
  bool sheet = false;
  const Mesh whole = mended(*body.mesh, 0, &sheet);
  if (!sheet) return whole;
  const double thickness = options.shell.value_or(3 * voxel);
  Notice() << body.name << " has no inside; made a shell " << thickness
           << " m thick behind its faces (--shell)";
  return shell(whole, thickness);
}

void refuseCoarse(const Body& body, const Mesh& mesh, double voxel) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : mesh.vertices) box.extend(v);
  const double thinnest = box.isEmpty() ? 0 : box.sizes().minCoeff();
  if (voxel <= thinnest) return;
  if (thinnest == 0)
    throw BadInput(body.name +
                   ": is flat and no sheet either; repair it so that it encloses a "
                   "volume");
  std::ostringstream message;
  message << "--voxel: " << voxel << " m is larger than " << body.name << " is thick (" << thinnest
          << " m); give at most " << thinnest / 4 << ", or --unit if the file is not in meters";
  throw BadInput(message.str());
}

void readMesh(Body& body, const CommonOptions& options) {
  std::vector<NamedMesh> parts = asBadInput(
      body.name, kMeshAdvice, [&] { return loadMeshParts(body.name, options.metersPerUnit); });
  body.mesh = merged(parts);
  if (parts.size() > 1 && parts.size() <= kMostParts) body.parts = std::move(parts);
}

// Reads a point file: a depth image, a volume, or a surface.
DigitalObject readPoints(const std::string& name, const CommonOptions& options) {
  const PointFile file = asBadInput(name, "give points as PLY, PCD or XYZ, in rows of x y z",
                                    [&] { return loadPoints(name, options.metersPerUnit); });
  if (const auto* image = std::get_if<DepthImage>(&file)) return *image;
  PointCloud points = std::get<PointCloud>(file);
  recognizeVolume(points);
  return points;
}

Cloud scanned(const std::string& name, const PointCloud& points, double voxel,
              const CommonOptions& options) {
  ScanSettings settings;
  settings.voxelSize = voxel;
  settings.shell = options.shell.value_or(0);
  settings.threads = options.threads;
  ScanReport report;
  const Cloud cloud = toCloud(points, settings, &report);
  Notice notice;
  notice << name << " is " << points.positions.size() << " points of a surface, "
         << report.pointDistance << " m apart; ";
  if (report.closed)
    notice << "filled the volume that they enclose";
  else
    notice << "they enclose nothing: made a shell " << settings.shell << " m thick "
           << (points.normals.empty() ? "about" : "behind") << " them (--shell)";
  return cloud;
}

Cloud pictured(const std::string& name, const DepthImage& image, double voxel,
               const CommonOptions& options) {
  DepthCloudSettings settings;
  settings.voxelSize = voxel;
  settings.thickness = options.shell.value_or(3 * voxel);
  settings.image.threads = options.threads;
  DepthReport report;
  const Cloud cloud = toCloud(image, settings, &report);
  Notice() << name << " is a depth image of " << image.width << " x " << image.height << " pixels, "
           << report.seen << " seen, " << report.filled << " filled; made a shell "
           << settings.thickness << " m thick behind the seen surface (--shell)";
  return cloud;
}

CtVolume readVolume(const std::string& name, const CommonOptions& options) {
  VolumeFileSettings settings;
  settings.metersPerUnit = options.metersPerUnit;
  settings.voxelSize = options.voxel.value_or(0);
  return asBadInput(name, "give an NRRD or MetaImage file",
                    [&] { return loadVolume(name, settings); });
}

Cloud fromVolume(const std::string& name, const CtVolume& volume, double voxel,
                 const CommonOptions& options) {
  const auto [least, most] = std::minmax_element(volume.values.begin(), volume.values.end());
  std::ostringstream facts;
  facts << name << " is a volume of " << volume.size.transpose() << " values from " << *least
        << " to " << *most;
  if (options.thresholds.empty())
    throw BadInput("--threshold: " + facts.str() +
                   "; say from which value on it is material: --threshold T, or in a scene "
                   "<cloudcontact:threshold>T</cloudcontact:threshold>");
  const Vec3 edges = volume.size.cast<double>().cwiseProduct(volume.spacing);
  Notice() << facts.str() << ", " << edges.transpose() << " m along x y z (--unit)";
  return asBadInput(name, "give another --threshold",
                    [&] { return cloudFromCt(volume, options.thresholds, {voxel}); });
}

// The cloud of points and other objects; a message reports the kind of points.
Cloud cloudOf(const Body& body, double voxel, const CommonOptions& options) {
  if (const auto* image = std::get_if<DepthImage>(&*body.object))
    return pictured(body.name, *image, voxel, options);
  if (const auto* points = std::get_if<PointCloud>(&*body.object)) {
    if (!points->fillsVolume()) return scanned(body.name, *points, voxel, options);
    Notice() << body.name << " is " << points->positions.size()
             << " points that fill a volume; took each for a cube of " << points->spacing << " m";
  }
  return toCloud(*body.object, voxel);
}

// Digitizes on the backend of --backend.
DigitizedBody digitizeMesh(const Mesh& mesh, const DigitizeSettings& settings,
                           const CommonOptions& options) {
  if (options.backend == Backend::Cpu) {
    // A cloud of the cache has no report.
    if (options.cache)
      return {
          options.cache->cloud(mesh, settings.voxelSize, [&] { return digitize(mesh, settings); }),
          inspect(mesh).closed(), Backend::Cpu};
    DigitizeReport report;
    Cloud cloud = digitize(mesh, settings, &report);
    return {std::move(cloud), report.closed, Backend::Cpu};
  }
  Digitizer digitizer({options.backend});
  digitizer.run(mesh, settings);
  if (!digitizer.message().empty()) reportCpuFallback(digitizer.message());
  return {digitizer.cloud(), digitizer.report().closed,
          digitizer.deviceReport().onDevice ? Backend::OpenCl : Backend::Cpu};
}

}  // namespace

Body readBody(const std::string& specification, const CommonOptions& options) {
  Body body;
  body.name = specification;
  body.shape = readPrimitive(specification);
  if (body.shape) return body;
  refuseUnusable(specification);
  if (lowerExtension(specification) == ".cloud") {
    DigitalObject object = asBadInput(specification, "make it again with cloudcontact digitize",
                                      [&] { return loadObject(specification); });
    if (Cloud* cloud = std::get_if<Cloud>(&object))
      body.cloud = std::move(*cloud);
    else
      body.object = std::move(object);
  } else if (isVolumeFile(specification)) {
    body.volume = readVolume(specification, options);
  } else if (isPointFile(specification)) {
    body.object = readPoints(specification, options);
  } else {
    readMesh(body, options);
  }
  return body;
}

void checkThresholds(const CommonOptions& options, const std::vector<std::string>& specifications) {
  if (options.thresholds.empty() ||
      std::any_of(specifications.begin(), specifications.end(),
                  [](const std::string& text) { return isVolumeFile(text); }))
    return;
  throw BadInput("--threshold: is of CT volumes, and there is none; leave it out");
}

bool isHalfSpace(const Body& body) {
  return body.shape && std::holds_alternative<HalfSpace>(*body.shape);
}

Eigen::AlignedBox3d boundsOf(const Body& body) {
  if (body.shape) return boundsOf(*body.shape);
  if (body.object) return cloudcontact::boundsOf(*body.object);
  Eigen::AlignedBox3d box;
  if (body.volume) {
    const CtVolume& v = *body.volume;
    box.extend(v.origin);
    box.extend(Vec3(v.origin + v.size.cast<double>().cwiseProduct(v.spacing)));
  } else if (body.cloud) {
    box.extend(body.cloud->origin());
    const Vec3 size = body.cloud->size().cast<double>() * body.cloud->voxelSize();
    box.extend(Vec3(body.cloud->origin() + size));
  } else {
    for (const Vec3& v : body.mesh->vertices) box.extend(v);
  }
  return box;
}

double defaultVoxel(const Body& body) {
  if (body.object)
    return asBadInput(body.name, "give --voxel", [&] { return suggestedVoxel(*body.object); });
  if (body.volume) return body.volume->spacing.minCoeff();
  if (body.cloud) return body.cloud->voxelSize();
  if (body.mesh)
    return asBadInput(body.name, "give --voxel", [&] { return suggestedVoxel(*body.mesh); });
  return suggestedVoxel(boundsOf(body));
}

DigitizedBody digitizeBody(const Body& body, double voxel, const CommonOptions& options) {
  if (isHalfSpace(body))
    throw BadInput("halfspace: is infinite and has no voxels; give a box of the size you need");
  if (body.cloud) {
    const double own = body.cloud->voxelSize();
    if (options.voxel && std::abs(*options.voxel - own) > 1e-6 * own) {
      std::ostringstream message;
      message << "--voxel: " << body.name << " was saved with voxels of " << own
              << " m; leave --voxel out or digitize its mesh again";
      throw BadInput(message.str());
    }
    return {*body.cloud, true, Backend::Cpu};
  }
  if (body.volume) return {fromVolume(body.name, *body.volume, voxel, options)};
  if (body.object)
    return {asBadInput(body.name, "save it again", [&] { return cloudOf(body, voxel, options); }),
            true, Backend::Cpu};
  return asBadInput(body.name, "repair the mesh so that it encloses a volume", [&] {
    Mesh mesh;
    if (body.shape)
      mesh = primitiveMesh(*body.shape, kFacetTolerance * voxel);
    else
      mesh = withInside(body, voxel, options);
    refuseCoarse(body, mesh, voxel);
    DigitizeSettings settings;
    settings.voxelSize = voxel;
    settings.maxBytes = options.maxBytes;
    settings.threads = options.threads;
    settings.progress = options.progress("digitizing " + body.name);
    // A thickened sheet has lost its parts.
    if (body.parts.empty() || isSheet(*body.mesh))
      return askingUnit(mesh, voxel, options.metersPerUnit,
                        [&] { return digitizeMesh(mesh, settings, options); });
    if (options.backend == Backend::OpenCl) reportCpuFallback(body.name + " has several materials");
    if (options.cache)
      return DigitizedBody{
          options.cache->cloud(body.parts, voxel, [&] { return digitize(body.parts, settings); }),
          inspect(*body.mesh).closed(), Backend::Cpu};
    DigitizeReport report;
    Cloud cloud = digitize(body.parts, settings, &report);
    return DigitizedBody{std::move(cloud), report.closed, Backend::Cpu};
  });
}

std::string unitHint(const Mesh& mesh, double voxel) {
  constexpr double kMany = 2000, kFew = 4;  // voxels along a body
  constexpr double kMillimeter = 1e-3;
  Eigen::AlignedBox3d box;
  for (const Vec3& vertex : mesh.vertices) box.extend(vertex);
  const double length = box.isEmpty() ? 0 : box.sizes().maxCoeff();
  if (length / voxel < kMany || kMillimeter * length / voxel < kFew) return {};
  std::ostringstream hint;
  hint << "; it is " << length << " m long as it is read: did you mean --unit mm?";
  return hint.str();
}

PlacedSolid solidOf(const Body& body, double voxel, const CommonOptions& options) {
  if (body.shape && !isHalfSpace(body)) return {*body.shape};
  return cloudSolid(
      digitizeBody(body, body.cloud ? body.cloud->voxelSize() : voxel, options).cloud);
}

std::shared_ptr<const SurfaceField> buildField(const Cloud& cloud, const std::string& name,
                                               const CommonOptions& options) {
  FieldSettings settings;
  settings.threads = options.threads;
  settings.progress = options.progress("finding the surface of " + name);
  const auto build = [&] { return SurfaceField::build(cloud, settings); };
  return asBadInput(name, "give a smaller --voxel",
                    [&] { return options.cache ? options.cache->field(cloud, build) : build(); });
}

Mesh meshOf(const Body& body, double tolerance) {
  if (isHalfSpace(body)) throw BadInput("halfspace: has no mesh; give a box of the size you need");
  if (body.cloud)
    throw BadInput(body.name + ": a saved cloud has no mesh; use --method cloud or give the mesh");
  if (body.volume)
    throw BadInput(body.name + ": a volume has no mesh; use --method cloud or give the mesh");
  if (body.object)
    throw BadInput(body.name + ": " + kindName(*body.object) +
                   " have no mesh; use --method cloud or give the mesh");
  return body.mesh ? *body.mesh : primitiveMesh(*body.shape, tolerance);
}

}  // namespace cloudcontact::program
