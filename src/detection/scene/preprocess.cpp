#include "detection/scene/preprocess.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "detection/constants.hpp"
#include "detection/scene/fit_plane.hpp"
#include "detection/scene/point_grid.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::detection {
namespace {

constexpr int kFewestNeighbours = 10;  // of 25: fewer is an edge or a flying pixel
constexpr int kTableStride = 6;        // every 6th pixel along both axes is enough for a plane
constexpr int kTableTrials = 400;      // misses a table that fills a third of the view with p < 1e-6
constexpr double kTableShare = 0.05;   // of the valid pixels at least
constexpr double kNearer = 0.7;        // of the table's depth, ...
constexpr double kFarther = 1.15;      // ... what stands on it: judged by the noise that it shows as a whole
constexpr double kMaxBelow = 0.30;     // share of valid pixels below a table: more is a shelf or a wall

double depth_step(double z) {
  return kSmoothingStep * std::max(1.0, z * z);
}

std::uint64_t voxel_key(const Eigen::Vector3f& p, float voxel) {
  const auto part = [&](float x) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x / voxel)) + 1048576) & 0x1FFFFFU;
  };
  return part(p.z()) << 42U | part(p.y()) << 21U | part(p.x());
}

std::vector<Eigen::Vector3d> table_candidates(const DepthImage& depth) {
  std::vector<Eigen::Vector3d> points;
  for (int v = 0; v < depth.camera.height; v += kTableStride)
    for (int u = 0; u < depth.camera.width; u += kTableStride)
      if (const double z = depth.at(u, v); z > 0) points.push_back(z * deproject(depth.camera, u, v));
  return points;
}

bool plausible(const Plane& plane, const std::optional<Plane>& expected) {
  if (!expected) return plane.offset < -0.1;  // the camera is above it
  return plane.normal.dot(expected->normal) > 0.985 && std::abs(plane.offset - expected->offset) < 0.03;
}

/// Counts the points at a plane, coordinate by coordinate, so that the compiler can take several at once.
class PointCounter {
 public:
  explicit PointCounter(const std::vector<Eigen::Vector3d>& points) {
    for (const auto& p : points) x_.push_back(p.x()), y_.push_back(p.y()), z_.push_back(p.z());
  }

  /// Points within the tolerance; 0 if they are no more than `to_beat`, or if too many lie below.
  [[nodiscard]] std::size_t inliers(const Plane& plane, std::size_t to_beat) const {
    const double max_below = kMaxBelow * static_cast<double>(x_.size());
    double inliers = 0.0, below = 0.0;
    for (std::size_t start = 0; start < x_.size(); start += kAtOnce) {
      const std::size_t end = std::min(start + kAtOnce, x_.size());
      for (std::size_t i = start; i < end; ++i) {
        // in the order of Plane::distance
        const double d =
            plane.normal.x() * x_[i] + (plane.normal.y() * y_[i] + plane.normal.z() * z_[i]) - plane.offset;
        inliers += std::abs(d) < kTableTolerance ? 1.0 : 0.0;
        below += d < -5.0 * kTableTolerance ? 1.0 : 0.0;
      }
      if (below > max_below || inliers + static_cast<double>(x_.size() - end) <= static_cast<double>(to_beat))
        return 0;
    }
    return static_cast<std::size_t>(inliers);
  }

 private:
  static constexpr std::size_t kAtOnce = 512;
  std::vector<double> x_, y_, z_;
};

/// Smallest principal direction of the points near `p`; zero if they are too few or a line.
Eigen::Vector3f local_normal(const PointGrid& grid, const std::vector<Eigen::Vector3f>& points,
                             const Eigen::Vector3f& p, float radius) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  Eigen::Matrix3f outer = Eigen::Matrix3f::Zero();
  int count = 0;
  grid.for_each_near(p, radius, [&](int i, float) {
    const Eigen::Vector3f d = points[static_cast<std::size_t>(i)] - p;
    sum += d, outer += d * d.transpose(), ++count;
  });
  if (count < 6) return Eigen::Vector3f::Zero();
  const Eigen::Vector3f mean = sum / static_cast<float>(count);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
  solver.computeDirect(outer / static_cast<float>(count) - mean * mean.transpose());
  if (!(solver.eigenvalues()(1) > 4e-7F)) return Eigen::Vector3f::Zero();
  const Eigen::Vector3f normal = solver.eigenvectors().col(0);
  return normal.dot(p) > 0 ? Eigen::Vector3f(-normal) : normal;
}

}  // namespace

namespace {

/// Sums over the pixels around one that lie on the same surface: offsets du, dv and dz from it.
struct Window {
  float count = 0, u = 0, v = 0, z = 0, uu = 0, uv = 0, vv = 0, uz = 0, vz = 0;

  void add(float du, float dv, float dz) {
    count += 1, u += du, v += dv, z += dz;
    uu += du * du, uv += du * dv, vv += dv * dv, uz += du * dz, vz += dv * dz;
  }

  /// Depth of the fitted plane at the centre, over the centre's own depth. The mean, which does for a full
  /// window, would draw a slope inwards at a rim, where one side is missing.
  [[nodiscard]] float centre() const {
    const float mean = z / count;
    const float cu = u / count, cv = v / count;
    const float suu = uu - u * cu, suv = uv - u * cv, svv = vv - v * cv;
    const float suz = uz - u * mean, svz = vz - v * mean;
    const float det = suu * svv - suv * suv;
    if (det < 0.05F * suu * svv || det < 1.0F) return mean;
    return mean - (cu * (suz * svv - svz * suv) + cv * (svz * suu - suz * suv)) / det;
  }
};

/// Up to `kWidth` pixels of a row with the two around each, so that the compiler can take several at once.
struct RowOfWindows {
  static constexpr std::size_t kWidth = 64;
  std::array<std::array<float, kWidth + 4>, 5> near{};  // rows v - 2 to v + 2; zero past the last pixel
  std::array<float, kWidth> step{};                     // what is farther off is another surface
  std::array<float, kWidth> count{}, sum{};             // neighbours on the same surface, and their offsets

  /// Sums in the order in which `Window` adds.
  void add_up() {
    std::array<float, kWidth> counts{}, sums{};
    for (const auto& row : near)
      for (std::size_t du = 0; du < 5; ++du)
        for (std::size_t k = 0; k < kWidth; ++k) {
          const float off = row[k + du] - near[2][k + 2];
          const float one = std::abs(off) < step[k] ? 1.0F : 0.0F;
          const float part = std::abs(off) < step[k] ? off : 0.0F;
          counts[k] += one, sums[k] += part;
        }
    count = counts, sum = sums;
  }
};

Window window_at(const DepthImage& raw, int v, int u, float z, float step) {
  Window window;
  for (int dv = -2; dv <= 2; ++dv) {
    const float* row = &raw.z[static_cast<std::size_t>((v + dv) * raw.camera.width + u - 2)];
    for (int k = 0; k < 5; ++k)
      if (std::abs(row[k] - z) < step)
        window.add(static_cast<float>(k - 2), static_cast<float>(dv), row[k] - z);
  }
  return window;
}

}  // namespace

DepthImage smooth_depth(const DepthImage& raw, const DetectionOptions& options) {
  const int width = raw.camera.width, height = raw.camera.height;
  DepthImage out{raw.camera, std::vector<float>(raw.z.size(), 0.0F)};
  const auto in_range = [&](float z) { return z >= options.nearest && z <= options.farthest; };
  tbb::parallel_for(tbb::blocked_range<int>(2, std::max(2, height - 2), 16), [&](const auto& rows) {
    RowOfWindows part;
    const int most = static_cast<int>(RowOfWindows::kWidth);
    for (int v = rows.begin(); v < rows.end(); ++v)
      for (int u = 2; u < width - 2; u += most) {
        const int many = std::min(most, width - 2 - u);
        part.near = {};
        for (int dv = -2; dv <= 2; ++dv)
          std::copy_n(&raw.z[static_cast<std::size_t>((v + dv) * width + u - 2)], many + 4,
                      part.near[static_cast<std::size_t>(dv + 2)].begin());
        const float* z = &raw.z[static_cast<std::size_t>(v * width + u)];
        for (int k = 0; k < most; ++k)  // of a pixel out of range no neighbour is taken
          part.step[static_cast<std::size_t>(k)] =
              k < many && in_range(z[k]) ? static_cast<float>(depth_step(z[k])) : -1.0F;
        part.add_up();
        for (int k = 0; k < many; ++k) {
          const auto i = static_cast<std::size_t>(k);
          float& smooth = out.z[static_cast<std::size_t>(v * width + u + k)];
          if (part.count[i] >= 25.0F)
            smooth = z[k] + part.sum[i] / part.count[i];
          else if (part.count[i] >= kFewestNeighbours)
            smooth = z[k] + window_at(raw, v, u + k, z[k], part.step[i]).centre();
        }
      }
  });
  return out;
}

std::optional<Plane> find_table(const DepthImage& depth, const std::optional<Plane>& expected,
                                const DetectionOptions& options) {
  const std::vector<Eigen::Vector3d> points = table_candidates(depth);
  if (points.size() < 30) return {};
  const PointCounter counter(points);
  Random random = Random::stream(static_cast<std::uint64_t>(options.seed), "detection table");
  std::optional<Plane> best;
  std::size_t best_inliers = static_cast<std::size_t>(kTableShare * static_cast<double>(points.size()));
  for (int trial = 0; trial < kTableTrials; ++trial) {
    const auto plane = plane_through(points[random.index(points.size())], points[random.index(points.size())],
                                     points[random.index(points.size())]);
    if (!plane || !plausible(*plane, expected)) continue;
    const std::size_t inliers = counter.inliers(*plane, best_inliers);
    if (inliers > best_inliers) best = plane, best_inliers = inliers;
  }
  if (!best) return expected;
  return fit_plane(points, *best, kTableTolerance);
}

NoiseAbout noise_about(const Plane& plane_C, const DepthImage& depth, double tolerance) {
  std::vector<double> off, depths;
  for (const auto& p : table_candidates(depth))
    if (const double d = std::abs(plane_C.distance(p)); d < 3.0 * tolerance)
      off.push_back(d), depths.push_back(p.z());
  if (off.size() < 30) return {};
  const auto median = [](std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  return {1.4826 * median(off), median(depths)};
}

double noise_at(const DetectionScene& scene, double z) {
  if (!(scene.noise_depth > 0.0)) return scene.noise;
  const double ratio = z / scene.noise_depth;
  const double outside = ratio < kNearer ? ratio / kNearer : std::max(1.0, ratio / kFarther);
  return scene.noise * outside * outside;
}

SurfacePoints surface_points(const std::vector<Eigen::Vector3f>& points, const std::vector<float>& areas,
                             float voxel, float radius) {
  std::vector<std::pair<std::uint64_t, int>> order(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    order[i] = {voxel_key(points[i], voxel), static_cast<int>(i)};
  std::sort(order.begin(), order.end());
  std::vector<Eigen::Vector3f> means;
  std::vector<float> sums;
  for (std::size_t i = 0; i < order.size();) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    float area = 0;
    int count = 0;
    for (const auto key = order[i].first; i < order.size() && order[i].first == key; ++i, ++count)
      sum += points[static_cast<std::size_t>(order[i].second)],
          area += areas[static_cast<std::size_t>(order[i].second)];
    means.emplace_back(sum / static_cast<float>(count));
    sums.push_back(area);
  }
  const PointGrid grid(means, radius);
  std::vector<Eigen::Vector3f> normals(means.size());
  tbb::parallel_for(std::size_t{0}, means.size(),
                    [&](std::size_t i) { normals[i] = local_normal(grid, means, means[i], radius); });
  SurfacePoints out;
  for (std::size_t i = 0; i < means.size(); ++i)
    if (normals[i].squaredNorm() > 0.5F) {
      out.points.push_back(means[i]);
      out.normals.push_back(normals[i]);
      out.areas.push_back(sums[i]);
    }
  return out;
}

std::vector<int> cluster_points(const std::vector<Eigen::Vector3f>& points, float gap, int fewest) {
  std::vector<int> label(points.size(), -1);
  if (points.empty()) return label;
  const PointGrid grid(points, gap);
  std::vector<std::pair<int, int>> size_of;  // (-size, label), to sort the largest first
  std::vector<int> open;
  for (std::size_t seed = 0; seed < points.size(); ++seed) {
    if (label[seed] >= 0) continue;
    const int name = static_cast<int>(size_of.size());
    size_of.emplace_back(0, name);
    label[seed] = name;
    open.assign(1, static_cast<int>(seed));
    while (!open.empty()) {
      const auto at = static_cast<std::size_t>(open.back());
      open.pop_back();
      --size_of.back().first;
      grid.for_each_near(points[at], gap, [&](int i, float) {
        if (label[static_cast<std::size_t>(i)] >= 0) return;
        label[static_cast<std::size_t>(i)] = name;
        open.push_back(i);
      });
    }
  }
  std::vector<int> rank(size_of.size(), -1);
  std::sort(size_of.begin(), size_of.end());
  for (std::size_t i = 0; i < size_of.size() && -size_of[i].first >= fewest; ++i)
    rank[static_cast<std::size_t>(size_of[i].second)] = static_cast<int>(i);
  for (int& l : label) l = rank[static_cast<std::size_t>(l)];
  return label;
}

}  // namespace stonestack::detection
