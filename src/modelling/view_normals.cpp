#include "modelling/view_normals.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "detection/scene/seen_normal.hpp"

namespace stonestack::modelling {

std::vector<Eigen::Vector3f> view_normals(const DepthImage& smooth) {
  std::vector<Eigen::Vector3f> normals(smooth.z.size(), Eigen::Vector3f::Zero());
  tbb::parallel_for(0, smooth.camera.height, [&](int v) {
    for (int u = 0; u < smooth.camera.width; ++u) {
      const auto i = static_cast<std::size_t>(v * smooth.camera.width + u);
      if (smooth.z[i] > 0) normals[i] = detection::seen_normal(smooth, u, v).cast<float>();
    }
  });
  return normals;
}

std::vector<float> seen_to(const DepthImage& image) {
  std::vector<float> least(image.z.size(), 0.0F);
  const int width = image.camera.width;
  for (int v = 1; v + 1 < image.camera.height; ++v)
    for (int u = 1; u + 1 < width; ++u) {
      float depth = image.at(u, v);
      for (int dv = -1; dv <= 1; ++dv)
        for (int du = -1; du <= 1; ++du) depth = std::min(depth, image.at(u + du, v + dv));
      least[static_cast<std::size_t>(v * width + u)] = depth;
    }
  return least;
}

}  // namespace stonestack::modelling
