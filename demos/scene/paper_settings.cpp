// C and Gr of the command line.
#include "scene/paper_settings.h"

namespace cloudcontact::program {

PaperSettings paperSettings(const PaperOptions& options, double voxel,
                            const Eigen::Quaterniond& turn) {
  WindowSettings window = sphereWindow(voxel);
  if (options.window) window.area = {*options.window, {turn, Vec3::Zero()}};
  if (options.representative) window.representative = turn * *options.representative;
  PaperSettings settings;
  settings.window = window;
  settings.hardness = options.hardness;
  return settings;
}

}  // namespace cloudcontact::program
