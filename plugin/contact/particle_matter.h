// What a particle touches of a cloud: tissues, (1) and (2), and base vectors, (5').
#pragma once

#include <cloudcontact/contact/paper_body.h>
#include <cloudcontact/law/law.h>
#include <cloudcontact/law/tissue.h>

#include <optional>
#include <vector>

namespace cloudcontact {

// The cloud's side of a pair with particles.
struct TouchedCloud {
  const TissueTable* tissues = nullptr;  // null: it has none
  std::optional<KelvinVoigt> spring;     // of a cloud without tissues; empty: rigid
  const PaperBody* paper = nullptr;      // null: nothing is stated
  std::vector<double> hardness;          // h of each of the paper's tissues, (5')
  bool byArea = false;                   // k and c are per area (Foundation)
};

struct ParticleTouch {
  std::optional<KelvinVoigt> spring;  // of the cloud alone
  Vec3 vector = Vec3::Zero();         // the digital normal, in the cloud's frame; zero: none
};

// D of a particle is a cube of a voxel's edge along the cloud's axes: its collision voxels B are
// those that the cube meets, by their share of it and their coverage. The particle is at `local`,
// and `depth` [m] below the surface whose outward normal is `normal`; one that is less than half a
// voxel deep touches as if it were.
ParticleTouch touchOf(const TouchedCloud& touched, const Cloud& cloud, const Vec3& local,
                      double depth, const Vec3& normal);

}  // namespace cloudcontact
