#include <algorithm>
#include <numeric>
#include <optional>

#include "motion/grasp/grasp_end.hpp"
#include "motion/pick_and_place/rest_graph.hpp"
#include "motion/regrasp.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

/// The grasps of all poses of rest that at most `max_set_downs` set-downs lead to, ascending: those that can
/// be taken last.
std::vector<int> grasps_at_last(const RestGraph& graph, std::vector<int> taken, int max_set_downs) {
  std::vector<int> last;
  std::vector<bool> reached(graph.grasps.size(), false);
  for (int k = 0; k < max_set_downs; ++k) {
    for (std::size_t rest = 0; rest < graph.grasps.size(); ++rest) {
      if (reached[rest] || common(taken, graph.grasps[rest]).empty()) continue;
      reached[rest] = true;
      last.insert(last.end(), graph.grasps[rest].begin(), graph.grasps[rest].end());
    }
    std::sort(last.begin(), last.end());
    last.erase(std::unique(last.begin(), last.end()), last.end());
    taken = last;
  }
  return last;
}

}  // namespace

struct RegraspFinder::Parts : PickSide {
  using PickSide::PickSide;
  std::vector<int> last;  ///< grasps that can be taken after the stone was set down
};

RegraspFinder::RegraspFinder(const PlanningScene& scene, const Stone& stone, int object,
                             const Pose& T_W_O_pick, std::span<const Pose> avoid,
                             const MotionOptions& options, const RegraspOptions& regrasp) {
  require(is_valid(T_W_O_pick), "the pose of ", stone.name,
          " is not a pose: ", geometry::to_text(T_W_O_pick));
  parts_ = std::make_unique<Parts>(scene, stone, object, T_W_O_pick, options);
  const std::vector<Grasp>& grasps = parts_->set->grasps;
  std::vector<int> first(grasps.size());
  std::iota(first.begin(), first.end(), 0);
  std::erase_if(first,
                [&](int i) { return is_near_grasp(avoid, grasps[static_cast<std::size_t>(i)].T_O_T); });
  first = parts_->end.serving(grasps, first, T_W_O_pick);
  if (first.empty()) return;
  const RestGraph graph = make_rest_graph(scene, stone, grasps, options, with_shaky_rests(regrasp));
  parts_->last = grasps_at_last(graph, std::move(first), regrasp.max_set_downs);
}
RegraspFinder::~RegraspFinder() = default;
RegraspFinder::RegraspFinder(RegraspFinder&&) noexcept = default;
RegraspFinder& RegraspFinder::operator=(RegraspFinder&&) noexcept = default;

bool RegraspFinder::serves(const Pose& T_W_O_place, std::span<const SceneObject> meanwhile) const {
  require(is_valid(T_W_O_place), "the target of ", parts_->stone.name,
          " is not a pose: ", geometry::to_text(T_W_O_place));
  const std::vector<Grasp>& grasps = parts_->set->grasps;
  std::optional<GraspEnd> later;
  if (!meanwhile.empty()) later.emplace(parts_->end.among(meanwhile));
  return std::any_of(parts_->last.begin(), parts_->last.end(), [&](int i) {
    const Grasp& grasp = grasps[static_cast<std::size_t>(i)];
    return !parts_->end.fault(grasp, T_W_O_place) && (!later || !later->fault(grasp, T_W_O_place));
  });
}

}  // namespace stonestack::motion
