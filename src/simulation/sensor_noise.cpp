#include "simulation/sensor_noise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stonestack/core/error.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kHalfPi = 1.5707963267948966;
constexpr double kShadowTolerance = 0.010;  // m: a surface this much behind the lit one is in the dark

using PixelField = std::vector<float>;  // one value a pixel

std::size_t pixel(const CameraIntrinsics& camera, int u, int v) {
  return static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(u);
}

// Cosine between the surface normal and the ray back to the camera; 0 where nothing is seen.
PixelField cosines(const RenderedView& view, const Pose& T_W_C) {
  const auto& camera = view.depth.camera;
  const Eigen::Matrix3d R_C_W = T_W_C.rotation().transpose();
  PixelField cosine(view.depth.z.size(), 0.0F);
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const auto i = pixel(camera, u, v);
      if (view.depth.z[i] <= 0) continue;
      const Eigen::Vector3d n_C = R_C_W * view.normal_W[i].cast<double>();
      cosine[i] = static_cast<float>(std::abs(n_C.dot(deproject(camera, u, v).normalized())));
    }
  return cosine;
}

// Removes what the projector (or the second eye) at +x does not see: of all pixels of a row that fall on one
// of its columns, the nearest is lit.
void cast_shadow(DepthImage& image, double baseline) {
  const auto& camera = image.camera;
  const double shift = camera.fx * baseline;  // px m
  std::vector<float> lit;
  for (int v = 0; v < camera.height; ++v) {
    lit.assign(static_cast<std::size_t>(camera.width) + 1, std::numeric_limits<float>::infinity());
    const auto column = [&](int u) { return static_cast<int>(std::floor(u - shift / image.at(u, v))); };
    const auto inside = [&](int c) { return c >= 0 && c < camera.width; };
    for (int u = 0; u < camera.width; ++u) {
      const float z = image.at(u, v);
      if (z <= 0) continue;
      for (int c = column(u); c <= column(u) + 1; ++c)
        if (inside(c)) lit[static_cast<std::size_t>(c)] = std::min(lit[static_cast<std::size_t>(c)], z);
    }
    for (int u = 0; u < camera.width; ++u) {
      float& z = image.z[pixel(camera, u, v)];
      if (z <= 0) continue;
      const int c = column(u);
      if (inside(c) && lit[static_cast<std::size_t>(c)] < z - kShadowTolerance) z = 0;
    }
  }
}

struct DepthRange {
  float nearest = std::numeric_limits<float>::infinity();
  float farthest = 0;
};

DepthRange range_around(const DepthImage& image, int u, int v, int reach) {
  DepthRange range;
  for (int y = std::max(0, v - reach); y <= std::min(image.camera.height - 1, v + reach); ++y)
    for (int x = std::max(0, u - reach); x <= std::min(image.camera.width - 1, u + reach); ++x)
      if (const float z = image.at(x, y); z > 0) {
        range.nearest = std::min(range.nearest, z);
        range.farthest = std::max(range.farthest, z);
      }
  return range;
}

// At depth edges a pixel may see its neighbour, float between front and back, or see nothing.
DepthImage blur_edges(const DepthImage& image, const SensorModel& model, Random& random) {
  DepthImage out = image;
  const auto& camera = image.camera;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const DepthRange range = range_around(image, u, v, model.edge_reach);
      if (!(range.farthest - range.nearest > model.edge_step)) continue;
      float& z = out.z[pixel(camera, u, v)];
      const int x = std::clamp(u + static_cast<int>(std::lround(random.normal(0, model.edge_jitter))), 0,
                               camera.width - 1);
      const int y = std::clamp(v + static_cast<int>(std::lround(random.normal(0, model.edge_jitter))), 0,
                               camera.height - 1);
      z = image.at(x, y);
      const double fate = random.uniform();
      if (fate < model.edge_holes)
        z = 0;
      else if (fate < model.edge_holes + model.edge_flying)
        z = static_cast<float>(random.uniform(range.nearest, range.farthest));
    }
  return out;
}

// Smooth field of unit variance: normals on a grid, blended and renormalised so that the variance is the same
// on and between the nodes.
class SmoothField {
 public:
  SmoothField(const CameraIntrinsics& camera, double spacing, Random random)
      : spacing_(spacing), columns_(static_cast<int>(camera.width / spacing) + 2) {
    const int rows = static_cast<int>(camera.height / spacing) + 2;
    nodes_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows));
    for (auto& node : nodes_) node = random.normal();
  }

  [[nodiscard]] double at(int u, int v) const {
    const double x = u / spacing_, y = v / spacing_;
    const int column = static_cast<int>(x), row = static_cast<int>(y);
    const double s = x - column, t = y - row;
    const double w[4] = {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t};
    double sum = 0, squares = 0;
    for (int k = 0; k < 4; ++k) {
      sum += w[k] * nodes_[static_cast<std::size_t>((row + k / 2) * columns_ + column + k % 2)];
      squares += w[k] * w[k];
    }
    return sum / std::sqrt(squares);
  }

 private:
  double spacing_;
  int columns_;
  std::vector<double> nodes_;
};

// Convolves one axis with a Gaussian and rescales so that white noise of unit variance keeps it.
void blur_axis(PixelField& field, const CameraIntrinsics& camera, double sigma, bool along_u) {
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  std::vector<double> kernel;
  double squares = 0;
  for (int k = -radius; k <= radius; ++k) {
    kernel.push_back(std::exp(-0.5 * k * k / (sigma * sigma)));
    squares += kernel.back() * kernel.back();
  }
  const PixelField source = field;
  const auto mirror = [](int i, int count) { return i < 0 ? -i : i >= count ? 2 * count - 2 - i : i; };
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      double sum = 0;
      for (int k = -radius; k <= radius; ++k) {
        const int x = along_u ? mirror(u + k, camera.width) : u;
        const int y = along_u ? v : mirror(v + k, camera.height);
        sum += kernel[static_cast<std::size_t>(k + radius)] * source[pixel(camera, x, y)];
      }
      field[pixel(camera, u, v)] = static_cast<float>(sum / std::sqrt(squares));
    }
}

PixelField unit_noise(const CameraIntrinsics& camera, double correlation, Random& random) {
  PixelField noise(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  for (auto& value : noise) value = static_cast<float>(random.normal());
  if (correlation > 0) {
    blur_axis(noise, camera, correlation, true);
    blur_axis(noise, camera, correlation, false);
  }
  return noise;
}

double depth_sigma(const SensorModel& model, const CameraIntrinsics& camera, double z, double cosine) {
  const double theta = std::acos(std::clamp(cosine, 0.0, 1.0));
  const double left = std::max(kHalfPi - theta, 0.02);
  double sigma = model.sigma + model.sigma_square * z * z;
  if (model.stereo_subpixel > 0) sigma += model.stereo_subpixel * z * z / (camera.fx * model.stereo_baseline);
  return sigma * (1 + model.grazing * theta * theta / (left * left));
}

void punch_holes(DepthImage& image, const SensorModel& model, Random& random) {
  const auto& camera = image.camera;
  if (model.hole_share > 0)
    for (auto& z : image.z)
      if (random.uniform() < model.hole_share) z = 0;
  for (int b = 0; b < model.blobs; ++b) {
    const double x = random.uniform(0, camera.width), y = random.uniform(0, camera.height);
    const double rx = model.blob_radius * random.uniform(0.5, 1.5),
                 ry = model.blob_radius * random.uniform(0.5, 1.5);
    for (int v = std::max(0, static_cast<int>(y - ry)); v <= std::min(camera.height - 1.0, y + ry); ++v)
      for (int u = std::max(0, static_cast<int>(x - rx)); u <= std::min(camera.width - 1.0, x + rx); ++u)
        if (std::hypot((u - x) / rx, (v - y) / ry) < 1) image.z[pixel(camera, u, v)] = 0;
  }
}

}  // namespace

DepthImage add_noise(const RenderedView& view, const Pose& T_W_C, const SensorModel& model, Random& random) {
  const auto& camera = view.depth.camera;
  require(view.depth.z.size() == view.normal_W.size(), "a view has a normal for every pixel, got ",
          view.depth.z.size(), " depths and ", view.normal_W.size(), " normals");
  require(model.unit > 0, "a depth unit must be positive, got ", model.unit, " m");
  const PixelField cosine = cosines(view, T_W_C);
  DepthImage image = view.depth;
  for (std::size_t i = 0; i < image.z.size(); ++i)
    if (cosine[i] < model.min_cosine) image.z[i] = 0;
  if (model.shadow_baseline > 0) cast_shadow(image, model.shadow_baseline);
  if (model.edge_jitter > 0 || model.edge_flying > 0 || model.edge_holes > 0)
    image = blur_edges(image, model, random);
  const SmoothField bias(camera, model.bias_pixels, Random::stream(model.bias_seed, "depth bias"));
  const PixelField noise = unit_noise(camera, model.correlation, random);
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const auto i = pixel(camera, u, v);
      float& z = image.z[i];
      if (z <= 0) continue;
      // A pixel that came from its neighbour's surface has no angle of its own.
      const double angle = std::max<double>(cosine[i], model.min_cosine);
      z += static_cast<float>(model.bias * bias.at(u, v) + depth_sigma(model, camera, z, angle) * noise[i]);
    }
  punch_holes(image, model, random);
  for (auto& z : image.z) {
    const bool in_range = z >= model.nearest && z <= model.farthest;
    if (in_range && model.disparity_step > 0) {
      const double step = model.disparity_step / (camera.fx * model.stereo_baseline);  // of 1 / z
      z = static_cast<float>(1.0 / (step * std::max(1.0, std::round(1.0 / (step * z)))));
    }
    z = in_range ? static_cast<float>(std::round(z / model.unit) * model.unit) : 0.0F;
  }
  return image;
}

}  // namespace stonestack::simulation
