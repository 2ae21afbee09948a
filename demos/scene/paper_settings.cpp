// C and Gr of the command line.
#include "scene/paper_settings.h"

namespace cloudcontact::program {

PaperSettings paperSettings(const PaperOptions& options, double voxel,
                            const Eigen::Quaterniond& turn) {
  PaperSettings settings;
  if (options.window || options.representative) settings.window = sphereWindow(voxel);
  if (options.window) settings.window->area = {*options.window, {turn, Vec3::Zero()}};
  if (options.representative) settings.window->representative = turn * *options.representative;
  settings.membership = options.membership;
  settings.hardness = options.hardness;
  return settings;
}

}  // namespace cloudcontact::program
