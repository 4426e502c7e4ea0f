#include "stacking/arrangement.hpp"

#include <algorithm>

#include "stacking/settle_stack.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kAboveTable = 0.012;  // m: lower than this, a stone lies on the table
constexpr double kFloats = 0.05;       // m above the table: higher, nothing loose can lie
constexpr double kWithin = 0.006;      // m
constexpr double kTouches = 0.003;     // m: a loose stone that near to the stack touches it
constexpr double kApart = 0.006;  // m: planned as far from loose stones, for poses err by as much as kTouches
constexpr double kBaseAtSite = 0.12;  // m: the first stone lies no further from the site

const ContactShape& shape_of(const ShapeList& shapes, StoneIndex stone) {
  return *at(shapes, stone);
}

std::vector<Sighting>::iterator find(std::vector<Sighting>& sightings, StoneIndex stone) {
  return std::find_if(sightings.begin(), sightings.end(),
                      [&](const Sighting& s) { return s.stone == stone; });
}

/// May a stone lie loose at that pose: on the table, and not within the stack? Deeper than kWithin into a
/// stone of the stack, what was seen is a part of the stack taken for another stone.
bool may_lie_loose(const ShapeList& shapes, const std::vector<PlacedStone>& stack, const Sighting& seen) {
  const auto& shape = shape_of(shapes, seen.stone);
  if (lowest(shape, seen.T_W_O) > kFloats) return false;
  return std::none_of(stack.begin(), stack.end(), [&](const PlacedStone& placed) {
    const auto& other = shape_of(shapes, placed.stone);
    const Pose T_P_O = placed.T_W_O.inverse() * seen.T_W_O;
    return std::any_of(shape.samples.begin(), shape.samples.end(), [&](const SurfaceSample& sample) {
      return other.distance.distance(T_P_O * sample.point) < -kWithin;
    });
  });
}

bool in_place(const Sighting& seen, const StoneEstimate& expected) {
  const auto error = difference(seen.T_W_O, expected.T_W_O_at_rest);
  return error.translation < kConsistent && error.angle < kConsistentTurn;
}

/// Is a stone that was expected higher still up there: in place, or moved but resting over the hidden one?
bool something_stands_on(const ShapeList& shapes, const std::vector<Sighting>& sightings,
                         const std::vector<StoneEstimate>& expected, std::size_t hidden) {
  const PlacedStone below{expected[hidden].stone, expected[hidden].T_W_O_at_rest};
  for (std::size_t i = hidden + 1; i < expected.size(); ++i)
    for (const auto& seen : sightings) {
      if (seen.stone != expected[i].stone) continue;
      if (in_place(seen, expected[i]) || rests_over(shapes, {seen.stone, seen.T_W_O}, below)) return true;
    }
  return false;
}

/// Does a stone of a wall, which is hidden, carry one that is seen where it was?
bool carries_something(const ShapeList& shapes, const std::vector<Sighting>& sightings,
                       const std::vector<StoneEstimate>& expected, std::size_t hidden) {
  const PlacedStone below{expected[hidden].stone, expected[hidden].T_W_O_at_rest};
  return std::any_of(expected.begin(), expected.end(), [&](const StoneEstimate& upper) {
    return rests_over(shapes, {upper.stone, upper.T_W_O_at_rest}, below) &&
           std::any_of(sightings.begin(), sightings.end(), [&](const Sighting& seen) {
             return seen.stone == upper.stone && in_place(seen, upper);
           });
  });
}

/// The stack from the table up; what belongs to it is taken out of `left`.
std::vector<MeasuredStone> stack_in(const ShapeList& shapes, const Eigen::Vector2d& site,
                                    const std::vector<StoneEstimate>& expected,
                                    const std::function<bool(const PlacedStone&)>& refuted,
                                    std::vector<Sighting>& left) {
  std::vector<MeasuredStone> stack;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const StoneEstimate& before = expected[i];
    const auto found = find(left, before.stone);
    if (found == left.end()) {
      // Hidden, not recognised, or gone.
      if (!something_stands_on(shapes, left, expected, i) &&
          (!refuted || refuted({before.stone, before.T_W_O_at_rest})))
        break;
      stack.push_back({before, false});
      continue;
    }
    const PlacedStone measured{found->stone, found->T_W_O};
    const bool at_site = (measured.T_W_O.translation().head<2>() - site).norm() < kBaseAtSite;
    const bool belongs = stack.empty()
                             ? at_site
                             : rests_over(shapes, measured,
                                          {stack.back().estimate.stone, stack.back().estimate.T_W_O_at_rest});
    if (!belongs) break;
    const bool newest = i + 1 == expected.size();
    const auto above = newest ? left.end() : find(left, expected[i + 1].stone);
    const bool carries = above != left.end() && in_place(*above, expected[i + 1]);
    if (!newest && (carries || in_place(*found, before)))
      stack.push_back({before, false});
    else
      stack.push_back({{measured.stone, measured.T_W_O, measured.T_W_O}, true});
    left.erase(found);
  }
  return stack;
}

/// The stones of a wall, in the order in which they were built; what belongs to it is taken out of `left`. A
/// stone belongs to it where it was expected, nearly, or on one that does; one that is not seen, where
/// something still stands on it.
std::vector<MeasuredStone> wall_in(const ShapeList& shapes, const std::vector<StoneEstimate>& expected,
                                   std::vector<Sighting>& left, const BuildOptions& options) {
  std::vector<MeasuredStone> wall;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const StoneEstimate& before = expected[i];
    const auto found = find(left, before.stone);
    if (found == left.end()) {
      if (carries_something(shapes, left, expected, i)) wall.push_back({before, false});
      continue;
    }
    const PlacedStone measured{found->stone, found->T_W_O};
    const bool stays = same_place(shapes, measured, {before.stone, before.T_W_O_at_rest},
                                  options.placed_shift, options.placed_turn);
    const bool rests = std::any_of(wall.begin(), wall.end(), [&](const MeasuredStone& lower) {
      return rests_over(shapes, measured, {lower.estimate.stone, lower.estimate.T_W_O_at_rest});
    });
    if (!stays && !rests) continue;
    if (i + 1 < expected.size() && in_place(*found, before))
      wall.push_back({before, false});
    else
      wall.push_back({{measured.stone, measured.T_W_O, measured.T_W_O}, true});
    left.erase(found);
  }
  return wall;
}

}  // namespace

bool rests_over(const ShapeList& shapes, const PlacedStone& upper, const PlacedStone& below) {
  const auto& shape = shape_of(shapes, upper.stone);
  const auto& base = shape_of(shapes, below.stone);
  const Eigen::Vector3d com = upper.T_W_O * shape.mass.p_O_M;
  const Eigen::Vector3d com_below = below.T_W_O * base.mass.p_O_M;
  return lowest(shape, upper.T_W_O) > kAboveTable && com.z() > com_below.z() &&
         (com - com_below).head<2>().norm() < base.radius;
}

StoneEstimates estimate_stones(const ShapeList& shapes, const CellLayout& layout,
                               const std::vector<StoneEstimate>& expected,
                               const std::vector<Sighting>& sightings, const BuildOptions& options,
                               const std::function<bool(const PlacedStone&)>& refuted) {
  std::vector<Sighting> left = sightings;
  const bool tower = options.wall.empty();
  std::vector<MeasuredStone> measured = tower ? stack_in(shapes, layout.site, expected, refuted, left)
                                              : wall_in(shapes, expected, left, options);
  if (!options.measure_placed)
    for (MeasuredStone& stone : measured)
      for (const StoneEstimate& meant : expected)
        if (same_place(shapes, {stone.estimate.stone, stone.estimate.T_W_O_at_rest},
                       {meant.stone, meant.T_W_O_at_rest}, options.placed_shift, options.placed_turn))
          stone = {{meant.stone, stone.estimate.T_W_O_seen, meant.T_W_O_at_rest}, false};
  StoneEstimates estimates{settle_stack(shapes, measured, options.max_friction, tower), {}};
  std::vector<PlacedStone> stack;
  for (const StoneEstimate& stone : estimates.stack) stack.push_back({stone.stone, stone.T_W_O_at_rest});
  for (const auto& sighting : left)
    if (may_lie_loose(shapes, stack, sighting))
      estimates.loose.push_back({sighting.stone, sighting.T_W_O, sighting.T_W_O});
  std::sort(estimates.loose.begin(), estimates.loose.end(),
            [](const auto& a, const auto& b) { return a.stone < b.stone; });
  return estimates;
}

Arrangement sort_by_site(const ShapeList& shapes, const Eigen::Vector2d& site,
                         const std::vector<PlacedStone>& stones) {
  Arrangement arrangement{{}, stones};
  std::sort(arrangement.loose.begin(), arrangement.loose.end(),
            [&](const PlacedStone& a, const PlacedStone& b) {
              const double za = (a.T_W_O * shape_of(shapes, a.stone).mass.p_O_M).z();
              const double zb = (b.T_W_O * shape_of(shapes, b.stone).mass.p_O_M).z();
              return za != zb ? za < zb : a.stone < b.stone;
            });
  for (auto it = arrangement.loose.begin(); it != arrangement.loose.end();) {
    const bool near = (it->T_W_O.translation().head<2>() - site).norm() < kBaseAtSite;
    const bool stacked = arrangement.stack.empty() ? near : rests_over(shapes, *it, arrangement.stack.back());
    if (stacked) arrangement.stack.push_back(*it);
    it = stacked ? arrangement.loose.erase(it) : it + 1;
  }
  std::sort(arrangement.loose.begin(), arrangement.loose.end(),
            [](const auto& a, const auto& b) { return a.stone < b.stone; });
  return arrangement;
}

bool lie_within(const ShapeList& shapes, const PlacedStone& a, const PlacedStone& b, double gap) {
  const ContactShape &A = shape_of(shapes, a.stone), &B = shape_of(shapes, b.stone);
  if ((a.T_W_O * A.mass.p_O_M - b.T_W_O * B.mass.p_O_M).norm() > A.radius + B.radius + gap) return false;
  const auto reaches = [gap](const ContactShape& from, const ContactShape& to, const Pose& T_to_from) {
    return std::any_of(from.samples.begin(), from.samples.end(), [&](const SurfaceSample& s) {
      return to.distance.distance(T_to_from * s.point) < gap;
    });
  };
  const Pose T_B_A = b.T_W_O.inverse() * a.T_W_O;
  return reaches(A, B, T_B_A) || reaches(B, A, T_B_A.inverse());
}

bool leans_on_loose(const ShapeList& shapes, const std::vector<PlacedStone>& loose, const PlacedStone& placed,
                    const std::vector<PlacedStone>& below) {
  const auto is_placed = [&](StoneIndex stone) {
    return stone == placed.stone || std::any_of(below.begin(), below.end(), [&](const PlacedStone& lower) {
             return lower.stone == stone;
           });
  };
  return std::any_of(loose.begin(), loose.end(), [&](const PlacedStone& other) {
    return !is_placed(other.stone) && lie_within(shapes, other, placed, kApart);
  });
}

std::optional<Stray> stray_at_stack(const ShapeList& shapes, const Arrangement& arrangement) {
  for (std::size_t level = 0; level < arrangement.stack.size(); ++level)
    for (const PlacedStone& loose : arrangement.loose)
      if (lie_within(shapes, loose, arrangement.stack[level], kTouches)) return Stray{level, loose};
  return std::nullopt;
}

SceneObject unseen_field(const CellLayout& layout) {
  constexpr double kHeight = 0.25;  // m: the highest a stone of the field may reach
  const Eigen::Vector3d size(layout.field_size.x() + 0.2, layout.field_size.y() + 0.2, kHeight);
  return {"unseen field",
          {make_box(size)},
          make_pose({layout.field_centre.x(), layout.field_centre.y(), kHeight / 2})};
}

SceneObject unseen_site(const CellLayout& layout) {
  constexpr double kHeight = 0.45, kWidth = 0.20;  // m
  return {"unseen site",
          {make_box({kWidth, kWidth, kHeight})},
          make_pose({layout.site.x(), layout.site.y(), kHeight / 2})};
}

SiteStatus site_in(const Views& views, const Eigen::Vector2d& site) {
  constexpr double kRadius = 0.10;     // m about the site
  constexpr double kOnTable = 0.015;   // m: higher is something
  constexpr double kSomething = 8e-4;  // m^2 of it that count, seen along the camera's rays
  constexpr double kEnough = 0.6;      // of the circle, in all views together
  constexpr double kCell = 0.01;       // m
  constexpr int kStride = 2, kCells = static_cast<int>(2 * kRadius / kCell + 0.5);
  std::vector<bool> table(static_cast<std::size_t>(kCells * kCells), false);
  for (const CameraView& view : views) {
    const CameraIntrinsics& camera = view.image.camera;
    double above = 0.0;
    for (int v = 0; v < camera.height; v += kStride)
      for (int u = 0; u < camera.width; u += kStride) {
        const double z = view.image.at(u, v);
        if (!(z > 0.0)) continue;
        const Eigen::Vector3d p_W = view.T_W_C * Eigen::Vector3d(z * deproject(camera, u, v));
        const Eigen::Vector2d beside = p_W.head<2>() - site;
        if (!(beside.norm() < kRadius)) continue;  // also where it is no number
        if (p_W.z() > kOnTable) {
          above += kStride * kStride * z * z / (camera.fx * camera.fy);
          continue;
        }
        const Eigen::Vector2i cell = ((beside.array() + kRadius) / kCell).floor().cast<int>().min(kCells - 1);
        table[static_cast<std::size_t>(cell.y() * kCells + cell.x())] = true;
      }
    if (above > kSomething) return SiteStatus::kOccupied;
  }
  const double shown = kCell * kCell * static_cast<double>(std::count(table.begin(), table.end(), true));
  return shown > kEnough * M_PI * kRadius * kRadius ? SiteStatus::kFree : SiteStatus::kUnseen;
}

bool same_place(const ShapeList& shapes, const PlacedStone& a, const PlacedStone& b, double shift,
                double turn) {
  if (a.stone != b.stone) return false;
  const Eigen::Vector3d& p_O_M = shape_of(shapes, a.stone).mass.p_O_M;
  return (a.T_W_O * p_O_M - b.T_W_O * p_O_M).norm() <= shift && difference(a.T_W_O, b.T_W_O).angle <= turn;
}

double lowest(const ContactShape& shape, const Pose& T_W_O) {
  double z = 1e9;
  for (const auto& sample : shape.samples) z = std::min(z, (T_W_O * sample.point).z());
  return z;
}

double top_height(const ShapeList& shapes, const std::vector<PlacedStone>& stones) {
  double top = 0.0;
  for (const auto& placed : stones)
    for (const auto& sample : shape_of(shapes, placed.stone).samples)
      top = std::max(top, (placed.T_W_O * sample.point).z());
  return top;
}

PickAndPlaceTask make_task(const Catalogue& catalogue, const Arrangement& arrangement, StoneIndex stone,
                           const Pose& T_W_O, const Joints& q_start) {
  PickAndPlaceTask task;
  task.stone = &catalogue[stone];
  task.T_W_O_place = T_W_O;
  task.q_start = q_start;
  task.support = static_cast<int>(arrangement.stack.size()) - 1;
  for (std::size_t i = 0; i < arrangement.loose.size(); ++i) {
    if (arrangement.loose[i].stone != stone) continue;
    task.object = static_cast<int>(arrangement.stack.size() + i);
    task.T_W_O_pick = arrangement.loose[i].T_W_O;
    return task;
  }
  throw InvalidArgument(concat(task.stone->name, " is not among the loose stones"));
}

Arrangement at_rest(const WorldEstimate& world) {
  Arrangement arrangement;
  for (const StoneEstimate& stone : world.stack)
    arrangement.stack.push_back({stone.stone, stone.T_W_O_at_rest});
  for (const StoneEstimate& stone : world.loose)
    arrangement.loose.push_back({stone.stone, stone.T_W_O_at_rest});
  return arrangement;
}

std::vector<StoneEstimate> as_estimates(const std::vector<PlacedStone>& stones) {
  std::vector<StoneEstimate> estimates;
  for (const PlacedStone& stone : stones) estimates.push_back({stone.stone, stone.T_W_O, stone.T_W_O});
  return estimates;
}

bool holds(const std::vector<StoneEstimate>& stones, StoneIndex stone) {
  return std::any_of(stones.begin(), stones.end(), [&](const auto& s) { return s.stone == stone; });
}

int clean_height(const ShapeList& shapes, const Arrangement& arrangement) {
  const auto stray = stray_at_stack(shapes, arrangement);
  return static_cast<int>(stray ? stray->level + 1 : arrangement.stack.size());
}

Eigen::Vector3d com_of(const ShapeList& shapes, const PlacedStone& stone) {
  return stone.T_W_O * shape_of(shapes, stone.stone).mass.p_O_M;
}

}  // namespace stonestack::stacking
