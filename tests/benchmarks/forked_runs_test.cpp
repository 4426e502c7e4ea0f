#include "benchmarks/forked_runs.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include "stonestack/core/error.hpp"

namespace stonestack::bench {
namespace {

TEST(ForkedRuns, EachCopyGoesOnFromWhereItWasMade) {
  ForkedRuns runs(2, 60.0);
  int done = 0;
  for (std::size_t k = 0; k < 5; ++k) {
    if (runs.start(k))
      runs.finish(std::to_string(done) + std::string(100000, '.'));  // more than a pipe holds
    ++done;
  }
  const auto results = runs.wait();
  ASSERT_EQ(results.size(), 5U);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_EQ(results.at(k).problem, "");
    EXPECT_EQ(results.at(k).text, std::to_string(k) + std::string(100000, '.'));
  }
}

TEST(ForkedRuns, ACopyThatCrashesSaysBySignal) {
  ForkedRuns runs(1, 60.0);
  if (runs.start(3)) ::raise(SIGKILL);
  if (runs.start(4)) ForkedRuns::fail();
  const auto results = runs.wait();
  ASSERT_EQ(results.size(), 2U);
  EXPECT_NE(results.at(3).problem.find("signal 9"), std::string::npos) << results.at(3).problem;
  EXPECT_NE(results.at(4).problem.find("exit code 1"), std::string::npos) << results.at(4).problem;
}

TEST(ForkedRuns, ACopyThatDoesNotEndIsEnded) {
  ForkedRuns runs(2, 0.5);
  if (runs.start(0))
    while (true) ::pause();
  if (runs.start(1)) runs.finish("done");
  const auto results = runs.wait();
  ASSERT_EQ(results.size(), 2U);
  EXPECT_NE(results.at(0).problem.find("no end within 0.5 s"), std::string::npos) << results.at(0).problem;
  EXPECT_EQ(results.at(1).text, "done");
}

}  // namespace
}  // namespace stonestack::bench
