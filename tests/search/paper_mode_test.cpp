#include <gtest/gtest.h>

#include <map>

#include "box_scenes.hpp"

namespace stonestack::search {
namespace {

TEST(PaperMode, FindsAPoseForCubes) {
  SearchOptions options = quick();
  options.method = "paper";
  options.theta_init = 0.1;
  options.local_solutions = 2;
  options.descent_rounds = 3;
  options.trace = true;
  options.verify = false;
  const SearchResult result = find_next_pose(base_stands(), options);
  ASSERT_FALSE(result.best.empty()) << result.reason;
  EXPECT_GE(result.best[0].support.corners_W.size(), 3U);
  EXPECT_GT(result.best[0].support.margin, 0.0);
  for (std::size_t k = 1; k < result.best.size(); ++k)
    EXPECT_LE(result.best[k - 1].cost, result.best[k].cost);
  ASSERT_FALSE(result.trace.empty());
  for (const CandidateTrace& trace : result.trace) EXPECT_FALSE(trace.path_W_O.empty());
}

/// Outcomes in the trace, and how often each.
std::map<std::string, int> outcomes(const SearchResult& result) {
  std::map<std::string, int> count;
  for (const CandidateTrace& trace : result.trace) ++count[trace.outcome];
  return count;
}

TEST(PaperMode, TheTraceHasEveryContactSearch) {
  SearchOptions options = quick();
  options.method = "paper";
  options.theta_init = 0.1;
  options.local_solutions = 2;
  options.descent_rounds = 2;
  options.descent_tolerance = 0.0;
  options.trace = true;
  options.verify = false;
  const SearchResult result = find_next_pose(base_stands(), options);
  auto count = outcomes(result);
  const int solutions = count["local solution"];
  EXPECT_EQ(solutions, 4) << "two of each stone";
  EXPECT_GE(count["perturbed for the gradient"], 5 * solutions);
  EXPECT_GE(count["a step of the descent"], 1);
  EXPECT_EQ(count["first contact, descends from here"], solutions);
  // A local solution is the best pose of its descent, shown again.
  EXPECT_EQ(result.candidates + solutions, static_cast<long>(result.trace.size()));
}

TEST(PaperMode, ItsParametersAreOptions) {
  SearchOptions options = quick();
  options.method = "paper";
  options.theta_init = 0.0;
  options.local_solutions = 1;
  options.restarts = 1;
  options.trace = true;
  options.verify = false;
  options.initial_gap = 0.005;
  const auto starts_at = [](const SearchResult& result) {
    return result.trace.front().path_W_O.front().translation().z();
  };
  const SearchResult above = find_next_pose(base_stands(), options);
  ASSERT_FALSE(above.best.empty()) << above.reason;
  EXPECT_NEAR(starts_at(above), 0.06 + 0.005 + 0.025, 1e-3) << "the middle box, 50 mm high";
  options.area_min = 0.5;
  const SearchResult small = find_next_pose(base_stands(), options);
  EXPECT_TRUE(small.best.empty());
  EXPECT_GT(outcomes(small)["the support polygon is smaller than area_min"], 0);
  options.area_min = 0.0;
  options.contact_seconds = 0.01;
  options.initial_gap = 0.1;
  EXPECT_TRUE(find_next_pose(base_stands(), options).best.empty()) << "there was no time to come down";
}

TEST(PaperMode, ExpectsAsManyStonesAsAreLikely) {
  SearchOptions options = quick();
  options.method = "paper";
  options.theta_init = 0.1;
  options.local_solutions = 2;
  options.descent_rounds = 3;
  options.friction = 0.5;
  const SearchResult result = find_next_pose(base_stands(), options);
  ASSERT_FALSE(result.best.empty()) << result.reason;
  for (const Placement& placement : result.best) {
    EXPECT_GT(placement.expected_height, 0.0);
    EXPECT_EQ(placement.expected_height, placement.predicted_success);
  }
}

}  // namespace
}  // namespace stonestack::search
