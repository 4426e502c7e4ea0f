#include <algorithm>
#include <cmath>

#include "physics/shape.hpp"
#include "search/orientations.hpp"
#include "search/parallel.hpp"
#include "search/proposals.hpp"

namespace stonestack::search {
namespace {

constexpr double kOffsetPitch = 0.008;  ///< [m]
constexpr double kSurveyPitch = 0.016;  ///< [m]
constexpr int kWindow = 3;              ///< offsets about the survey's best, as OffsetGrid::n (measured)
constexpr std::size_t kPromising = 48;  ///< orientations of a stone that pass the survey (measured)

struct Effort {
  int yaws;
  double pitch;
};

/// The best landing of an orientation after one turn.
struct Best {
  int yaw = 0;
  int i = 0, j = 0;  ///< its node
  Proposal proposal;
};

/// An orientation of a stone that is to be looked at.
struct Task {
  std::size_t stone = 0;
  std::size_t orientation = 0;
  std::vector<Best> surveyed;  ///< what the survey found; empty in the survey
};

Proposal make_proposal(const LooseStone& stone, const StackField& stack, const Eigen::Matrix3d& R_W_O, int i,
                       int j, const Landing& landing) {
  Proposal proposal;
  proposal.stone = stone.stone;
  proposal.landing = landing;
  proposal.body.stone = stone.geometry;
  proposal.body.R_W_O = R_W_O;
  proposal.body.p_W_M << stack.surface.heights.node(stack.surface.heights.index(i, j)), landing.height;
  return proposal;
}

int survey_yaws(const SearchOptions& options) {
  return std::max(1, options.yaws / 2);
}

OffsetGrid offset_grid(const StackField& stack, double pitch) {
  const double cell = stack.surface.heights.cell;
  OffsetGrid offsets;
  offsets.step = std::max(1, static_cast<int>(std::lround(pitch / cell)));
  offsets.n = std::max(2, static_cast<int>(std::lround(kOffsetReach / (cell * offsets.step))));
  return offsets;
}

/// The survey's best landing among the turns next to one of `yaws`; none if nothing held there.
const Best* nearest_surveyed(const Task& task, int yaw, int yaws, int survey_yaws) {
  const Best* best = nullptr;
  for (const Best& survey : task.surveyed) {
    const int apart = std::abs(yaw * survey_yaws - survey.yaw * yaws);  // in turns / (yaws survey_yaws)
    if (2 * std::min(apart, yaws * survey_yaws - apart) > yaws) continue;
    if (best == nullptr || survey.proposal.landing.estimate > best->proposal.landing.estimate) best = &survey;
  }
  return best;
}

/// Part of a grid of offsets, about a node but inside of the whole.
OffsetGrid around(const Best& middle, OffsetGrid whole) {
  const int span = std::max(0, (whole.n - kWindow) * whole.step);
  OffsetGrid window = whole;
  window.n = std::min(kWindow, whole.n);
  window.i = std::clamp(middle.i, -span, span);
  window.j = std::clamp(middle.j, -span, span);
  return window;
}

/// The landing with the best estimate; none if none holds.
std::optional<Best> best_of(const LooseStone& stone, const StackField& stack, const LandingGrid& grid,
                            const Eigen::Matrix3d& R, int yaw) {
  const OffsetGrid& offsets = grid.offsets;
  const Landing* best = nullptr;
  int best_u = 0, best_v = 0;
  for (int v = 1 - offsets.n; v < offsets.n; ++v)
    for (int u = 1 - offsets.n; u < offsets.n; ++u)
      if (const Landing& landing = grid.at(u, v);
          landing.holds && (best == nullptr || landing.estimate > best->estimate)) {
        best = &landing;
        best_u = u;
        best_v = v;
      }
  if (best == nullptr) return std::nullopt;
  const int i = offsets.i + best_u * offsets.step, j = offsets.j + best_v * offsets.step;
  return Best{yaw, i, j, make_proposal(stone, stack, R, i, j, *best)};
}

/// The underside of an orientation after a turn; from the survey's store where that has it.
const Underside& underside_of(const LooseStone& stone, std::size_t orientation, const Effort& effort, int yaw,
                              const StackField& stack, Underside* made) {
  const UndersideOptions options = underside_options(stack);
  if (const SurveySides* store = stone.surveyed.get();
      store != nullptr && store->options.cell == options.cell && store->options.stride == options.stride &&
      yaw * store->yaws % effort.yaws == 0) {
    const auto at = static_cast<std::size_t>(yaw * store->yaws / effort.yaws);
    return store->sides[orientation * static_cast<std::size_t>(store->yaws) + at];
  }
  const Eigen::Matrix3d R =
      yaw_rotation(6.283185307179586 * yaw / effort.yaws) * stone.orientations[orientation];
  *made = make_underside(stone.geometry->vertices_M, stone.geometry->faces, R, options);
  return *made;
}

/// The best landing of each turn of an orientation, where one holds.
struct Turns {
  std::vector<Best> found;
  long evaluated = 0;  ///< landings
};

Turns try_orientation(const LooseStone& stone, const Task& task, const StackField& stack, bool on_table,
                      const Effort& effort, int survey_yaws) {
  Turns turns;
  GapField buffer;
  Underside made;
  const OffsetGrid whole = offset_grid(stack, effort.pitch);
  for (int yaw = 0; yaw < (on_table ? 1 : effort.yaws); ++yaw) {
    const Underside& underside = underside_of(stone, task.orientation, effort, yaw, stack, &made);
    if (on_table) {
      const Landing landing = land_on_table(stack, underside, &buffer);
      if (landing.holds)
        turns.found.push_back({yaw, 0, 0, make_proposal(stone, stack, underside.R_W_O, 0, 0, landing)});
      ++turns.evaluated;
      continue;
    }
    const Best* near = nearest_surveyed(task, yaw, effort.yaws, survey_yaws);
    const LandingGrid grid =
        land(stack, underside, stone.geometry->mass, near != nullptr ? around(*near, whole) : whole, &buffer);
    turns.evaluated += static_cast<long>(grid.landings.size());
    if (auto best = best_of(stone, stack, grid, underside.R_W_O, yaw))
      turns.found.push_back(*std::move(best));
  }
  return turns;
}

std::vector<Turns> try_all(const std::vector<Task>& tasks, std::span<const LooseStone> stones,
                           const StackField& stack, bool on_table, const Effort& effort,
                           const SearchOptions& options) {
  std::vector<Turns> tried(tasks.size());
  run_tasks(options.threads, tasks.size(), [&](std::size_t k) {
    tried[k] =
        try_orientation(stones[tasks[k].stone], tasks[k], stack, on_table, effort, survey_yaws(options));
  });
  return tried;
}

long evaluated_in(const std::vector<Turns>& tried) {
  long count = 0;
  for (const Turns& turns : tried) count += turns.evaluated;
  return count;
}

double best_estimate(const std::vector<Best>& list) {
  double best = -1.0;
  for (const Best& b : list) best = std::max(best, b.proposal.landing.estimate);
  return best;
}

/// The tasks of one stone whose survey went best, in their order.
std::vector<Task> promising(const std::vector<Task>& tasks, const std::vector<Turns>& survey,
                            std::size_t stone) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < tasks.size(); ++k)
    if (tasks[k].stone == stone && !survey[k].found.empty()) order.push_back(k);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t p, std::size_t q) {
    return best_estimate(survey[p].found) > best_estimate(survey[q].found);
  });
  order.resize(std::min(order.size(), kPromising));
  std::vector<Task> kept;
  for (const std::size_t k : order) kept.push_back({stone, tasks[k].orientation, survey[k].found});
  return kept;
}

}  // namespace

std::vector<LooseStone> with_survey(std::vector<LooseStone> stones, const SearchOptions& options) {
  const UndersideOptions of_field = underside_options(stack_field({}, stones, {0, 0}, options.grid, options));
  const auto yaws = static_cast<std::size_t>(survey_yaws(options));
  for (LooseStone& stone : stones) {
    SurveySides store{survey_yaws(options), of_field, {}};
    store.sides.resize(stone.orientations.size() * yaws);
    run_tasks(options.threads, stone.orientations.size(), [&](std::size_t k) {
      for (std::size_t yaw = 0; yaw < yaws; ++yaw)
        store.sides[k * yaws + yaw] = make_underside(
            stone.geometry->vertices_M, stone.geometry->faces,
            yaw_rotation(6.283185307179586 * static_cast<double>(yaw) / static_cast<double>(yaws)) *
                stone.orientations[k],
            of_field);
    });
    stone.surveyed = std::make_shared<const SurveySides>(std::move(store));
  }
  return stones;
}

Proposals coarse_proposals(const StackField& stack, bool on_table, std::span<const LooseStone> stones,
                           std::size_t keep, const SearchOptions& options) {
  std::vector<Task> tasks;
  for (std::size_t s = 0; s < stones.size(); ++s)
    for (std::size_t k = 0; k < stones[s].orientations.size(); ++k) tasks.push_back({s, k, {}});
  auto tried = try_all(tasks, stones, stack, on_table, {survey_yaws(options), kSurveyPitch}, options);
  Proposals result;
  result.evaluated = evaluated_in(tried);
  if (!on_table) {
    std::vector<Task> chosen;
    for (std::size_t s = 0; s < stones.size(); ++s) {
      const std::vector<Task> of_stone = promising(tasks, tried, s);
      chosen.insert(chosen.end(), of_stone.begin(), of_stone.end());
    }
    tasks = std::move(chosen);
    tried = try_all(tasks, stones, stack, on_table, {options.yaws, kOffsetPitch}, options);
    result.evaluated += evaluated_in(tried);
  }
  for (std::size_t s = 0; s < stones.size(); ++s) {
    std::vector<Proposal> of_stone;
    for (std::size_t k = 0; k < tasks.size(); ++k)
      if (tasks[k].stone == s)
        for (const Best& best : tried[k].found) of_stone.push_back(best.proposal);
    of_stone = best_distinct(std::move(of_stone), keep, [](const Proposal& p) { return p.landing.estimate; });
    result.list.insert(result.list.end(), of_stone.begin(), of_stone.end());
  }
  return result;
}

}  // namespace stonestack::search
