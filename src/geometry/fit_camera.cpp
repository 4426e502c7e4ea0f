#include "stonestack/geometry/depth_image.hpp"

#include <cmath>
#include <utility>

#include "core/quantile.hpp"

namespace stonestack::geometry {
namespace {

constexpr std::size_t kFewest = 100;
constexpr double kMaxResidual = 1.0;  // pixels, median
constexpr double kWidest = 1.5;       // tangent of half a field of view
constexpr double kFilled = 0.8;       // of the pixels around one with a point: a surface, not a sieve

/// u = f * t + c by least squares, and the median of |residual|.
struct Line {
  double f = 0.0, c = 0.0, residual = 1e9;
};

Line fit_line(const std::vector<double>& t, const std::vector<double>& u) {
  double st = 0, su = 0, stt = 0, stu = 0;
  const auto n = static_cast<double>(t.size());
  for (std::size_t i = 0; i < t.size(); ++i) {
    st += t[i];
    su += u[i];
    stt += t[i] * t[i];
    stu += t[i] * u[i];
  }
  const double determinant = n * stt - st * st;
  if (!(determinant > 1e-9)) return {};
  Line line;
  line.f = (n * stu - st * su) / determinant;
  line.c = (su - line.f * st) / n;
  std::vector<double> residuals(t.size());
  for (std::size_t i = 0; i < t.size(); ++i) residuals[i] = std::abs(u[i] - line.f * t[i] - line.c);
  line.residual = quantile(std::move(residuals), 0.5);
  return line;
}

/// Columns over x / z and rows over y / z; empty for a cloud that is not organised or has too few points.
std::optional<std::pair<Line, Line>> fit_lines(const Cloud& cloud) {
  if (cloud.height < 2 ||
      cloud.points.size() != static_cast<std::size_t>(cloud.width) * static_cast<std::size_t>(cloud.height))
    return std::nullopt;
  std::vector<double> tx, ty, u, v;
  for (int row = 0; row < cloud.height; ++row)
    for (int column = 0; column < cloud.width; ++column) {
      const auto& p = cloud.points[static_cast<std::size_t>(row) * static_cast<std::size_t>(cloud.width) +
                                   static_cast<std::size_t>(column)];
      if (!p.allFinite() || p.z() <= 0.0F) continue;
      tx.push_back(p.x() / p.z());
      ty.push_back(p.y() / p.z());
      u.push_back(column);
      v.push_back(row);
    }
  if (tx.size() < kFewest) return std::nullopt;
  const std::pair<Line, Line> lines{fit_line(tx, u), fit_line(ty, v)};
  if (lines.first.residual > kMaxResidual || lines.second.residual > kMaxResidual) return std::nullopt;
  return lines;
}

/// Half width that contains all but a hundredth of `tangents`; at least `usual`.
double half_width(std::vector<float> tangents, double usual) {
  if (tangents.empty()) return usual;
  const auto at = tangents.begin() + static_cast<std::ptrdiff_t>(tangents.size() * 99 / 100);
  std::nth_element(tangents.begin(), at, tangents.end());
  return std::clamp(static_cast<double>(*at), usual, kWidest);
}

/// Half tangents of a field of view that takes the cloud in.
Eigen::Vector2d field_of_view(const Cloud& cloud) {
  const CameraIntrinsics usual;
  std::vector<float> across, down;
  for (const auto& p : cloud.points)
    if (p.allFinite() && p.z() > 0.0F)
      across.push_back(std::abs(p.x() / p.z())), down.push_back(std::abs(p.y() / p.z()));
  return {half_width(std::move(across), 0.5 * usual.width / usual.fx),
          half_width(std::move(down), 0.5 * usual.height / usual.fy)};
}

CameraIntrinsics pinhole_of(const Eigen::Vector2d& half, double focal) {
  CameraIntrinsics camera;
  camera.width = static_cast<int>(std::ceil(2.0 * half.x() * focal - 1e-6));
  camera.height = static_cast<int>(std::ceil(2.0 * half.y() * focal - 1e-6));
  camera.fx = camera.fy = focal;
  camera.cx = 0.5 * (camera.width - 1);
  camera.cy = 0.5 * (camera.height - 1);
  return camera;
}

/// Half of the pixels with a depth stand among 5 x 5 of which `kFilled` have one.
bool is_filled(const DepthImage& image) {
  const int width = image.camera.width, height = image.camera.height;
  std::size_t with = 0, among = 0;
  for (int v = 2; v < height - 2; ++v)
    for (int u = 2; u < width - 2; ++u) {
      if (!(image.at(u, v) > 0.0F)) continue;
      ++with;
      int around = 0;
      for (int k = 0; k < 25; ++k) around += image.at(u - 2 + k % 5, v - 2 + k / 5) > 0.0F ? 1 : 0;
      among += around >= 25 * kFilled ? 1 : 0;
    }
  return 2 * among > with;
}

}  // namespace

CameraIntrinsics camera_for(const Cloud& cloud) {
  const Eigen::Vector2d half = field_of_view(cloud);
  const double usual = CameraIntrinsics{}.fx;
  for (const double coarser : {1.0, 1.5, 2.0, 3.0, 4.0, 6.0}) {
    const CameraIntrinsics camera = pinhole_of(half, usual / coarser);
    if (is_filled(to_depth_image(cloud, camera))) return camera;
  }
  return pinhole_of(half, usual);
}

std::optional<CameraIntrinsics> fit_camera(const Cloud& cloud) {
  const auto lines = fit_lines(cloud);
  if (!lines || lines->first.f <= 0 || lines->second.f <= 0) return std::nullopt;
  CameraIntrinsics camera;
  camera.width = cloud.width;
  camera.height = cloud.height;
  camera.fx = lines->first.f;
  camera.cx = lines->first.c;
  camera.fy = lines->second.f;
  camera.cy = lines->second.c;
  return camera;
}

bool is_mirrored(const Cloud& cloud) {
  const auto lines = fit_lines(cloud);
  return lines && lines->first.f * lines->second.f < 0;
}

}  // namespace stonestack::geometry
