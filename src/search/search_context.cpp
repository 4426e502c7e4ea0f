#include "search/search_context.hpp"

#include <algorithm>
#include <cmath>

#include "physics/settle.hpp"
#include "physics/shape.hpp"
#include "search/orientations.hpp"
#include "search/resting_height.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/physics/stack.hpp"

namespace stonestack::search {
namespace {

constexpr double kStandSeconds = 2.0;
constexpr double kNearShift = 0.005;  ///< [m]
constexpr double kNearTurn = 0.0873;  ///< [rad]
/// Motion [m and rad] beyond which a stone was given above or askew of its contacts (`rests_of` asks the
/// scans within 0.8 mm); what moves less keeps its pose exactly.
constexpr double kAtRestShift = 1e-4;
constexpr double kAtRestTurn = 2e-3;

void check_placed(const std::vector<PlacedStone>& list, std::size_t shapes, const char* what) {
  for (const PlacedStone& placed : list) {
    require(placed.stone.is_within(shapes), what, ": stone index ", placed.stone, " is not one of ", shapes,
            " shapes");
    require(is_valid(placed.T_W_O), what, ": pose of stone ", placed.stone, " is not a rigid transform");
  }
}

bool in_stack(const Stack& stack, StoneIndex stone) {
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
      StoneGeometry& geometry = at(context.geometry, placed.stone);
      if (geometry.faces.empty()) geometry = stone_geometry(*at(*problem.shapes, placed.stone));
    }
  for (const PlacedStone& placed : problem.available)
    if (!in_stack(problem.stack, placed.stone)) context.available.push_back(placed);
  if (problem.possible_shapes == nullptr) return context;
  for (const ShapeList& shapes : *problem.possible_shapes) {
    auto& geometry = context.possible_geometry.emplace_back(shapes.size());
    for (const PlacedStone& placed : context.available)
      if (const auto& shape = at(shapes, placed.stone)) at(geometry, placed.stone) = stone_geometry(*shape);
  }
  return context;
}

std::vector<BodyPose> bodies_of(const SearchContext& context, const Stack& stack) {
  std::vector<BodyPose> bodies;
  for (const PlacedStone& placed : stack.stones)
    bodies.push_back(body_pose(at(context.geometry, placed.stone), placed.T_W_O));
  return bodies;
}

std::vector<StoneIndex> stones_of(const Stack& stack) {
  std::vector<StoneIndex> list;
  for (const PlacedStone& placed : stack.stones) list.push_back(placed.stone);
  return list;
}

bool is_known_in_part(const SearchProblem& problem, StoneIndex stone) {
  return problem.possible_shapes != nullptr && !problem.possible_shapes->empty() &&
         at(problem.possible_shapes->front(), stone) != nullptr;
}

std::vector<LooseStone> loose_stones(const SearchContext& context) {
  std::vector<LooseStone> list;
  for (const PlacedStone& placed : context.available) {
    OrientationOptions which;
    which.directions = context.options->directions;
    which.max_tilt = context.options->max_tilt;
    which.up_O = placed.T_W_O.linear().transpose() * Eigen::Vector3d::UnitZ();
    LooseStone stone;
    stone.stone = placed.stone;
    stone.geometry = &at(context.geometry, placed.stone);
    stone.orientations = orientations(which);
    // Of a stone whose underside is not known it is known that it rests as it lies.
    if (is_known_in_part(*context.problem, placed.stone))
      stone.orientations.insert(stone.orientations.begin(), placed.T_W_O.linear());
    list.push_back(std::move(stone));
  }
  double radius = 0.0;
  for (const LooseStone& stone : list) radius = std::max(radius, stone.geometry->radius);
  for (LooseStone& stone : list) stone.raster_radius = radius;
  return list;
}

void check_options(const SearchOptions& options) {
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
  require(options.objective == "height" || options.objective == "firm",
          "search objective must be height or firm, got ", options.objective);
  require(options.objective == "height" || options.method == "default",
          "search objective firm needs the default search, not ", options.method);
}

void check_problem(const SearchProblem& problem, const SearchOptions& options) {
  require(problem.shapes != nullptr, "search problem has no shapes");
  check_options(options);
  require(problem.held >= 0 && static_cast<std::size_t>(problem.held) <= problem.stack.stones.size(),
          "of a stack of ", problem.stack.stones.size(), " stones ", problem.held, " cannot be held");
  if (problem.possible_shapes != nullptr)
    for (const ShapeList& shapes : *problem.possible_shapes)
      require(shapes.size() == problem.shapes->size(), "a list of possible shapes has ", shapes.size(),
              " shapes, not ", problem.shapes->size());
  require(problem.site.allFinite(), "site must be finite, got ", problem.site.transpose());
  check_placed(problem.stack.stones, problem.shapes->size(), "stack");
  check_placed(problem.available, problem.shapes->size(), "available stones");
  check_placed(problem.known_route, problem.shapes->size(), "known route");
  for (const auto* list : {&problem.stack.stones, &problem.available})
    for (const PlacedStone& placed : *list) {
      const auto& shape = at(*problem.shapes, placed.stone);
      require(shape != nullptr, "stone ", placed.stone, " has no contact shape");
      const std::string wrong = impossible(*shape);
      require(wrong.empty(), "stone ", shape->name, ": ", wrong);
    }
}

StandingStack settled_stack(const ShapeList& shapes, const Stack& stack, const SearchOptions& options,
                            bool tower) {
  if (stack.stones.empty()) return {stack, ""};
  if (const std::string overlap = overlap_of(shapes, stack); !overlap.empty()) return {{}, overlap};
  StandOptions stand;
  stand.friction = options.friction;
  stand.seconds = kStandSeconds;
  stand.still = kStill;
  stand.step = kVerdictStep;
  if (const StandVerdict verdict = judge_stack(shapes, stack, stand);
      verdict.stands && (verdict.clean || !tower)) {
    Stack at_rest = stack;
    if (verdict.shift > kAtRestShift || verdict.turn > kAtRestTurn)
      for (std::size_t i = 0; i < at_rest.stones.size(); ++i) at_rest.stones[i].T_W_O = verdict.T_W_O[i];
    return {std::move(at_rest), ""};
  }
  Stack lowered;
  for (const PlacedStone& placed : stack.stones) {
    SettleOptions settling;
    settling.world.friction = options.friction;
    settling.any_support = !tower;
    const SettleResult at_rest =
        settle(shapes, lowered, placed.stone, lifted_clear(shapes, lowered, placed), settling);
    PoseDifference moved = difference(at_rest.T_W_O, placed.T_W_O);
    const Eigen::Vector3d& p_O_M = at(shapes, placed.stone)->mass.p_O_M;
    moved.translation =
        (at_rest.T_W_O * p_O_M - placed.T_W_O * p_O_M).norm();  // O may lie far from the stone
    const std::string& name = at(shapes, placed.stone)->name;
    if (!at_rest.rests || moved.translation > kNearShift || moved.angle > kNearTurn) {
      return {{},
              concat("the given stack does not stand: ", name, " does not rest where it is said to be (",
                     at_rest.rests ? concat("comes to rest ", 1000.0 * moved.translation, " mm away")
                                   : at_rest.reason,
                     ")")};
    }
    lowered.stones.push_back({placed.stone, at_rest.T_W_O});
  }
  const StandVerdict verdict = judge_stack(shapes, lowered, stand);
  if (verdict.stands && (verdict.clean || !tower)) return {std::move(lowered), ""};
  return {{}, concat("the given stack does not stand: ", verdict.reason)};
}

}  // namespace stonestack::search
