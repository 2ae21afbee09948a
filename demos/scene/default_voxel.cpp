// The voxel of a scene that states none (scene_clouds.h).
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "scene/scene_clouds.h"

namespace cloudcontact::program {

namespace {

double defaultVoxel(const SceneGeometry& geometry, const std::string& body,
                    const CommonOptions& options) {
  const auto* named = std::get_if<SceneMesh>(&geometry);
  if (!named) return suggestedVoxel(boundsOf(analytic(geometry)));
  Body read;
  if (named->mesh)
    read.mesh = *named->mesh;
  else if (named->cloud)
    read.cloud = *named->cloud;
  else
    read = naming(body, [&] { return readBody(named->file.string(), options); });
  if (read.mesh) read.mesh = read.mesh->scaled(named->scale);
  read.name = body;
  return defaultVoxel(read);
}

}  // namespace

double defaultVoxel(const SceneDescription& scene, const CommonOptions& options) {
  double least = std::numeric_limits<double>::infinity();
  std::set<std::string> known;  // geometries, of which a scene may have many that are equal
  for (const auto& body : scene.bodies)
    for (const auto& collision : body.collisions) {
      if (body.isStatic || isPlane(collision.geometry)) continue;
      if (!known.insert(keyOf(collision.geometry)).second) continue;
      least = std::min(least, defaultVoxel(collision.geometry, body.name, options));
    }
  if (!std::isfinite(least))
    throw BadInput("--voxel: no moving body has a size to take it from; give one");
  return least;
}

}  // namespace cloudcontact::program
