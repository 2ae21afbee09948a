// Hardness, cutting ability and base vectors of a body.
#include <cloudcontact/contact/paper_body.h>

#include <algorithm>
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
  body.membership = settings.membership;
  body.hardness = settings.hardness;
  body.ability = settings.ability;
  body.parts = settings.parts;
  return body;
}

bool states(const PaperSettings& settings, const TissueTable& tissues) {
  const bool hard =
      settings.hardness && std::any_of(tissues.begin(), tissues.end(), [&](const Tissue& t) {
        return t.hardness != tissues.front().hardness;
      });
  return hard || settings.window || settings.area || settings.membership != Membership::Shared ||
         settings.ability != 1 || !settings.parts.empty();
}

double abilityAt(double outside, const std::vector<CuttingPart>& parts, const Vec3& point) {
  double ability = outside;
  for (const CuttingPart& part : parts)
    if (depthOf(part.area, point) >= 0) ability = part.ability;
  return ability;
}

void hardnessOf(const TissueTable& tissues, bool hardness, std::vector<double>& h) {
  h.assign(tissues.size(), 1.0);
  if (!hardness) return;
  const auto unit = std::find_if(tissues.begin(), tissues.end(),
                                 [](const Tissue& tissue) { return tissue.hardness > 0; });
  if (unit == tissues.end()) return;
  for (std::size_t t = 0; t < tissues.size(); ++t) h[t] = tissues[t].hardness / unit->hardness;
}

std::vector<double> hardnessOf(const TissueTable& tissues, bool hardness) {
  std::vector<double> h;
  hardnessOf(tissues, hardness, h);
  return h;
}

}  // namespace cloudcontact
