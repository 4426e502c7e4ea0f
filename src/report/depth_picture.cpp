#include "report/depth_picture.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::report {

void set_pixel(Picture& picture, int x, int y, const Eigen::Vector3d& colour) {
  if (x < 0 || y < 0 || x >= picture.width || y >= picture.height) return;
  for (int c = 0; c < 3; ++c)
    picture.rgb[static_cast<std::size_t>(3 * (y * picture.width + x) + c)] =
        static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(colour[c], 0.0, 1.0)));
}

std::vector<double> brightness_of(const DepthImage& image) {
  float nearest = 1e9F, farthest = 0.0F;
  for (const float z : image.z)
    if (z > 0 && std::isfinite(z)) nearest = std::min(nearest, z), farthest = std::max(farthest, z);
  std::vector<double> brightness(image.z.size(), 0.0);
  for (std::size_t i = 0; i < image.z.size(); ++i)
    if (const float z = image.z[i]; z > 0 && std::isfinite(z))
      brightness[i] = 0.85 - 0.5 * static_cast<double>((z - nearest) / std::max(1e-6F, farthest - nearest));
  return brightness;
}

}  // namespace stonestack::report
