#include "span_check.hpp"

#include <algorithm>
#include <cmath>

#include "physics/shape.hpp"

namespace stonestack::bench {
namespace {

constexpr double kLine = 0.001;        // m between lines
constexpr double kBeside = 1e-6;       // m from an end of a span: blocks end there
constexpr int kAlongEdge = 16;         // parts of an edge whose ends are looked at
constexpr double kSupportGap = 0.001;  // m: nearer is a contact

/// Does the vertical line through (x, 0) meet a triangle?
bool is_met(double x, const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const auto cross = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q) {
    return p.x() * q.y() - p.y() * q.x();
  };
  const Eigen::Vector2d at(x, 0.0), u = (b - a).head<2>(), v = (c - a).head<2>(), w = at - a.head<2>();
  const double area = cross(u, v);
  if (std::abs(area) < 1e-15) return false;
  const double s = cross(w, v) / area, t = cross(u, w) / area;
  return s >= 0.0 && t >= 0.0 && s + t <= 1.0;
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
    for (const Eigen::Vector3d& p_O : scan.vertices) p_V.push_back(T_V_O * p_O);
    for (const Eigen::Vector3i& face : scan.faces)
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d& p = p_V[static_cast<std::size_t>(face[k])];
        const Eigen::Vector3d& q = p_V[static_cast<std::size_t>(face[(k + 1) % 3])];
        for (int step = 0; step <= kAlongEdge; ++step) {
          const Eigen::Vector3d r = p + (q - p) * step / kAlongEdge;
          if (r.x() > span.from + kBeside && r.x() < span.to - kBeside)
            check.in_the_way = std::max(check.in_the_way, span.clear - r.z());
        }
      }
    for (int k = 0; k < lines; ++k) {
      const double x = span.from + (k + 0.5) * (span.to - span.from) / lines;
      for (const Eigen::Vector3i& face : scan.faces) {
        if (covered[static_cast<std::size_t>(k)]) break;
        const auto corner = [&](int i) { return p_V[static_cast<std::size_t>(face[i])]; };
        if (is_met(x, corner(0), corner(1), corner(2))) covered[static_cast<std::size_t>(k)] = true;
      }
    }
  }
  check.covered = static_cast<double>(std::count(covered.begin(), covered.end(), true)) / lines;
  return check;
}

Stack bridging_stones(const ShapeList& shapes, const Stack& stones, const Pose& T_V_W, const Span& span) {
  const std::vector<Contact> contacts = geometric_contacts(shapes, stones, kSupportGap);
  std::vector<std::size_t> group(stones.stones.size());
  for (std::size_t k = 0; k < group.size(); ++k) group[k] = k;
  for (const Contact& contact : contacts) {
    if (contact.below == kTable) continue;
    const std::size_t joined = group[static_cast<std::size_t>(contact.below)];
    const std::size_t other = group[static_cast<std::size_t>(contact.above)];
    std::replace(group.begin(), group.end(), other, joined);
  }
  const double middle = 0.5 * (span.from + span.to);
  std::vector<bool> left(group.size(), false), right(group.size(), false);
  for (const Contact& contact : contacts)
    if (contact.below == kTable)
      ((T_V_W * contact.p_W).x() < middle ? left : right)[group[static_cast<std::size_t>(contact.above)]] =
          true;
  Stack bridging;
  for (std::size_t k = 0; k < group.size(); ++k)
    if (left[group[k]] && right[group[k]]) bridging.stones.push_back(stones.stones[k]);
  return bridging;
}

}  // namespace stonestack::bench
