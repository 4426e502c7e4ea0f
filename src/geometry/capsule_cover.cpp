#include "geometry/capsule_cover.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "stonestack/core/error.hpp"

namespace stonestack::geometry {
namespace {

using Points = Eigen::Matrix3Xd;
using Triangle = std::array<Eigen::Vector3d, 3>;

constexpr double kShare = 1.0 / 24.0;  // of the mesh's size: longer edges are cut, so that parts can be
constexpr std::size_t kMaxTriangles = 200'000;  // after that
constexpr double kWorth = 0.05;                 // of a part's volume: what a cut has to save
constexpr double kSmaller = 0.99;               // of its volume: what handing triangles over has to bring
constexpr int kRounds = 8;
constexpr int kCuts = 7;  // places along each axis where a cut is tried

/// Halves the longest edge until none is longer than `longest`.
void cut_small(const Triangle& whole, double longest, std::vector<Triangle>& parts) {
  std::vector<Triangle> todo{whole};
  while (!todo.empty()) {
    const Triangle t = todo.back();
    todo.pop_back();
    std::size_t edge = 0;
    double length = 0.0;
    for (std::size_t k = 0; k < 3; ++k)
      if (const double l = (t[(k + 1) % 3] - t[k]).norm(); l > length) length = l, edge = k;
    if (length <= longest || parts.size() + todo.size() >= kMaxTriangles) {
      parts.push_back(t);
      continue;
    }
    const Eigen::Vector3d middle = 0.5 * (t[edge] + t[(edge + 1) % 3]);
    todo.push_back({t[edge], middle, t[(edge + 2) % 3]});
    todo.push_back({middle, t[(edge + 1) % 3], t[(edge + 2) % 3]});
  }
}

/// The surface in pieces small enough to be told apart.
struct Surface {
  Points points;
  std::vector<Eigen::Vector3i> triangles;
  Points centres;
};

Surface cut_up(const Mesh& mesh, double longest) {
  std::vector<Triangle> small;
  const auto corner = [&](int k) { return mesh.vertices[static_cast<std::size_t>(k)]; };
  for (const auto& f : mesh.faces) cut_small({corner(f[0]), corner(f[1]), corner(f[2])}, longest, small);
  Surface surface;
  std::map<std::array<double, 3>, int> known;
  std::vector<Eigen::Vector3d> points;
  surface.centres.resize(3, static_cast<Eigen::Index>(small.size()));
  for (const Triangle& t : small) {
    Eigen::Vector3i face;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d& p = t[static_cast<std::size_t>(k)];
      const auto [at, fresh] = known.try_emplace({p.x(), p.y(), p.z()}, static_cast<int>(points.size()));
      if (fresh) points.push_back(p);
      face[k] = at->second;
    }
    surface.centres.col(static_cast<Eigen::Index>(surface.triangles.size())) = (t[0] + t[1] + t[2]) / 3.0;
    surface.triangles.push_back(face);
  }
  surface.points.resize(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t k = 0; k < points.size(); ++k)
    surface.points.col(static_cast<Eigen::Index>(k)) = points[k];
  return surface;
}

struct Part {
  std::vector<Eigen::Index> triangles;
  Capsule capsule;
};

Points corners(const Surface& surface, const std::vector<Eigen::Index>& triangles) {
  std::vector<Eigen::Index> chosen;
  for (const Eigen::Index t : triangles)
    for (const int k : surface.triangles[static_cast<std::size_t>(t)]) chosen.push_back(k);
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return surface.points(Eigen::all, chosen);
}

Part make_part(const Surface& surface, std::vector<Eigen::Index> triangles, bool carefully) {
  const Capsule capsule = fit_capsule(corners(surface, triangles), carefully);
  return {std::move(triangles), capsule};
}

bool holds(const Surface& surface, const Capsule& capsule, Eigen::Index triangle) {
  const Eigen::Vector3i& face = surface.triangles[static_cast<std::size_t>(triangle)];
  return std::all_of(face.begin(), face.end(),
                     [&](int k) { return distance(capsule, surface.points.col(k)) <= 0.0; });
}

struct Cut {
  Part one, other;
  double saved = 0.0;  // m^3
};

/// Cuts the surface in two; what one side's capsule contains of the other becomes its own.
Cut cut_in_two(const Surface& surface, const std::vector<Eigen::Index>& side,
               const std::vector<Eigen::Index>& other_side) {
  Part one = make_part(surface, side, false);
  std::vector<Eigen::Index> rest;
  for (const Eigen::Index t : other_side)
    (holds(surface, one.capsule, t) ? one.triangles : rest).push_back(t);
  if (rest.empty()) rest = {other_side.front()};
  return {std::move(one), make_part(surface, std::move(rest), false)};
}

/// Where a part is best cut in two by a plane, if that saves anything.
std::optional<Cut> best_cut(const Surface& surface, const Part& part) {
  std::optional<Cut> best;
  const Points centres = surface.centres(Eigen::all, part.triangles);
  for (const auto& n : axes_of(centres)) {
    const Eigen::VectorXd at = (n.transpose() * centres).transpose();
    for (int k = 1; k <= kCuts; ++k) {
      const double plane = at.minCoeff() + (at.maxCoeff() - at.minCoeff()) * k / (kCuts + 1.0);
      std::array<std::vector<Eigen::Index>, 2> sides;
      for (Eigen::Index i = 0; i < at.size(); ++i)
        sides[at[i] < plane ? 0 : 1].push_back(part.triangles[static_cast<std::size_t>(i)]);
      if (sides[0].empty() || sides[1].empty()) continue;
      for (const std::size_t first : {0U, 1U}) {
        Cut cut = cut_in_two(surface, sides[first], sides[1 - first]);
        cut.saved = volume(part.capsule) - volume(cut.one.capsule) - volume(cut.other.capsule);
        if (cut.saved > (best ? best->saved : kWorth * volume(part.capsule))) best = std::move(cut);
      }
    }
  }
  return best;
}

/// Hands over what lies in another part's capsule, too, where this makes the own one smaller.
bool reassign_triangles(const Surface& surface, std::vector<Part>& parts, std::size_t from) {
  std::vector<Eigen::Index> kept;
  std::vector<std::pair<std::size_t, Eigen::Index>> given;
  for (const Eigen::Index t : parts[from].triangles) {
    std::size_t to = 0;
    while (to < parts.size() && (to == from || !holds(surface, parts[to].capsule, t))) ++to;
    if (to < parts.size())
      given.emplace_back(to, t);
    else
      kept.push_back(t);
  }
  if (given.empty() || kept.empty()) return false;
  Part smaller = make_part(surface, std::move(kept), true);
  if (volume(smaller.capsule) > kSmaller * volume(parts[from].capsule)) return false;
  parts[from] = std::move(smaller);
  for (const auto& [to, t] : given) parts[to].triangles.push_back(t);
  return true;
}

}  // namespace

std::vector<Capsule> cover_by_capsules(const Mesh& mesh, std::size_t max) {
  require(!mesh.faces.empty(), "a mesh without faces cannot be covered");
  require(max > 0, "no capsule covers a mesh");
  const double size = bounds(mesh).diagonal().norm();
  require(std::isfinite(size) && size > 0.0, "the mesh is ", size, " m across");
  const Surface surface = cut_up(mesh, kShare * size);
  std::vector<Eigen::Index> all(surface.triangles.size());
  std::iota(all.begin(), all.end(), Eigen::Index{0});

  std::vector<Part> parts{make_part(surface, std::move(all), true)};
  std::vector<std::optional<Cut>> cuts{best_cut(surface, parts.front())};
  while (parts.size() < max) {
    const auto less = [](const auto& x, const auto& y) {
      return (x ? x->saved : 0.0) < (y ? y->saved : 0.0);
    };
    const auto where = std::max_element(cuts.begin(), cuts.end(), less);
    if (!*where) break;
    Cut cut = *std::move(*where);
    const auto k = static_cast<std::size_t>(where - cuts.begin());
    parts[k] = make_part(surface, std::move(cut.one.triangles), true);
    cuts[k] = best_cut(surface, parts[k]);
    parts.push_back(make_part(surface, std::move(cut.other.triangles), true));
    cuts.push_back(best_cut(surface, parts.back()));
  }
  bool better = parts.size() > 1;
  for (int round = 0; better && round < kRounds; ++round) {
    better = false;
    for (std::size_t k = 0; k < parts.size(); ++k) better = reassign_triangles(surface, parts, k) || better;
  }
  std::vector<Capsule> capsules;
  for (const Part& part : parts) capsules.push_back(part.capsule);
  return capsules;
}

}  // namespace stonestack::geometry
