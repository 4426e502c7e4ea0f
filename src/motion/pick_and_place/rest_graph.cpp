#include "motion/pick_and_place/rest_graph.hpp"

#include <algorithm>
#include <iterator>

#include "motion/grasp/grasp_end.hpp"
#include "motion/pick_and_place/set_down.hpp"

namespace stonestack::motion {
namespace {

/// Grows chains one pose at a time.
class ChainSearch {
 public:
  ChainSearch(const RestGraph& graph, const std::vector<int>& from, const std::vector<int>& to, int max)
      : max_(static_cast<std::size_t>(max)) {
    const std::size_t count = graph.grasps.size();
    shared_.assign(count, std::vector<std::size_t>(count, 0));
    for (std::size_t a = 0; a < count; ++a) {
      into_.push_back(common(from, graph.grasps[a]).size());
      out_.push_back(common(graph.grasps[a], to).size());
      for (std::size_t b = 0; b < a; ++b)
        shared_[a][b] = shared_[b][a] = common(graph.grasps[a], graph.grasps[b]).size();
    }
  }

  struct Chain {
    std::vector<int> rests;
    std::size_t scarcest = 0;
  };
  [[nodiscard]] std::vector<Chain> all() {
    for (std::size_t first = 0; first < into_.size(); ++first) extend({{}, into_[first]}, first);
    return std::move(found_);
  }

 private:
  void extend(Chain chain, std::size_t next) {
    if (chain.scarcest == 0) return;
    chain.rests.push_back(static_cast<int>(next));
    if (out_[next] > 0) found_.push_back({chain.rests, std::min(chain.scarcest, out_[next])});
    if (chain.rests.size() == max_) return;
    for (std::size_t after = 0; after < into_.size(); ++after)
      if (std::find(chain.rests.begin(), chain.rests.end(), static_cast<int>(after)) == chain.rests.end())
        extend({chain.rests, std::min(chain.scarcest, shared_[next][after])}, after);
  }

  std::size_t max_;
  std::vector<std::size_t> into_, out_;           ///< grasps that lead from the start, and to the target
  std::vector<std::vector<std::size_t>> shared_;  ///< grasps that two poses share
  std::vector<Chain> found_;
};

}  // namespace

std::vector<int> common(const std::vector<int>& a, const std::vector<int>& b) {
  std::vector<int> both;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return both;
}

RegraspOptions with_shaky_rests(RegraspOptions regrasp) {
  regrasp.rest_margin = std::min(regrasp.rest_margin, regrasp.min_margin);
  regrasp.rest_tilt = std::min(regrasp.rest_tilt, regrasp.min_tilt);
  return regrasp;
}

RestGraph make_rest_graph(const PlanningScene& scene, const Stone& stone, const std::vector<Grasp>& grasps,
                          const MotionOptions& options, const RegraspOptions& regrasp) {
  PlanningScene empty = scene;
  empty.objects.clear();
  const GraspEnd end(empty, stone, -1, options);
  RestGraph graph{rest_poses(stone, regrasp), {}};
  for (const RestPose& rest : graph.rests) {
    const Pose T_W_O = standing(stone, rest.R_W_O, Eigen::Vector2d::Zero(), scene.table_z);
    std::vector<int> held;
    for (std::size_t i = 0; i < grasps.size(); ++i)
      if (!end.gripper_fault(grasps[i], T_W_O)) held.push_back(static_cast<int>(i));
    graph.grasps.push_back(std::move(held));
  }
  return graph;
}

std::vector<std::vector<int>> rest_chains(const RestGraph& graph, const std::vector<int>& from,
                                          const std::vector<int>& to, int max) {
  auto chains = ChainSearch(graph, from, to, max).all();
  std::stable_sort(chains.begin(), chains.end(), [](const auto& a, const auto& b) {
    return a.rests.size() != b.rests.size() ? a.rests.size() < b.rests.size() : a.scarcest > b.scarcest;
  });
  std::vector<std::vector<int>> rests;
  for (auto& chain : chains) rests.push_back(std::move(chain.rests));
  return rests;
}

}  // namespace stonestack::motion
