#include "stonestack/geometry/fit_camera.hpp"

#include <cmath>
#include <utility>

#include "stonestack/core/quantile.hpp"

namespace stonestack {
namespace {

constexpr std::size_t kFewest = 100;
constexpr double kLargestResidual = 1.0;  // pixels, median

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
  if (lines.first.residual > kLargestResidual || lines.second.residual > kLargestResidual)
    return std::nullopt;
  return lines;
}

}  // namespace

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

}  // namespace stonestack
