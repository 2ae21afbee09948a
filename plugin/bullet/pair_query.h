// PairQuery: a pair's input for ContactFinder, read from Bullet's wrappers.
#pragma once

#include <cloudcontact/contact/contact.h>
#include <cloudcontact/contact/paper_body.h>

#include <optional>

#include "bullet/pair_law.h"
#include "bullet/pair_levels.h"
#include "bullet/shape_conversion.h"
#include "bullet/shape_triangles.h"
#include "contact/first_touch.h"

namespace cloudcontact {

class CloudShape;

struct PairQuery {
  ContactBody a, b;
  ContactSettings settings;
  PairLaw law;
  double step = 0;                              // [s] 0: no step asks, but a query of Bullet's
  LevelChoice levels;                           // of the fields
  double voxel = 0;                             // the smaller of the bodies' finest [m]
  Vec3 pull[2] = {Vec3::Zero(), Vec3::Zero()};  // on the bodies by forces that wait [m/s^2]
  double mass = 0;                              // [kg] 1 / (1/mA + 1/mB); 0 if neither moves
  // Number of changes of the shapes so far, since a new one may reuse the address of an old one.
  int conversions = 0;
  // The recognised shapes of clouds; null for others. `byShapes`: the pair is answered by shapes.
  const PlacedSolid* recognized[2] = {nullptr, nullptr};
  bool byShapes = false;
  double shapeError = 0;                 // of both [m]
  std::shared_ptr<const void> lives[2];  // CloudShape::life()
  const char* wrong = nullptr;           // why there is no query; then the rest is unset
  bool apart = false;                    // no triangle is near the cloud: the rest is unset, too
};

// A body of the query as a shape; for a query that is answered by shapes.
ContactBody asShape(const ContactBody& body, const PlacedSolid* recognized);

// A wrapper's cloud; null for another shape.
const CloudShape* cloudOf(const btCollisionObjectWrapper& wrap);

// Whether two queries differ at most in the bodies' poses and motions, and the margin.
bool sameMatter(const PairQuery& x, const PairQuery& y);

// Of one step: whether nothing has moved a body from one query to the other.
bool sameQuery(const PairQuery& x, const PairQuery& y);

// Reads the queries of one pair; caches converted shapes.
class PairReader {
 public:
  explicit PairReader(std::mutex& reading) : reading_(reading) {}  // see ShapeTriangles

  // `steps`: Bullet steps, so bodies about to touch get points too. Without them a body that has
  // lifted off by a micrometer falls freely for a step, and rattles for ever. `gap` [m]: of bodies
  // that a query still asks for. `touch`: the bodies are read where they touch later; may
  // be null. Throws as
  // lawOf().
  PairQuery read(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
                 const btCollisionObjectWrapper& b, double step, bool steps, double gap = 0,
                 const Touch* touch = nullptr);
  // Chooses the levels of a query again. One that is answered by shapes has those of the first such
  // query, as shapes use none; choose them before its fields are searched after all.
  void chooseLevels(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
                    const btCollisionObjectWrapper& b, PairQuery& query) const;
  PairLevels& levels() { return levels_; }
  // What it remembers of the last step, for files (base/byte_archive.h).
  template <typename Archive>
  void keepIn(Archive& archive) {
    levels_.keepIn(archive);
    if constexpr (Archive::kReads) shapesLevels_.reset();
  }

 private:
  bool setBodies(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
                 const btCollisionObjectWrapper& b, double gap, const Touch* touch,
                 PairQuery& query);
  void setLevels(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
                 const btCollisionObjectWrapper& b, PairQuery& query);
  void readShapes(const CloudContactSettings& settings, const btCollisionObjectWrapper& a,
                  const btCollisionObjectWrapper& b, PairQuery& query);
  void readPaper(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
                 PairQuery& query);

  ConversionCache converted_[2];
  ShapeTriangles triangles_[2];
  PairLevels levels_;
  struct KeptLevels {
    LevelChoice choice;
    std::shared_ptr<const void> lives[2];
  };
  std::optional<KeptLevels> shapesLevels_;  // while the pair is answered by shapes
  std::mutex& reading_;
  std::shared_ptr<const PaperBody> paper_[2];
};

}  // namespace cloudcontact
