// Hardness, cutting ability and base vectors of a body.
#include <cloudcontact/contact/paper_body.h>

#include <cmath>
#include <stdexcept>

namespace cloudcontact {

namespace {

// Of a body that states none: all of it is alike, and its k and c are not used.
const Tissue kOneTissue{"", 1, 0, 0, 1};

void validate(const PaperSettings& settings) {
  const auto positive = [](double ability, const char* field) {
    if (!(ability > 0) || !std::isfinite(ability))
      throw std::invalid_argument(std::string("PaperSettings: ") + field +
                                  " must be positive and finite");
  };
  positive(settings.ability, "ability");
  if (settings.area) validate(*settings.area);
  for (const CuttingPart& part : settings.parts) {
    validate(part.area);
    positive(part.ability, "the ability of a part");
  }
}

}  // namespace

PaperBody paperBody(const Cloud& cloud, const TissueTable& tissues, const PaperSettings& settings) {
  validate(settings);
  const WindowSettings window = settings.window.value_or(sphereWindow(cloud.voxelSize()));
  PaperBody body;
  body.vectors = std::make_shared<BaseVectorField>(
      cloud, tissues.empty() ? TissueTable{kOneTissue} : tissues, window);
  body.area = settings.area;
  body.hardness = settings.hardness;
  body.ability = settings.ability;
  body.parts = settings.parts;
  return body;
}

double abilityAt(const PaperBody& body, const Vec3& point) {
  double ability = body.ability;
  for (const CuttingPart& part : body.parts)
    if (depthOf(part.area, point) >= 0) ability = part.ability;
  return ability;
}

std::vector<double> hardnessOf(const TissueTable& tissues, bool hardness) {
  std::vector<double> h(tissues.size(), 1.0);
  if (!hardness) return h;
  const double one = tissues[0].hardness > 0 ? tissues[0].hardness : 1;
  for (std::size_t t = 0; t < tissues.size(); ++t)
    if (tissues[t].hardness > 0) h[t] = tissues[t].hardness / one;
  return h;
}

}  // namespace cloudcontact
