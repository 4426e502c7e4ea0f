#include "search/look_ahead.hpp"

#include <algorithm>
#include <cmath>

#include "physics/shape.hpp"
#include "search/orientations.hpp"
#include "search/parallel.hpp"

namespace stonestack::search {
namespace {

constexpr double kCell = 0.005;   ///< [m]
constexpr std::size_t kYaws = 4;  ///< measured: fewer make all answers alike
constexpr OffsetGrid kFullOffsets{0, 0, 3, 3};
constexpr OffsetGrid kQuickOffsets{0, 0, 2, 4};
constexpr std::size_t kBestCounted = 3;  ///< measured: 3 rather than 8
constexpr double kMin = -0.25;           ///< [g]

}  // namespace

LookAhead::LookAhead(std::span<const LooseStone> stones, const SearchOptions& options)
    : stones_(stones.begin(), stones.end()), options_(options) {
  const StackField table = stack_field({}, stones_, {0, 0}, kCell, options_);
  struct Task {
    std::size_t stone;
    const Eigen::Matrix3d* R_W_O;
  };
  std::vector<Task> tasks;
  for (std::size_t s = 0; s < stones_.size(); ++s)
    for (const Eigen::Matrix3d& R_W_O : stones_[s].orientations) tasks.push_back({s, &R_W_O});
  std::vector<Side> sides(tasks.size());
  run_tasks(options_.threads, tasks.size(), [&](std::size_t k) {
    const StoneGeometry& stone = *stones_[tasks[k].stone].geometry;
    sides[k].stone = tasks[k].stone;
    for (std::size_t yaw = 0; yaw < kYaws; ++yaw) {
      const double angle = 6.283185307179586 * static_cast<double>(yaw) / kYaws;
      const Eigen::Matrix3d R = yaw_rotation(angle) * *tasks[k].R_W_O;
      Underside side = make_underside(stone.vertices_M, stone.faces, R, underside_options(table));
      sides[k].yaws.push_back(std::move(side));
    }
  });
  for (Side& side : sides)
    if (!side.yaws.empty()) sides_.push_back(std::move(side));
}

LookAheadEstimate LookAhead::estimate(const StackBodies& stack, std::span<const StoneIndex> used,
                                      LookAheadEffort effort) const {
  const OffsetGrid& offsets = effort == LookAheadEffort::kFull ? kFullOffsets : kQuickOffsets;
  const std::size_t yaws = effort == LookAheadEffort::kFull ? kYaws : 1;
  const StackField field = stack_field(stack, stones_, {0, 0}, kCell, options_);
  LookAheadEstimate result;
  std::vector<double> best;
  GapField buffer;
  for (const Side& side : sides_) {
    const LooseStone& stone = stones_[side.stone];
    if (std::find(used.begin(), used.end(), stone.stone) != used.end()) continue;
    double max = kMin;
    for (std::size_t yaw = 0; yaw < yaws; ++yaw) {
      const LandingGrid grid = land(field, side.yaws[yaw], stone.geometry->mass, offsets, &buffer);
      result.evaluated += static_cast<long>(grid.landings.size());
      for (int v = 1 - offsets.n; v < offsets.n; ++v)
        for (int u = 1 - offsets.n; u < offsets.n; ++u) max = std::max(max, grid.at(u, v).estimate);
    }
    best.push_back(std::clamp(max, kMin, options_.friction + 0.05));
  }
  if (best.empty()) {
    const bool any_left = std::any_of(stones_.begin(), stones_.end(), [&](const LooseStone& stone) {
      return std::find(used.begin(), used.end(), stone.stone) == used.end();
    });
    result.value = any_left ? kMin : 0.0;
    return result;
  }
  std::sort(best.rbegin(), best.rend());
  const std::size_t counted = std::min(kBestCounted, best.size());
  double sum = 0.0;
  for (std::size_t k = 0; k < counted; ++k) sum += best[k];
  result.value = sum / static_cast<double>(counted);
  return result;
}

}  // namespace stonestack::search
