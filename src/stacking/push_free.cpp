#include "stacking/push_free.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/constants.hpp"
#include "geometry/footprint.hpp"

namespace stonestack::stacking {
namespace {

using geometry::Polygon2;

constexpr int kPushDirections = 16;                         // about the vertical
constexpr std::array kPushLengths{0.03, 0.05, 0.08, 0.12};  // m
constexpr double kPathStep = 0.005;                         // m, along a push
constexpr double kPastOthers = 0.004;  // m, between footprints, or as much as there is at the start
constexpr double kForFingers = 0.03;   // m beside a stone: more helps no finger
/// A pushed stone turns until both fingers touch it: 90 % of 33 pushes by less, 95 % by 0.52 rad (poses in
/// the journals of the rocks in `lab`, docs/results.md).
constexpr double kPushTurn = 0.45;  // rad, about the vertical
constexpr double kAway = 0.7;  // cosine of the angle between a push and straight away from a stacked stone
constexpr double kGripperRadius =
    0.02;                           // m: closed, at the finger tips, at least; motions are planned exactly
constexpr double kOffStack = 0.01;  // m, where a stone leans on nothing any more
constexpr double kFromSite = 0.2;   // m, that a push does not bring a stone nearer to the site than
constexpr double kInField = 0.8;    // of the field, about its middle
constexpr double kLowest = 0.005;   // m: what is lower does not stand beside a stone
constexpr double kOverhead = 0.25;  // m: nor does what begins higher
constexpr std::size_t kTriedPushes = 16, kOfferedPushes = 6;

Polygon2 shifted(Polygon2 polygon, const Eigen::Vector2d& by) {
  for (Eigen::Vector2d& p : polygon) p += by;
  return polygon;
}

Polygon2 turned(Polygon2 polygon, const Eigen::Vector2d& about, double angle) {
  for (Eigen::Vector2d& p : polygon) p = about + Eigen::Rotation2Dd(angle) * (p - about);
  return polygon;
}

/// Distance between convex outlines [m]; not positive where they overlap.
double distance_between(const Polygon2& a, const Polygon2& b) {
  double nearest = 1.0;
  for (const Eigen::Vector2d& p : a) nearest = std::min(nearest, -geometry::margin(b, p));
  for (const Eigen::Vector2d& p : b) nearest = std::min(nearest, -geometry::margin(a, p));
  return nearest;
}

/// Outlines of things on the table beside one loose stone, from above: all of it, and the stones of the
/// stack.
struct Beside {
  std::vector<Polygon2> all, stack;
};

Beside outlines_beside(const Situation& s, StoneIndex stone) {
  Beside beside;
  const auto outline = [&](const PlacedStone& other) {
    return geometry::footprint(s.models.stone(other.stone).pieces, other.T_W_O);
  };
  for (const PlacedStone& other : s.arrangement.stack) beside.stack.push_back(outline(other));
  std::vector<Polygon2>& others = beside.all = beside.stack;
  for (const PlacedStone& other : s.arrangement.loose)
    if (other.stone != stone) others.push_back(outline(other));
  for (const Obstacle& obstacle : s.world.layout.obstacles) {
    double low = kOverhead, high = 0.0;
    for (const Mesh& piece : obstacle.pieces)
      for (const Eigen::Vector3d& p : piece.vertices) {
        low = std::min(low, (obstacle.T_W_O * p).z());
        high = std::max(high, (obstacle.T_W_O * p).z());
      }
    if (low < kOverhead && high > kLowest)
      others.push_back(geometry::footprint(obstacle.pieces, obstacle.T_W_O));
  }
  return beside;
}

/// A shift of a stone over the table on which it meets nothing.
struct FreeShift {
  Eigen::Vector2d p_W_shift = Eigen::Vector2d::Zero();  ///< how far and where to [m]
  double clearance = 0.0;                               ///< at its end [m], as far as it helps the fingers
  bool off_stack = true;                                ///< even if the stone turns
};

/// Does the stone keep its distance from the others all the way? What it nearly touches it may slide along,
/// not be pushed against.
std::optional<double> clearance_after(const Polygon2& print, const std::vector<Polygon2>& others,
                                      const Eigen::Vector2d& p_W_shift) {
  double clearance = kForFingers;
  const Eigen::Vector2d middle = geometry::centroid(print);
  const int steps = static_cast<int>(std::ceil(p_W_shift.norm() / kPathStep));
  for (const Polygon2& other : others) {
    const double before = distance_between(print, other);
    if (before > p_W_shift.norm() + kForFingers) continue;
    const bool beside = before < kPastOthers;
    if (beside && p_W_shift.dot(middle - geometry::centroid(other)) < 0.0) return std::nullopt;
    for (int k = 1; k <= steps; ++k) {
      const double now = distance_between(shifted(print, p_W_shift * k / steps), other);
      if (now < kPastOthers && !beside) return std::nullopt;
      if (k == steps) clearance = std::min(clearance, now);
    }
  }
  return clearance;
}

/// Would the stone, turned by the fingers as far as stones turn, keep off the stack all the way? What it jams
/// against takes as much force as the stone itself, and a stack that gives way is not felt.
bool keeps_off_stack(const Polygon2& print, const std::vector<Polygon2>& stack, const Eigen::Vector2d& p_W_M,
                     const Eigen::Vector2d& p_W_shift) {
  const int steps = static_cast<int>(std::ceil(p_W_shift.norm() / kPathStep));
  double radius = 0.0;
  for (const Eigen::Vector2d& p : print) radius = std::max(radius, (p - p_W_M).norm());
  const double reach = p_W_shift.norm() + radius * kPushTurn + kPastOthers;
  return std::all_of(stack.begin(), stack.end(), [&](const Polygon2& other) {
    if (distance_between(print, other) > reach) return true;
    const Eigen::Vector2d away = p_W_M - geometry::centroid(other);
    if (p_W_shift.dot(away) > kAway * p_W_shift.norm() * away.norm()) return true;
    for (const double angle : {-kPushTurn, kPushTurn}) {
      const Polygon2 there = turned(print, p_W_M, angle);
      for (int k = 1; k <= steps; ++k)
        if (distance_between(shifted(there, p_W_shift * k / steps), other) < kPastOthers) return false;
    }
    return true;
  });
}

/// Is there room for the closed gripper behind the stone?
bool has_room_behind(const Polygon2& print, const std::vector<Polygon2>& others, const Eigen::Vector2d& n_W,
                     const Eigen::Vector2d& p_W_M) {
  double back = 0.0;
  for (const Eigen::Vector2d& p : print) back = std::max(back, n_W.dot(p_W_M - p));
  const Eigen::Vector2d gripper = p_W_M - (back + kGripperRadius) * n_W;
  return std::all_of(others.begin(), others.end(), [&](const Polygon2& other) {
    return -geometry::margin(other, gripper) > kGripperRadius;
  });
}

/// Free shifts: first those that keep off the stack, of these the one with most room at its end, of equal
/// ones the shortest.
std::vector<FreeShift> free_shifts(const Situation& s, const PlacedStone& stone) {
  const CellLayout& layout = s.world.layout;
  const Polygon2 print = geometry::footprint(s.models.stone(stone.stone).pieces, stone.T_W_O);
  const Beside beside = outlines_beside(s, stone.stone);
  const Eigen::Vector2d p_W_M = com_of(s.models.shapes, stone).head<2>();
  const auto off_middle = [&](const Eigen::Vector2d& p_W) {
    return (p_W - layout.field_centre)
        .cwiseAbs()
        .cwiseQuotient(0.5 * kInField * layout.field_size)
        .maxCoeff();
  };
  std::vector<FreeShift> shifts;
  for (const double length : kPushLengths)
    for (int k = 0; k < kPushDirections; ++k) {
      const double azimuth = kTwoPi * k / kPushDirections;
      const Eigen::Vector2d shift = length * Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
      const Eigen::Vector2d end = p_W_M + shift;
      if (!has_room_behind(print, beside.all, shift / length, p_W_M)) continue;
      if (off_middle(end) > std::max(1.0, off_middle(p_W_M))) continue;
      if ((end - layout.site).norm() < std::min(kFromSite, (p_W_M - layout.site).norm())) continue;
      if (const auto clearance = clearance_after(print, beside.all, shift))
        shifts.push_back({shift, *clearance, keeps_off_stack(print, beside.stack, p_W_M, shift)});
    }
  std::stable_sort(shifts.begin(), shifts.end(), [](const FreeShift& a, const FreeShift& b) {
    return a.off_stack != b.off_stack ? a.off_stack : a.clearance > b.clearance;
  });
  return shifts;
}

PlacedStone moved(const PlacedStone& stone, const Eigen::Vector2d& p_W_shift) {
  return {stone.stone, Eigen::Translation3d(p_W_shift.x(), p_W_shift.y(), 0.0) * stone.T_W_O};
}

Reach reach_of(const Situation& s, const Arrangement& arrangement) {
  return {arrangement, make_planning_scene(s.world.layout, *s.models.robot, *s.models.catalogue, arrangement),
          *s.models.catalogue, s.options.motion};
}

Arrangement with(Arrangement arrangement, const PlacedStone& there) {
  for (PlacedStone& stone : arrangement.loose)
    if (stone.stone == there.stone) stone = there;
  return arrangement;
}

Arrangement without(Arrangement arrangement, StoneIndex gone) {
  std::erase_if(arrangement.loose, [&](const PlacedStone& stone) { return stone.stone == gone; });
  return arrangement;
}

/// Would a grasp of the stone serve in that arrangement?
bool is_held(const Situation& s, const Arrangement& then, StoneIndex stone) {
  return !reach_of(s, then).at_pick(stone).usable.empty();
}

/// The gripper could hold it as it lies, but something stands beside it.
bool is_blocked(const GraspCheck& at_pick) {
  return at_pick.usable.empty() && at_pick.can_be_held() &&
         at_pick.refused[static_cast<std::size_t>(GraspFault::kObjectAtPick)] > 0;
}

/// As often between two placements as stones may be reoriented in a run: both bring a stone to where a grasp
/// serves.
bool may_push(const Situation& s, const RunMemory& memory, StoneIndex stone) {
  return memory.pushed < s.options.max_reoriented && !memory.not_pushed.contains(stone);
}

/// Shifts of one loose stone after which a grasp of another, or of itself, serves: those that keep off the
/// stack, or where there are none the others.
std::vector<FreeShift> shifts_that_free(const Situation& s, const PlacedStone& pushed, StoneIndex freed) {
  std::vector<FreeShift> shifts;
  std::size_t tried = 0;
  for (const FreeShift& shift : free_shifts(s, pushed)) {
    if (shifts.size() >= kOfferedPushes || tried >= kTriedPushes) break;
    if (!shifts.empty() && shifts.front().off_stack != shift.off_stack) break;
    ++tried;
    if (is_held(s, with(s.arrangement, moved(pushed, shift.p_W_shift)), freed)) shifts.push_back(shift);
  }
  return shifts;
}

/// Loose stones that the gripper could hold but for what stands beside them.
std::vector<PlacedStone> blocked_stones(const Situation& s) {
  std::vector<PlacedStone> list;
  for (const PlacedStone& stone : s.arrangement.loose)
    if (at(s.models.unfit, stone.stone).empty() && is_blocked(s.reach->at_pick(stone.stone)))
      list.push_back(stone);
  return list;
}

/// The first push that is offered of those that keep off the stack; if there is none, of all.
class FirstPush {
 public:
  /// Offers pushes of a stone. True where one of them keeps off the stack: no other is needed.
  bool offer(const PlacedStone& pushed, const std::vector<FreeShift>& shifts) {
    if (shifts.empty() || (push_ && !shifts.front().off_stack)) return false;
    push_ = Push{pushed, {}};
    for (const FreeShift& shift : shifts) push_->p_W_shifts.push_back(shift.p_W_shift);
    return shifts.front().off_stack;
  }
  [[nodiscard]] const std::optional<Push>& push() const { return push_; }

 private:
  std::optional<Push> push_;
};

}  // namespace

std::optional<Push> push_free(const Situation& s, const RunMemory& memory, Neighbours neighbours) {
  const std::vector<PlacedStone> blocked = blocked_stones(s);
  FirstPush first;
  for (const PlacedStone& stone : blocked) {
    if (!may_push(s, memory, stone.stone)) continue;
    if (neighbours == Neighbours::kLasting &&
        !is_blocked(reach_of(s, {s.arrangement.stack, {stone}}).at_pick(stone.stone)))
      continue;
    if (first.offer(stone, shifts_that_free(s, stone, stone.stone))) return first.push();
  }
  if (neighbours == Neighbours::kLasting) return first.push();
  for (const PlacedStone& stone : blocked)  // a neighbour is pushed away from it
    for (const PlacedStone& other : s.arrangement.loose)
      if (other.stone != stone.stone && may_push(s, memory, other.stone) &&
          is_held(s, without(s.arrangement, other.stone), stone.stone) &&
          first.offer(other, shifts_that_free(s, other, stone.stone)))
        return first.push();
  return first.push();
}

std::optional<Push> push_off_stack(const Situation& s, const RunMemory& memory, const PlacedStone& stray) {
  if (!may_push(s, memory, stray.stone)) return std::nullopt;
  Push push{stray, {}};
  for (const FreeShift& shift : free_shifts(s, stray))
    if (shift.clearance > kOffStack && push.p_W_shifts.size() < kOfferedPushes)
      push.p_W_shifts.push_back(shift.p_W_shift);
  return push.p_W_shifts.empty() ? std::nullopt : std::optional(push);
}

}  // namespace stonestack::stacking
