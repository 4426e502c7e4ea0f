#include "modelling/view_normals.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "detection/scene/preprocess.hpp"
#include "detection/scene/seen_normal.hpp"

namespace stonestack::modelling {
namespace {

constexpr int kSmoothingReach = 2;  // px to each side

/// Part of an image: columns and rows, the first and the one after the last.
struct ImagePart {
  Eigen::Array2i first = Eigen::Array2i::Zero(), end = Eigen::Array2i::Zero();

  [[nodiscard]] ImagePart grown(int by, const CameraIntrinsics& camera) const {
    const Eigen::Array2i size(camera.width, camera.height);
    return {(first - by).max(0), (end + by).min(size)};
  }
};

ImagePart box_of(const std::vector<char>& shows, const CameraIntrinsics& camera) {
  Eigen::Array2i least(camera.width, camera.height), most(-1, -1);
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u)
      if (shows[static_cast<std::size_t>(v * camera.width + u)] != 0) {
        least = least.min(Eigen::Array2i(u, v));
        most = most.max(Eigen::Array2i(u, v));
      }
  return most.x() < 0 ? ImagePart{} : ImagePart{least, most + 1};
}

/// The image, smoothed in the box but for the two pixels inside its border, which need others.
DepthImage smooth_in(const ImagePart& box, const DepthImage& raw, const DetectionOptions& options) {
  const Eigen::Array2i size = box.end - box.first;
  DepthImage part;
  part.camera = raw.camera;
  part.camera.width = size.x();
  part.camera.height = size.y();
  const auto at = [&](int row) {
    return static_cast<std::ptrdiff_t>(row + box.first.y()) * raw.camera.width + box.first.x();
  };
  for (int row = 0; row < size.y(); ++row)
    part.z.insert(part.z.end(), raw.z.begin() + at(row), raw.z.begin() + at(row) + size.x());
  part = detection::smooth_depth(part, options);
  DepthImage out{raw.camera, std::vector<float>(raw.z.size(), 0.0F)};
  for (int row = 0; row < size.y(); ++row)
    std::copy_n(part.z.begin() + static_cast<std::ptrdiff_t>(row) * size.x(), size.x(),
                out.z.begin() + at(row));
  return out;
}

std::vector<Eigen::Vector3f> normals_in(const ImagePart& box, const DepthImage& smooth) {
  std::vector<Eigen::Vector3f> normals(smooth.z.size(), Eigen::Vector3f::Zero());
  tbb::parallel_for(box.first.y(), box.end.y(), [&](int v) {
    for (int u = box.first.x(); u < box.end.x(); ++u) {
      const auto i = static_cast<std::size_t>(v * smooth.camera.width + u);
      if (smooth.z[i] > 0) normals[i] = detection::seen_normal(smooth, u, v).cast<float>();
    }
  });
  return normals;
}

}  // namespace

std::vector<Eigen::Vector3f> view_normals(const DepthImage& smooth) {
  return normals_in({{0, 0}, {smooth.camera.width, smooth.camera.height}}, smooth);
}

std::vector<Eigen::Vector3f> normals_where(const std::vector<char>& shows, const DepthImage& raw,
                                           const DetectionOptions& options) {
  const ImagePart box = box_of(shows, raw.camera);
  const int reach = detection::normal_span(raw.camera, 0.0) + kSmoothingReach;
  return normals_in(box, smooth_in(box.grown(reach, raw.camera), raw, options));
}

std::vector<float> seen_to(const DepthImage& image) {
  std::vector<float> least(image.z.size(), 0.0F);
  const int width = image.camera.width;
  tbb::parallel_for(1, std::max(1, image.camera.height - 1), [&](int v) {
    for (int u = 1; u + 1 < width; ++u) {
      float depth = image.at(u, v);
      for (int dv = -1; dv <= 1; ++dv)
        for (int du = -1; du <= 1; ++du) depth = std::min(depth, image.at(u + du, v + dv));
      least[static_cast<std::size_t>(v * width + u)] = depth;
    }
  });
  return least;
}

}  // namespace stonestack::modelling
