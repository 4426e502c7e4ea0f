#include "search/wall/wall_state.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace stonestack::search {
namespace {

constexpr double kFirmEnough = 0.25;  // g: more is worth nothing more
constexpr double kCoverJoint =
    0.03;                            // m from a joint below to the end of a stone: more is worth nothing more
constexpr double kOffHeight = 0.03;  // m from the wanted height of the top that cost as much as all firmness
constexpr double kOffCentre = 0.04;  // m
constexpr double kOffGap = 0.05;     // m
constexpr double kOffAxis = 0.06;    // m
constexpr double kBroadTop =
    0.03;  // m from the centre of mass to the rim of the top: more is worth nothing more
constexpr double kSquare = 2.0;     // worth of an outline that fills the rectangle along and across the wall
constexpr double kTopSlope = 0.35;  // rad of the top's tilt that cost as much

/// Distance [m] along the wall from the joints below to the nearest end of a stone.
double joint_cover(const WallSlot& slot, const WallStonePlaced& placed) {
  double clear = kCoverJoint;
  for (const double joint : slot.joints)
    clear = std::min({clear, std::abs(placed.reach.min.x() - joint), std::abs(placed.reach.max.x() - joint)});
  return clear;
}

}  // namespace

int stones_asked(const WallTarget& target) {
  return std::accumulate(target.courses.begin(), target.courses.end(), 0);
}

Stack WallState::stack() const {
  Stack stack;
  for (const WallStonePlaced& placed : stones) stack.stones.push_back({placed.stone, placed.T_W_O});
  return stack;
}

bool WallState::holds(StoneIndex stone) const {
  return std::any_of(stones.begin(), stones.end(), [&](const auto& placed) { return placed.stone == stone; });
}

std::vector<int> WallState::course(int k) const {
  std::vector<int> list;
  for (std::size_t i = 0; i < stones.size(); ++i)
    if (stones[i].course == k) list.push_back(static_cast<int>(i));
  std::stable_sort(list.begin(), list.end(), [&](int a, int b) {
    return stones[static_cast<std::size_t>(a)].reach.min.x() <
           stones[static_cast<std::size_t>(b)].reach.min.x();
  });
  return list;
}

WallStonePlaced placed_in_wall(const WallStone& stone, const WallSide& side, const Eigen::Matrix3d& R_W_O,
                               const Eigen::Vector3d& p_W_com, int course) {
  WallStonePlaced placed;
  placed.stone = stone.stone;
  placed.T_W_O = stone_pose({stone.geometry, R_W_O, p_W_com});
  placed.course = course;
  placed.reach = extents_of(*stone.geometry, R_W_O);
  placed.reach.min += p_W_com.head<2>();
  placed.reach.max += p_W_com.head<2>();
  placed.square = side.outline / (placed.reach.max - placed.reach.min).prod();
  placed.top = p_W_com.z() + side.top.height;
  placed.breadth = side.top.margin;
  placed.level = (R_W_O * side.top.normal_O).z();
  return placed;
}

double worth_in_slot(const WallSlot& slot, const WallStonePlaced& placed, double firmness, double friction) {
  const double enough = std::min(kFirmEnough, friction);
  double worth = 2.0 * std::min(firmness / enough, 1.0);
  if (slot.carries) {
    worth -= std::acos(std::clamp(placed.level, -1.0, 1.0)) / kTopSlope;
    worth -= std::min(std::abs(placed.top - slot.top) / kOffHeight, 2.0);
    worth += std::min(placed.breadth, kBroadTop) / kBroadTop;
  }
  const Eigen::Vector2d middle = 0.5 * (placed.reach.min + placed.reach.max);
  worth -= std::abs(middle.y()) / kOffAxis;
  if (slot.centre) worth -= std::abs(middle.x() - *slot.centre) / kOffCentre;
  if (!slot.centre && std::isfinite(slot.from)) worth -= std::abs(placed.reach.min.x() - slot.from) / kOffGap;
  return worth + joint_cover(slot, placed) / kCoverJoint + kSquare * placed.square;
}

std::map<std::string, double> terms_in_slot(const WallSlot& slot, const WallStonePlaced& placed,
                                            double worth) {
  return {{"course", slot.course + 1},
          {"joint_cover", joint_cover(slot, placed)},
          {"fill", placed.square},
          {"off_height", slot.carries ? std::abs(placed.top - slot.top) : 0.0},
          {"off_axis", std::abs(0.5 * (placed.reach.min + placed.reach.max).y())},
          {"worth", worth}};
}

double common_thickness(const std::vector<WallStone>& stones, const WallState& state) {
  // For each height some side has: how many stones come near it, each by its best side.
  const auto fit = [](const WallSide& side, double height) {
    const double off = std::abs(side.on_table.height + side.top.height - height) / kOffHeight;
    const double slope = std::acos(std::clamp((side.R_W_O * side.top.normal_O).z(), -1.0, 1.0)) / kTopSlope;
    return std::max(0.0, 1.0 - off) * std::max(0.0, 1.0 - slope) * std::min(side.on_table.margin, 0.02) /
           0.02 * (0.2 + std::clamp(side.top.margin, 0.0, 0.02) / 0.02);
  };
  double best = 0.0, best_sum = -1.0;
  for (double height = 0.03; height < 0.25; height += 0.004) {
    double sum = 0.0;
    for (const WallStone& stone : stones) {
      if (state.holds(stone.stone)) continue;
      double max = 0.0;
      for (const WallSide& side : stone.sides) max = std::max(max, fit(side, height));
      sum += max;
    }
    if (sum > best_sum) best_sum = sum, best = height;
  }
  return best;
}

std::optional<WallSlot> next_slot(const WallTarget& target, const WallState& state,
                                  const std::function<double()>& thickness) {
  WallSlot slot;
  slot.joint_gap = target.joint_gap;
  const auto at = [&](int i) -> const WallStonePlaced& { return state.stones[static_cast<std::size_t>(i)]; };
  const int reached = state.stones.empty() ? 0 : state.stones.back().course;
  const std::vector<int> last = state.course(reached);
  const bool counted = !target.courses.empty();
  const int courses = counted ? static_cast<int>(target.courses.size()) : target.levels;
  bool full = false;
  if (counted) {
    if (state.stones.size() >= static_cast<std::size_t>(stones_asked(target))) return std::nullopt;
    full = last.size() >= static_cast<std::size_t>(target.courses[static_cast<std::size_t>(reached)]);
  } else if (!last.empty()) {
    const double end = reached == 0 ? at(last.front()).reach.min.x() + target.length : [&] {
      const std::vector<int> base = state.course(0);
      return at(base.back()).reach.max.x();
    }();
    const double typical = (at(last.back()).reach.max - at(last.back()).reach.min).x();
    full = at(last.back()).reach.max.x() > end - 0.5 * typical;
  }
  full = full || reached < state.closed;
  slot.course = full ? reached + 1 : reached;
  if (slot.course >= courses) return std::nullopt;
  slot.carries = slot.course + 1 < courses;
  const std::vector<int> own = full ? std::vector<int>() : last;
  const std::vector<int> below = slot.course == 0 ? std::vector<int>() : state.course(slot.course - 1);
  if (!own.empty()) slot.from = at(own.back()).reach.max.x();
  for (std::size_t k = 1; k < below.size(); ++k)
    slot.joints.push_back(0.5 * (at(below[k - 1]).reach.max.x() + at(below[k]).reach.min.x()));
  const std::vector<int>& level = own.empty() ? below : own;
  for (const int k : level) slot.top += at(k).top / static_cast<double>(level.size());
  if (own.empty()) slot.top += thickness();
  if (counted && slot.course > 0) {
    const int count = target.courses[static_cast<std::size_t>(slot.course)];
    const auto j = static_cast<double>(own.size());
    if (count + 1 == static_cast<int>(below.size())) {
      slot.centre = slot.joints[own.size()];
    } else {
      const double left = at(below.front()).reach.min.x(), right = at(below.back()).reach.max.x();
      slot.centre = left + (j + 0.5) / count * (right - left);
    }
  } else if (own.empty() && slot.course > 0) {
    slot.from = at(state.course(0).front()).reach.min.x();
  }
  return slot;
}

}  // namespace stonestack::search
