#include "span_check.hpp"

#include <algorithm>
#include <cmath>

#include "physics/shape.hpp"

namespace stonestack::bench {
namespace {

constexpr double kLine = 0.001;  // m between lines

/// Height at which the vertical line through (x, 0) meets a triangle; empty if it does not.
std::optional<double> met_at(double x, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                             const Eigen::Vector3d& c) {
  const auto cross = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
    return p.x() * q.y() - p.y() * q.x();
  };
  const Eigen::Vector2d at(x, 0.0), u = (b - a).head<2>(), v = (c - a).head<2>(), w = at - a.head<2>();
  const double area = cross(u, v);
  if (std::abs(area) < 1e-15) return std::nullopt;
  const double s = cross(w, v) / area, t = cross(u, w) / area;
  if (s < 0.0 || t < 0.0 || s + t > 1.0) return std::nullopt;
  return a.z() + s * (b - a).z() + t * (c - a).z();
}

}  // namespace

SpanCheck check_span(const ShapeList& shapes, const Stack& stones, const Pose& T_V_W, const Span& span) {
  const int lines = std::max(1, static_cast<int>(std::lround((span.to - span.from) / kLine)));
  std::vector<bool> covered(static_cast<std::size_t>(lines), false);
  SpanCheck check;
  for (const PlacedStone& placed : stones.stones) {
    const Mesh& scan = at(shapes, placed.stone)->scan;
    const Pose T_V_O = T_V_W * placed.T_W_O;
    std::vector<Eigen::Vector3d> p_V;
    for (const Eigen::Vector3d& p_O : scan.vertices) {
      p_V.push_back(T_V_O * p_O);
      if (p_V.back().x() > span.from && p_V.back().x() < span.to)
        check.in_the_way = std::max(check.in_the_way, span.clear - p_V.back().z());
    }
    for (int k = 0; k < lines; ++k) {
      const double x = span.from + (k + 0.5) * (span.to - span.from) / lines;
      for (const Eigen::Vector3i& face : scan.faces) {
        if (covered[static_cast<std::size_t>(k)]) break;
        const auto corner = [&](int i) { return p_V[static_cast<std::size_t>(face[i])]; };
        if (met_at(x, corner(0), corner(1), corner(2))) covered[static_cast<std::size_t>(k)] = true;
      }
    }
  }
  check.covered = static_cast<double>(std::count(covered.begin(), covered.end(), true)) / lines;
  return check;
}

}  // namespace stonestack::bench
