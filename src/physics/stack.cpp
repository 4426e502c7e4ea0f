#include "stonestack/physics/stack.hpp"

#include <algorithm>
#include <cmath>

#include "physics/shake.hpp"
#include "physics/touch.hpp"
#include "physics/world.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::physics {
namespace {

constexpr double kSample = 0.05;          // s, between checks of a stack that is judged
constexpr double kStillSeconds = 0.1;     // s, in which less motion than StandOptions::still is none
constexpr int kStill = 3;                 // samples without motion that end a verdict
constexpr double kFineStep = 0.001;       // s, while contacts for an equilibrium are found
constexpr double kSettle = 0.1;           // s, before they are collected, at most;
constexpr double kSettleCheck = 0.01;     // s, between checks whether
constexpr double kStackCalm = 0.0005;     // m/s, of any surface: less, twice running, is settled
constexpr int kCollect = 8;               // steps over which they are collected
constexpr double kCarries = 0.0003;       // m: contacts further apart carry nothing
constexpr std::size_t kMaxContacts = 16;  // of a pair

std::string named(const ShapeList& shapes, const Stack& stack, int level) {
  const PlacedStone& placed = stack.stones[static_cast<std::size_t>(level)];
  return concat("stone ", level, " (", at(shapes, placed.stone)->name, ")");
}

/// To two digits after the point, for texts.
double hundredths(double value) {
  return 0.01 * std::round(100.0 * value);
}

const ContactShape& shape_of(const ShapeList& shapes, const PlacedStone& placed) {
  return *at(shapes, placed.stone);
}

Surface surface_of(const ContactShape& shape) {
  return {shape.features.get(), &shape.distance, {}};
}

World world_of(const ShapeList& shapes, const Stack& stack, const WorldOptions& options, int held) {
  require(held >= 0 && static_cast<std::size_t>(held) <= stack.stones.size(), "of a stack of ",
          stack.stones.size(), " stones ", held, " cannot be held");
  World world(options);
  for (std::size_t i = 0; i < stack.stones.size(); ++i) {
    const PlacedStone& placed = stack.stones[i];
    static_cast<void>(shape_of(shapes, placed));
    world.add_stone(at(shapes, placed.stone), placed.T_W_O, static_cast<int>(i) < held);
  }
  return world;
}

/// A world as a verdict wants it, with the errors of centres of mass.
World judged_world(const ShapeList& shapes, const Stack& stack, const StandOptions& options) {
  WorldOptions settings;
  settings.friction = options.friction;
  settings.iterations = options.iterations;
  settings.step = options.step;
  World world = world_of(shapes, stack, settings, options.held);
  require(options.com_error_O.empty() || options.com_error_O.size() == stack.stones.size(), "errors of ",
          options.com_error_O.size(), " centres of mass for a stack of ", stack.stones.size());
  for (std::size_t i = 0; i < options.com_error_O.size(); ++i)
    world.set_weight_offset(static_cast<int>(i), options.com_error_O[i]);
  return world;
}

/// Some sample of X is nearer than `gap` to Y.
bool samples_near(const ContactShape& X, const Pose& T_W_X, const ContactShape& Y, const Pose& T_W_Y,
                  double gap) {
  const Pose T_Y_X = T_W_Y.inverse() * T_W_X;
  return std::any_of(X.samples.begin(), X.samples.end(), [&](const SurfaceSample& s) {
    const Eigen::Vector3d p = T_Y_X * s.point;
    return Y.features->box.exteriorDistance(p) < gap && Y.distance.distance(p) < gap;
  });
}

/// Names the two that touch and should not, of which the upper one is not held; empty for a clean stack.
/// `first`: the upper stone's level.
std::string unclean(const ShapeList& shapes, const Stack& stack, double gap, int held, int* first) {
  const auto n = static_cast<int>(stack.stones.size());
  for (int i = std::max(1, held); i < n; ++i) {
    const PlacedStone& upper = stack.stones[static_cast<std::size_t>(i)];
    const ContactShape& X = shape_of(shapes, upper);
    double low = 1e9;
    for (const auto& v : X.scan.vertices) low = std::min(low, (upper.T_W_O * v).z());
    *first = i;
    if (low < gap) return named(shapes, stack, i) + " touches the table";
    for (int j = 0; j + 1 < i; ++j) {
      const PlacedStone& lower = stack.stones[static_cast<std::size_t>(j)];
      const ContactShape& Y = shape_of(shapes, lower);
      const double apart = (upper.T_W_O * X.mass.p_O_M - lower.T_W_O * Y.mass.p_O_M).norm();
      if (apart > X.radius + Y.radius + gap) continue;
      if (samples_near(X, upper.T_W_O, Y, lower.T_W_O, gap) ||
          samples_near(Y, lower.T_W_O, X, upper.T_W_O, gap))
        return concat(named(shapes, stack, i), " touches ", named(shapes, stack, j));
    }
  }
  *first = n;
  return "";
}

Stack moved(const Stack& stack, const World& world) {
  Stack out = stack;
  for (std::size_t i = 0; i < out.stones.size(); ++i) out.stones[i].T_W_O = world.pose(static_cast<int>(i));
  return out;
}

/// Shift of the centre of mass and turn of a stone against where it was put.
PoseDifference moved_by(const ContactShape& shape, const Pose& before, const Pose& now) {
  PoseDifference d = difference(before, now);
  d.translation = (now * shape.mass.p_O_M - before * shape.mass.p_O_M).norm();
  return d;
}

/// Speed of the fastest surface of any stone, at most, m/s.
double speed(const ShapeList& shapes, const Stack& stack, const World& world) {
  double max = 0.0;
  for (std::size_t i = 0; i < stack.stones.size(); ++i) {
    const Twist twist = world.twist(static_cast<int>(i));
    max = std::max(max, twist.v.norm() + shape_of(shapes, stack.stones[i]).radius * twist.w.norm());
  }
  return max;
}

/// Largest motion of any stone's surface since the last check, m; the poses are kept for the next.
double motion(const ShapeList& shapes, const Stack& stack, const World& world, std::vector<Pose>& last) {
  double max = 0.0;
  for (std::size_t i = 0; i < last.size(); ++i) {
    const ContactShape& shape = shape_of(shapes, stack.stones[i]);
    const Pose now = world.pose(static_cast<int>(i));
    const auto d = moved_by(shape, last[i], now);
    max = std::max(max, d.translation + shape.radius * d.angle);
    last[i] = now;
  }
  return max;
}

}  // namespace

StandVerdict judge_stack(const ShapeList& shapes, const Stack& stack, const StandOptions& options) {
  World world = judged_world(shapes, stack, options);
  const auto n = static_cast<int>(stack.stones.size());
  StandVerdict verdict;
  int clean_levels = n;
  std::string fell, touches = unclean(shapes, stack, options.touch_gap, options.held, &clean_levels);
  verdict.clean = touches.empty();
  int stayed = n;  // levels from the bottom that stayed
  double end = options.seconds;
  std::vector<Pose> last;
  for (const PlacedStone& placed : stack.stones) last.push_back(placed.T_W_O);
  int still = 0;
  while (world.time() < end - 1e-9 && still < kStill) {
    throw_if_interrupted();
    world.run(std::min(kSample, end - world.time()));
    still = motion(shapes, stack, world, last) < options.still * kSample / kStillSeconds ? still + 1 : 0;
    int worst = -1;
    double excess = 1.0;
    for (int i = 0; i < n; ++i) {
      const PlacedStone& placed = stack.stones[static_cast<std::size_t>(i)];
      const auto d = moved_by(shape_of(shapes, placed), placed.T_W_O, world.pose(i));
      verdict.shift = std::max(verdict.shift, d.translation);
      verdict.turn = std::max(verdict.turn, d.angle);
      const double share = std::max(d.translation / options.max_shift, d.angle / options.max_turn);
      if (share > 1.0) stayed = std::min(stayed, i);
      if (share > excess) excess = share, worst = i;
    }
    if (worst < 0 || end < options.seconds) continue;
    end = std::min(end, world.time() + options.fall);
    fell = concat(named(shapes, stack, worst), " moved ", hundredths(1e3 * verdict.shift), " mm and turned ",
                  hundredths(verdict.turn * 180 / M_PI), " deg within ", hundredths(world.time()), " s");
  }
  if (verdict.clean && stayed == n) {
    touches = unclean(shapes, moved(stack, world), options.touch_gap, options.held, &clean_levels);
    verdict.clean = touches.empty();
  }
  verdict.stands = stayed == n;
  verdict.standing = std::min(stayed, clean_levels);
  for (int i = 0; i < n; ++i) verdict.T_W_O.push_back(world.pose(i));
  verdict.reason = fell + (fell.empty() || touches.empty() ? "" : "; ") + touches;
  return verdict;
}

int standing_when_shaken(const ShapeList& shapes, const Stack& stack, const StandOptions& options,
                         const Shake& shake) {
  auto standing = static_cast<int>(stack.stones.size());
  for (const Eigen::Index axis : {0, 1}) {
    throw_if_interrupted();
    World world = judged_world(shapes, stack, options);
    shake_world(world, shake, Eigen::Vector3d::Unit(axis), options.step);
    int clean = 0;
    static_cast<void>(unclean(shapes, moved(stack, world), options.touch_gap, options.held, &clean));
    standing = std::min(standing, clean);
  }
  return standing;
}

std::vector<Contact> geometric_contacts(const ShapeList& shapes, const Stack& stack, double gap) {
  std::vector<Contact> out;
  const auto add = [&](int below, int above, std::vector<Touch> touches) {
    std::erase_if(touches, [&](const Touch& t) { return t.gap > gap; });
    reduce(touches, {}, kMaxContacts);
    for (const Touch& t : touches) out.push_back({below, above, t.p_W, t.n_W, t.gap, 0.0});
  };
  for (std::size_t i = 0; i < stack.stones.size(); ++i) {
    const PlacedStone& upper = stack.stones[i];
    const Surface X = surface_of(shape_of(shapes, upper));
    add(kTable, static_cast<int>(i), TablePairs().touches(X, upper.T_W_O));
    for (std::size_t j = 0; j < i; ++j) {
      const PlacedStone& lower = stack.stones[j];
      const Surface Y = surface_of(shape_of(shapes, lower));
      add(static_cast<int>(j), static_cast<int>(i), FeaturePairs().touches(X, Y, upper.T_W_O, lower.T_W_O));
    }
  }
  return out;
}

StackStatics stack_statics(const ShapeList& shapes, const Stack& stack, double friction, int held) {
  WorldOptions settings;
  settings.friction = friction;
  settings.iterations = 200;
  settings.contact_gap = kCarries;
  settings.step = kFineStep;
  World world = world_of(shapes, stack, settings, held);
  for (int calm = 0; calm < 2 && world.time() < kSettle - 1e-9;) {
    world.run(kSettleCheck);
    calm = speed(shapes, stack, world) < kStackCalm ? calm + 1 : 0;
  }
  StackStatics statics;
  for (int i = 0; i < kCollect; ++i) {
    world.step();
    for (Contact contact : world.contacts()) {
      if (contact.above < held) continue;
      contact.above -= held;
      contact.below = contact.below < held ? kTable : contact.below - held;
      statics.contacts.push_back(contact);
    }
  }
  for (auto i = static_cast<std::size_t>(held); i < stack.stones.size(); ++i) {
    const MassProperties& mass = shape_of(shapes, stack.stones[i]).mass;
    statics.bodies.push_back({mass.mass, world.pose(static_cast<int>(i)) * mass.p_O_M});
  }
  return statics;
}

Equilibrium stack_equilibrium(const ShapeList& shapes, const Stack& stack, const EquilibriumOptions& options,
                              int held) {
  const StackStatics statics = stack_statics(shapes, stack, options.friction, held);
  return solve_equilibrium(statics.bodies, statics.contacts, options);
}

}  // namespace stonestack::physics
