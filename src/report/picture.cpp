#include "report/picture.hpp"

#include <png.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csetjmp>
#include <cstring>
#include <optional>

#include "geometry/depth_render.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::report {
namespace {

constexpr int kSkyRays = 32;        // ambient occlusion rays a pixel
constexpr double kSkyReach = 0.5;   // m: what is further away hides no sky
constexpr int kSamplesPerSide = 2;  // 2 x 2 rays a pixel, each with its share of the sky
constexpr int kSamples = kSamplesPerSide * kSamplesPerSide;
constexpr double kSunReach = 10.0;    // m
constexpr double kGrain = 0.12;       // of a face's brightness, at most
constexpr double kShadowBias = 2e-4;  // m
const Eigen::Vector3d kTableColour(0.58, 0.60, 0.62);
const Eigen::Vector3d kSky(0.86, 0.90, 0.96);
const Eigen::Vector3d kSun = Eigen::Vector3d(-0.35, -0.65, 0.85).normalized();

Mesh make_table(double h) {
  Mesh table;
  table.vertices = {{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}};
  table.faces = {{0, 1, 2}, {0, 2, 3}};
  return table;
}

/// Cosine-weighted directions about +z, the same for every pixel but turned by a hash: no noise pattern, no
/// state.
std::vector<Eigen::Vector3d> sky_directions() {
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < kSkyRays; ++i) {
    const double radius = std::sqrt((i + 0.5) / kSkyRays);
    const double angle = 2.39996322972865332 * i;  // golden angle
    directions.emplace_back(radius * std::cos(angle), radius * std::sin(angle),
                            std::sqrt(1 - radius * radius));
  }
  return directions;
}

struct Painter {
  const std::vector<DrawnMesh>& meshes;
  RayScene scene;
  std::optional<RayScene> solids;  ///< where not all meshes of the scene are solid
  std::vector<Eigen::Vector3d> sky = sky_directions();

  Painter(const std::vector<DrawnMesh>& drawn, double table) : meshes(drawn) {
    fill(scene, table, true);
    if (std::all_of(meshes.begin(), meshes.end(), [](const DrawnMesh& item) { return item.solid; })) return;
    fill(solids.emplace(), table, false);
  }
  void fill(RayScene& rays, double table, bool lines) const {
    rays.add(make_table(table), Pose(Eigen::Translation3d(0.7, 0.1, 0.0)));
    for (const auto& item : meshes)
      if (lines || item.solid) rays.add(item.mesh, item.T_W_A);
    rays.commit();
  }
  /// Meshes that cast shadows.
  [[nodiscard]] const RayScene& shading() const { return solids ? *solids : scene; }

  [[nodiscard]] Eigen::Vector3d colour(const Eigen::Vector3d& eye, const Eigen::Vector3d& ray, int sample,
                                       double turn) const {
    const RayHit hit = scene.cast(eye, ray);
    if (hit.instance < 0) return kSky;
    const Eigen::Vector3d normal = hit.normal.dot(ray) > 0 ? Eigen::Vector3d(-hit.normal) : hit.normal;
    const Eigen::Vector3d point = eye + hit.distance * ray + kShadowBias * normal;
    const Eigen::Vector3d base = hit.instance == 0 ? kTableColour : colour_of(hit);
    const double facing = std::max(0.0, normal.dot(kSun));
    const double sun = facing > 0 && !shading().is_blocked(point, kSun, kSunReach) ? facing : 0.0;
    const Eigen::Vector3d light =
        0.62 * sun * Eigen::Vector3d(1.0, 0.96, 0.88) + 0.52 * openness(point, normal, sample, turn) * kSky;
    return base.cwiseProduct(light);
  }

  [[nodiscard]] Eigen::Vector3d colour_of(const RayHit& hit) const {
    const DrawnMesh& mesh = meshes[static_cast<std::size_t>(hit.instance - 1)];
    if (!mesh.grain) return mesh.colour;
    Random random =
        Random::stream(static_cast<std::uint64_t>(hit.instance), static_cast<std::uint64_t>(hit.face));
    return mesh.colour * random.uniform(1.0 - kGrain, 1.0 + kGrain);
  }

  /// Share of the sky that a point sees, by every fourth of its directions.
  [[nodiscard]] double openness(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, int sample,
                                double turn) const {
    const Eigen::Quaterniond tilt = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal);
    const Eigen::Quaterniond about(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
    std::array<Eigen::Vector3d, kSkyRays / kSamples> directions;
    for (std::size_t k = 0; k < directions.size(); ++k)
      directions[k] = tilt * (about * sky[static_cast<std::size_t>(sample) + k * kSamples]);
    return 1.0 - static_cast<double>(shading().count_blocked(point, directions, kSkyReach)) /
                     static_cast<double>(directions.size());
  }
};

/// Linear light to an 8-bit sRGB value.
std::uint8_t encode(double linear) {
  const double v = std::clamp(linear, 0.0, 1.0);
  const double s = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255.0 * s));
}

struct Lens {
  Eigen::Vector3d forward, right, up;
  double half_height, half_width;
  explicit Lens(const View& view) {
    forward = (view.p_W_target - view.p_W_eye).normalized();
    right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
    up = right.cross(forward);
    half_height = std::tan(view.angle / 2);
    half_width = half_height * view.width / view.height;
  }
  /// x, y in [-1, 1], y upwards.
  [[nodiscard]] Eigen::Vector3d ray(double x, double y) const {
    return (forward + x * half_width * right + y * half_height * up).normalized();
  }
};

}  // namespace

Picture draw(const std::vector<DrawnMesh>& meshes, const View& view) {
  require(view.width > 0 && view.height > 0 && view.width <= 8192 && view.height <= 8192, "picture of ",
          view.width, " x ", view.height, " pixels; sides must be in [1, 8192]");
  require((view.p_W_target - view.p_W_eye).cross(Eigen::Vector3d::UnitZ()).norm() > 1e-6,
          "the view must not look straight up or down");
  const Painter painter(meshes, view.table);
  const Lens lens(view);
  Picture picture{view.width, view.height,
                  std::vector<std::uint8_t>(static_cast<std::size_t>(view.width) *
                                            static_cast<std::size_t>(view.height) * 3)};
  tbb::parallel_for(0, view.height, [&](int row) {
    for (int column = 0; column < view.width; ++column) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      Random random = Random::stream(static_cast<std::uint64_t>(row), static_cast<std::uint64_t>(column));
      const double turn = random.uniform(0.0, 6.283185307);
      for (int s = 0; s < kSamples; ++s) {
        const double x = (column + (s % kSamplesPerSide + 0.5) / kSamplesPerSide) / view.width;
        const double y = (row + (s / kSamplesPerSide + 0.5) / kSamplesPerSide) / view.height;
        sum += painter.colour(view.p_W_eye, lens.ray(2 * x - 1, 1 - 2 * y), s, turn);
      }
      const auto at = 3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(view.width) +
                           static_cast<std::size_t>(column));
      for (int c = 0; c < 3; ++c) picture.rgb[at + static_cast<std::size_t>(c)] = encode(sum[c] / kSamples);
    }
  });
  return picture;
}

std::string png_bytes(const Picture& picture) {
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  image.format = PNG_FORMAT_RGB;
  const auto encode_into = [&](void* to, png_alloc_size_t& size) {
    if (png_image_write_to_memory(&image, to, &size, 0, picture.rgb.data(), 0, nullptr) == 0)
      throw FileError("picture", concat("cannot be encoded: ", image.message), "report it");
  };
  png_alloc_size_t size = 0;
  encode_into(nullptr, size);
  std::string bytes(size, '\0');
  encode_into(bytes.data(), size);
  bytes.resize(size);
  return bytes;
}

void write_png(const std::string& path, const Picture& picture) {
  write_file(path, png_bytes(picture));
}

}  // namespace stonestack::report
