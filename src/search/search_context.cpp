#include "search/search_context.hpp"

#include <algorithm>
#include <cmath>

#include "search/orientations.hpp"
#include "search/resting_height.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/physics/settle.hpp"

namespace stonestack {
namespace {

constexpr double kStandSeconds = 2.0;
constexpr double kNearShift = 0.005;  ///< m
constexpr double kNearTurn = 0.0873;  ///< rad
constexpr double kOverlap = 0.008;    ///< m: deeper than any measurement error

/// True if some direction separates the point from every vertex: Frank and Wolfe's walk to the nearest point
/// of the hull.
bool outside_hull(const std::vector<Eigen::Vector3d>& vertices, const Eigen::Vector3d& p) {
  Eigen::Vector3d nearest = vertices.front();
  for (int k = 0; k < 300; ++k) {
    const Eigen::Vector3d direction = p - nearest;
    const auto furthest =
        std::max_element(vertices.begin(), vertices.end(),
                         [&](const auto& v, const auto& w) { return v.dot(direction) < w.dot(direction); });
    if ((p - *furthest).dot(direction) > 0.0) return true;
    const Eigen::Vector3d step = *furthest - nearest;
    if (step.squaredNorm() < 1e-18) return false;
    nearest += std::clamp(step.dot(direction) / step.squaredNorm(), 0.0, 1.0) * step;
  }
  return false;
}

void check_shape(const ContactShape& shape) {
  const std::string wrong = check(shape.mass);
  require(wrong.empty(), "stone ", shape.name, ": ", wrong);
  require(!shape.scan.vertices.empty(), "stone ", shape.name, " has no scan mesh");
  require(!outside_hull(shape.scan.vertices, shape.mass.p_O_M), "stone ", shape.name, ": centre of mass (",
          shape.mass.p_O_M.transpose(), ") lies outside its hull");
}

void check_placed(const std::vector<PlacedStone>& list, std::size_t shapes, const char* what) {
  for (const PlacedStone& placed : list) {
    require(placed.stone >= 0 && static_cast<std::size_t>(placed.stone) < shapes, what, ": stone index ",
            placed.stone, " is not one of ", shapes, " shapes");
    require(is_valid(placed.T_W_O), what, ": pose of stone ", placed.stone, " is not a rigid transform");
  }
}

/// Deepest overlap of two stones of the stack, from samples of one in the other.
double overlap(const ContactShape& a, const Pose& T_W_A, const ContactShape& b, const Pose& T_W_B) {
  if ((T_W_A * a.mass.p_O_M - T_W_B * b.mass.p_O_M).norm() > a.radius + b.radius) return 0.0;
  const Pose T_A_B = T_W_A.inverse() * T_W_B;
  double deepest = 0.0;
  for (const SurfaceSample& sample : b.samples)
    deepest = std::max(deepest, -a.distance.distance(T_A_B * sample.point));
  return deepest;
}

std::string overlap_reason(const ShapeList& shapes, const Stack& stack) {
  for (const PlacedStone& placed : stack.stones) {
    const ContactShape& shape = *shapes[static_cast<std::size_t>(placed.stone)];
    double lowest = 0.0;
    for (const Eigen::Vector3d& v : shape.scan.vertices) lowest = std::min(lowest, (placed.T_W_O * v).z());
    if (lowest < -kOverlap)
      return concat("the given stack cannot be: ", shape.name, " reaches ", -1000.0 * lowest,
                    " mm below the table");
  }
  for (std::size_t p = 0; p < stack.stones.size(); ++p)
    for (std::size_t q = p + 1; q < stack.stones.size(); ++q) {
      const auto &a = stack.stones[p], &b = stack.stones[q];
      const ContactShape& shape_a = *shapes[static_cast<std::size_t>(a.stone)];
      const ContactShape& shape_b = *shapes[static_cast<std::size_t>(b.stone)];
      const double depth =
          std::max(overlap(shape_a, a.T_W_O, shape_b, b.T_W_O), overlap(shape_b, b.T_W_O, shape_a, a.T_W_O));
      if (depth > kOverlap)
        return concat("the given stack cannot be: ", shape_a.name, " and ", shape_b.name, " overlap by ",
                      1000.0 * depth, " mm");
    }
  return {};
}

bool in_stack(const Stack& stack, int stone) {
  return std::any_of(stack.stones.begin(), stack.stones.end(),
                     [&](const PlacedStone& placed) { return placed.stone == stone; });
}

}  // namespace

SearchContext make_context(const SearchProblem& problem, const SearchOptions& options,
                           const std::function<void(const std::string&)>& report) {
  SearchContext context;
  context.problem = &problem;
  context.options = &options;
  context.report = report;
  context.stack = problem.stack;
  context.geometry.resize(problem.shapes->size());
  for (const auto* list : {&problem.stack.stones, &problem.available})
    for (const PlacedStone& placed : *list) {
      const auto k = static_cast<std::size_t>(placed.stone);
      if (context.geometry[k].faces.empty()) context.geometry[k] = stone_geometry(*(*problem.shapes)[k]);
    }
  for (const PlacedStone& placed : problem.available)
    if (!in_stack(problem.stack, placed.stone)) context.available.push_back(placed);
  return context;
}

std::vector<BodyPose> bodies_of(const SearchContext& context, const Stack& stack) {
  std::vector<BodyPose> bodies;
  for (const PlacedStone& placed : stack.stones)
    bodies.push_back(body_pose(context.geometry[static_cast<std::size_t>(placed.stone)], placed.T_W_O));
  return bodies;
}

std::vector<LooseStone> loose_stones(const SearchContext& context) {
  std::vector<LooseStone> list;
  for (const PlacedStone& placed : context.available) {
    OrientationOptions which;
    which.directions = context.options->directions;
    which.largest_tilt = context.options->largest_tilt;
    which.up_O = placed.T_W_O.linear().transpose() * Eigen::Vector3d::UnitZ();
    LooseStone stone;
    stone.stone = placed.stone;
    stone.geometry = &context.geometry[static_cast<std::size_t>(placed.stone)];
    stone.orientations = orientations(which);
    list.push_back(std::move(stone));
  }
  double radius = 0.0;
  for (const LooseStone& stone : list) radius = std::max(radius, stone.geometry->radius);
  for (LooseStone& stone : list) stone.raster_radius = radius;
  return list;
}

void check_problem(const SearchProblem& problem, const SearchOptions& options) {
  require(problem.shapes != nullptr, "search problem has no shapes");
  SearchOptions copy = options;
  for (const Field& f : fields(copy)) {
    if (const auto* const* number = std::get_if<double*>(&f.value))
      require(**number >= f.range.low && **number <= f.range.high, "search option ", f.name, " must be in [",
              f.range.low, ", ", f.range.high, "], got ", **number);
    if (const auto* const* count = std::get_if<int*>(&f.value))
      require(**count >= f.range.low && **count <= f.range.high, "search option ", f.name, " must be in [",
              f.range.low, ", ", f.range.high, "], got ", **count);
  }
  require(options.method == "default" || options.method == "paper",
          "search method must be default or paper, got ", options.method);
  require(problem.site.allFinite(), "site must be finite, got ", problem.site.transpose());
  check_placed(problem.stack.stones, problem.shapes->size(), "stack");
  check_placed(problem.available, problem.shapes->size(), "available stones");
  for (const auto* list : {&problem.stack.stones, &problem.available})
    for (const PlacedStone& placed : *list) {
      const auto& shape = (*problem.shapes)[static_cast<std::size_t>(placed.stone)];
      require(shape != nullptr, "stone ", placed.stone, " has no contact shape");
      check_shape(*shape);
    }
}

std::optional<Stack> standing_stack(const ShapeList& shapes, const Stack& stack, const SearchOptions& options,
                                    std::string* reason) {
  if (stack.stones.empty()) return stack;
  *reason = overlap_reason(shapes, stack);
  if (!reason->empty()) return std::nullopt;
  StandOptions stand;
  stand.friction = options.friction;
  stand.seconds = kStandSeconds;
  if (const StandVerdict verdict = judge_stack(shapes, stack, stand); verdict.stands && verdict.clean)
    return stack;
  Stack let_down;
  for (const PlacedStone& placed : stack.stones) {
    SettleOptions settling;
    settling.world.friction = options.friction;
    const SettleResult at_rest =
        settle(shapes, let_down, placed.stone, lifted_clear(shapes, let_down, placed), settling);
    PoseDifference moved = difference(at_rest.T_W_O, placed.T_W_O);
    const Eigen::Vector3d& p_O_M = shapes[static_cast<std::size_t>(placed.stone)]->mass.p_O_M;
    moved.translation =
        (at_rest.T_W_O * p_O_M - placed.T_W_O * p_O_M).norm();  // O may lie far from the stone
    const std::string& name = shapes[static_cast<std::size_t>(placed.stone)]->name;
    if (!at_rest.rests || moved.translation > kNearShift || moved.angle > kNearTurn) {
      *reason = concat(
          "the given stack does not stand: ", name, " does not rest where it is said to be (",
          at_rest.rests ? concat("comes to rest ", 1000.0 * moved.translation, " mm away") : at_rest.reason,
          ")");
      return std::nullopt;
    }
    let_down.stones.push_back({placed.stone, at_rest.T_W_O});
  }
  const StandVerdict verdict = judge_stack(shapes, let_down, stand);
  if (verdict.stands && verdict.clean) return let_down;
  *reason = concat("the given stack does not stand: ", verdict.reason);
  return std::nullopt;
}

}  // namespace stonestack
