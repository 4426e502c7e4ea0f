#include "search/find_stack.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "detection/scene/preprocess.hpp"
#include "physics/shape.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::search {
namespace {

constexpr double kOnTable = 0.012;  // m: lower than this, a stone lies on the table
constexpr double kTouch = 0.006;    // m between surfaces: measured poses err by 1 to 3 mm each
constexpr double kCarries = 0.3;    // z of the carrier's mean normal where it is touched
constexpr double kAtSite = 0.12;    // m from the site to the centre of mass of a tower's lowest stone
constexpr double kFingers = 0.03;   // m beside a stone for the gripper's fingers
constexpr double kInView = 0.8;     // share of the cells below a stone in which the table is seen
constexpr double kOwn = 0.010;      // m from a stone's surface within which seen surface is its own
constexpr double kLinked = 0.012;   // m between points of one thing
constexpr int kThing = 20;          // cubes of 5 mm at least: 5 cm2; a stone shows 40 to 150 cm2
constexpr double kOver = 0.006;     // m beside a stone's outline, seen from above, that count as over it
constexpr int kPointsOver = 6;      // of a thing that lies over a stone, at least

/// A stone where it was seen.
struct Body {
  PlacedStone placed;
  const ContactShape* shape = nullptr;
  Eigen::Vector3d p_W_com = Eigen::Vector3d::Zero();
  double lowest = 0.0;        // m above the table
  std::vector<int> carriers;  // indices of bodies
  std::vector<int> loads;     // of bodies that lie on it
  bool covered = false;       // an unknown thing lies over it

  [[nodiscard]] bool unsupported() const { return lowest >= kOnTable && carriers.empty(); }
};

std::vector<Body> bodies_of(const ShapeList& shapes, const std::vector<PlacedStone>& stones) {
  std::vector<Body> bodies;
  for (const PlacedStone& placed : stones) {
    require(placed.stone.is_within(shapes.size()) && at(shapes, placed.stone) != nullptr, "stone index ",
            placed.stone, " is not one of ", shapes.size(), " shapes");
    Body body;
    body.placed = placed;
    body.shape = at(shapes, placed.stone).get();
    body.p_W_com = placed.T_W_O * body.shape->mass.p_O_M;
    body.lowest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& v : body.shape->scan.vertices)
      body.lowest = std::min(body.lowest, (placed.T_W_O * v).z());
    bodies.push_back(std::move(body));
  }
  return bodies;
}

bool carries(const Body& lower, const Body& upper) {
  if (upper.p_W_com.z() <= lower.p_W_com.z() ||
      (upper.p_W_com - lower.p_W_com).norm() > upper.shape->radius + lower.shape->radius + kTouch)
    return false;
  const Pose T_L_U = lower.placed.T_W_O.inverse() * upper.placed.T_W_O;
  Eigen::Vector3d normal_L = Eigen::Vector3d::Zero();
  for (const SurfaceSample& sample : upper.shape->samples) {
    Eigen::Vector3d outwards = Eigen::Vector3d::Zero();
    if (lower.shape->distance.distance(T_L_U * sample.point, &outwards) < kTouch) normal_L += outwards;
  }
  if (normal_L.isZero()) return false;
  return (lower.placed.T_W_O.linear() * normal_L.normalized()).z() > kCarries;
}

/// Sets what carries what. A stone that lies on one that lies on a third is carried by the second alone,
/// though the third may come within `kTouch` of it.
void link(std::vector<Body>& bodies) {
  const auto count = static_cast<int>(bodies.size());
  const auto at = [&](int i) -> Body& { return bodies[static_cast<std::size_t>(i)]; };
  const auto holds = [](const std::vector<int>& list, int i) {
    return std::find(list.begin(), list.end(), i) != list.end();
  };
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < count; ++k)
      if (i != k && carries(at(i), at(k))) at(k).carriers.push_back(i);
  std::vector<std::vector<int>> direct;
  for (const Body& body : bodies) {
    auto& list = direct.emplace_back();
    for (const int i : body.carriers)
      if (std::none_of(body.carriers.begin(), body.carriers.end(),
                       [&](int between) { return holds(at(between).carriers, i); }))
        list.push_back(i);
  }
  for (int k = 0; k < count; ++k) {
    at(k).carriers = direct[static_cast<std::size_t>(k)];
    for (const int i : at(k).carriers) at(i).loads.push_back(k);
  }
}

/// The chain of stones from the table up that begins with `base`; empty where stones lie upon it otherwise.
std::vector<int> tower_on(const std::vector<Body>& bodies, int base) {
  std::vector<int> chain{base};
  while (true) {
    const Body& top = bodies[static_cast<std::size_t>(chain.back())];
    if (top.loads.empty()) return chain;
    const Body& next = bodies[static_cast<std::size_t>(top.loads.front())];
    if (top.loads.size() > 1 || next.carriers.size() > 1 || next.lowest < kOnTable) return {};
    chain.push_back(top.loads.front());  // each is higher than the one before: this ends
  }
}

/// Bodies that may be the lowest of a tower.
std::vector<int> bases_of(const std::vector<Body>& bodies) {
  std::vector<int> bases;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (bodies[i].lowest < kOnTable && bodies[i].carriers.empty()) bases.push_back(static_cast<int>(i));
  return bases;
}

/// Stones at a site.
struct SiteTower {
  std::vector<int> bodies;  ///< from the table up
  std::string note;         ///< why the stones there are no tower
};

SiteTower tower_at(const std::vector<Body>& bodies, const Eigen::Vector2d& site) {
  int base = -1;
  double nearest = kAtSite;
  for (const int i : bases_of(bodies)) {
    const double away = (bodies[static_cast<std::size_t>(i)].p_W_com.head<2>() - site).norm();
    if (away < nearest) base = i, nearest = away;
  }
  if (base < 0) return {};
  SiteTower tower{tower_on(bodies, base), ""};
  if (tower.bodies.empty())
    tower.note = concat("the stones on ", bodies[static_cast<std::size_t>(base)].shape->name,
                        " at the site are no tower, one stone upon the other");
  return tower;
}

std::vector<int> highest_tower(const std::vector<Body>& bodies) {
  std::vector<int> highest;
  double top = 0.0;
  for (const int base : bases_of(bodies)) {
    const std::vector<int> tower = tower_on(bodies, base);
    if (tower.size() < 2) continue;
    const double z = bodies[static_cast<std::size_t>(tower.back())].p_W_com.z();
    if (std::pair(tower.size(), z) > std::pair(highest.size(), top)) highest = tower, top = z;
  }
  return highest;
}

bool is_own(const Body& body, const Eigen::Vector3d& p_W) {
  if ((p_W - body.p_W_com).norm() > body.shape->radius + kOwn) return false;
  return body.shape->distance.distance(body.placed.T_W_O.inverse() * p_W) < kOwn;
}

/// Number of `points` that lie over a body: beside none of its surface, seen from above, and higher than it
/// there.
int points_over(const Body& body, const std::vector<Eigen::Vector3d>& points) {
  std::vector<Eigen::Vector3d> surface_W;
  for (const SurfaceSample& sample : body.shape->samples)
    surface_W.push_back(body.placed.T_W_O * sample.point);
  int over = 0;
  for (const Eigen::Vector3d& p : points) {
    if ((p - body.p_W_com).head<2>().norm() > body.shape->radius + kOver) continue;
    bool beside = true;
    double top = 0.0;
    for (const Eigen::Vector3d& q : surface_W)
      if ((p - q).head<2>().squaredNorm() < kOver * kOver) beside = false, top = std::max(top, q.z());
    over += !beside && p.z() > top ? 1 : 0;
  }
  return over;
}

/// Things among `seen_W` that no body explains, the one with the most surface first, and which body each lies
/// over.
std::vector<UnknownThing> unknown_things(std::vector<Body>& bodies,
                                         const std::vector<Eigen::Vector3d>& seen_W) {
  std::vector<Eigen::Vector3f> rest;
  for (const Eigen::Vector3d& p : seen_W)
    if (std::none_of(bodies.begin(), bodies.end(), [&](const Body& body) { return is_own(body, p); }))
      rest.push_back(p.cast<float>());
  const std::vector<int> group = cluster_points(rest, static_cast<float>(kLinked), kThing);
  std::vector<std::vector<Eigen::Vector3d>> things;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (group[i] < 0) continue;
    things.resize(std::max(things.size(), static_cast<std::size_t>(group[i]) + 1));
    things[static_cast<std::size_t>(group[i])].push_back(rest[i].cast<double>());
  }
  std::vector<UnknownThing> unknown;
  for (const auto& points : things) {
    UnknownThing thing;
    for (const Eigen::Vector3d& p : points) {
      thing.p_W += p.head<2>() / static_cast<double>(points.size());
      thing.highest = std::max(thing.highest, p.z());
    }
    int max = kPointsOver - 1;
    for (std::size_t i = 0; i < bodies.size(); ++i)
      if (const int over = points_over(bodies[i], points); over > max)
        max = over, thing.on = static_cast<int>(i);
    if (thing.on >= 0) bodies[static_cast<std::size_t>(thing.on)].covered = true;
    thing.surface_W = points;
    unknown.push_back(std::move(thing));
  }
  return unknown;
}

std::string place(const Eigen::Vector2d& p_W) {
  return concat('(', 1e-2 * std::round(1e2 * p_W.x()), ", ", 1e-2 * std::round(1e2 * p_W.y()), ") m");
}

/// Reason why what was found is not all of a tower; empty where it may be. With a site only what may belong
/// to the tower there counts.
std::string missing_part(const std::vector<Body>& bodies, const std::vector<UnknownThing>& unknown,
                         const std::optional<Eigen::Vector2d>& site) {
  const auto counts = [&](const Eigen::Vector2d& p_W, double radius) {
    return !site || (p_W - *site).norm() < kAtSite + radius;
  };
  for (const Body& body : bodies)
    if (body.unsupported() && counts(body.p_W_com.head<2>(), body.shape->radius))
      return concat(body.shape->name, " lies ", std::round(1e3 * body.lowest), " mm above the table at ",
                    place(body.p_W_com.head<2>()), ", and no stone that was recognised carries it");
  for (const UnknownThing& thing : unknown) {
    if (!counts(thing.p_W, 0.0)) continue;
    if (thing.on >= 0)
      return concat("something on ", bodies[static_cast<std::size_t>(thing.on)].shape->name, " at ",
                    place(thing.p_W), " was not recognised");
    return concat("something at ", place(thing.p_W), ", ", std::round(1e3 * thing.highest),
                  " mm high, was not recognised and may be part of a tower");
  }
  return {};
}

/// Surface points of stones, seen from above.
std::vector<Eigen::Vector2d> outlines(const std::vector<Body>& bodies) {
  std::vector<Eigen::Vector2d> points;
  for (const Body& body : bodies)
    for (const SurfaceSample& sample : body.shape->samples)
      points.push_back((body.placed.T_W_O * sample.point).head<2>());
  return points;
}

/// Share of the disc about `p` in which the bare table is seen.
double share_in_view(const std::set<std::pair<int, int>>& cells, double cell, const Eigen::Vector2d& p,
                     double radius) {
  int seen = 0, all = 0;
  const int reach = static_cast<int>(std::ceil(radius / cell));
  const int i0 = static_cast<int>(std::floor(p.x() / cell)), k0 = static_cast<int>(std::floor(p.y() / cell));
  for (int i = -reach; i <= reach; ++i)
    for (int k = -reach; k <= reach; ++k) {
      if (cell * std::hypot(i, k) > radius) continue;
      ++all;
      seen += cells.contains({i0 + i, k0 + k}) ? 1 : 0;
    }
  return static_cast<double>(seen) / all;
}

}  // namespace

SortedStones find_stack(const ShapeList& shapes, const std::vector<PlacedStone>& stones,
                        const std::optional<Eigen::Vector2d>& site,
                        const std::vector<Eigen::Vector3d>& seen_W) {
  std::vector<Body> bodies = bodies_of(shapes, stones);
  link(bodies);
  const auto [tower, note] = site ? tower_at(bodies, *site) : SiteTower{highest_tower(bodies), ""};
  SortedStones sorted;
  sorted.note = note;
  sorted.unknown = unknown_things(bodies, seen_W);
  for (const int i : tower) sorted.stack.push_back(bodies[static_cast<std::size_t>(i)].placed);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = bodies[i];
    if (std::find(tower.begin(), tower.end(), static_cast<int>(i)) != tower.end()) continue;
    const bool free = body.loads.empty() && !body.covered;
    auto& list = body.unsupported() ? sorted.unsupported : free ? sorted.available : sorted.carrying;
    list.push_back(body.placed);
  }
  if (sorted.note.empty()) sorted.note = missing_part(bodies, sorted.unknown, site);
  return sorted;
}

std::optional<Eigen::Vector2d> choose_site(const ShapeList& shapes, const std::vector<PlacedStone>& stones,
                                           const std::vector<PlacedStone>& available,
                                           const std::vector<Eigen::Vector2d>& table_W, double cell,
                                           const Eigen::Vector2d& p_W_middle) {
  require(cell > 0.0, "a cell of the table must have a width, got ", cell, " m");
  double radius = 0.0;  // of the widest stone that may go there
  for (const Body& body : bodies_of(shapes, available)) radius = std::max(radius, body.shape->radius);
  const std::vector<Eigen::Vector2d> outline = outlines(bodies_of(shapes, stones));
  std::set<std::pair<int, int>> cells;
  for (const Eigen::Vector2d& p : table_W)
    cells.emplace(static_cast<int>(std::floor(p.x() / cell)), static_cast<int>(std::floor(p.y() / cell)));
  const double wanted = radius + kFingers;
  std::optional<Eigen::Vector2d> best;
  std::pair<double, double> best_worth;  // clearance as far as it is wanted, then nearness to the middle
  for (const Eigen::Vector2d& p : table_W) {
    if (share_in_view(cells, cell, p, radius) < kInView) continue;
    double clearance = wanted;
    for (const Eigen::Vector2d& q : outline) clearance = std::min(clearance, (p - q).norm());
    if (clearance < radius) continue;
    const std::pair<double, double> worth(clearance, -(p - p_W_middle).norm());
    if (!best || worth > best_worth) best = p, best_worth = worth;
  }
  return best;
}

}  // namespace stonestack::search
