// The files that a scene's URIs mean (scene_paths.h).
#include "scene/scene_paths.h"

namespace cloudcontact::program {

std::string pathOf(const std::string& uri, const std::filesystem::path& folder) {
  if (uri.starts_with("file://")) return uri.substr(7);
  const bool isPackage = uri.starts_with("package://"), isModel = uri.starts_with("model://");
  if (!isPackage && !isModel) return uri;
  const std::filesystem::path rest = uri.substr(isPackage ? 10 : 8);
  const std::filesystem::path inside = rest.lexically_relative(*rest.begin());
  std::error_code ignored;
  for (auto at = std::filesystem::absolute(folder).lexically_normal();; at = at.parent_path()) {
    if (std::filesystem::is_regular_file(at / rest, ignored)) return (at / rest).string();
    if (at.filename() == *rest.begin() && std::filesystem::is_regular_file(at / inside, ignored))
      return (at / inside).string();
    if (at == at.parent_path()) return uri;
  }
}

}  // namespace cloudcontact::program
