#include "physics/linear_programme.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace stonestack::physics {
namespace {

using Entry = LinearProgramme::Entry;

/// Maximise 3 x + 5 y with x + s = 4, 2 y + t = 12, 3 x + 2 y + u = 18: 36 at (2, 6), multipliers 0, 3/2, 1.
/// (Hillier and Lieberman, Introduction to Operations Research, the Wyndor Glass problem.)
double best_of_textbook() {
  const double right[] = {4.0, 12.0, 18.0};
  LinearProgramme programme(right);
  const Entry x[] = {{0, 1.0}, {2, 3.0}}, y[] = {{1, 2.0}, {2, 2.0}};
  programme.set_gain(programme.add_column(x), 3.0);
  programme.set_gain(programme.add_column(y), 5.0);
  for (int row = 0; row < 3; ++row) {
    const Entry slack[] = {{row, 1.0}};
    programme.add_column(slack);
  }
  if (!programme.solve(1e-9)) return -1.0;
  EXPECT_NEAR(programme.multiplier(0), 0.0, 1e-9);
  EXPECT_NEAR(programme.multiplier(1), 1.5, 1e-9);
  EXPECT_NEAR(programme.multiplier(2), 1.0, 1e-9);
  return 3.0 * programme.value(0) + 5.0 * programme.value(1);
}

TEST(LinearProgramme, FindsTheOptimumOfATextbookProblem) {
  EXPECT_NEAR(best_of_textbook(), 36.0, 1e-9);
}

TEST(LinearProgramme, HasNoSolutionWhereTheRowsContradictOrTheGainIsUnbounded) {
  const double right[] = {-1.0};
  LinearProgramme negative(right);
  const Entry one[] = {{0, 1.0}};
  negative.add_column(one);
  EXPECT_FALSE(negative.solve(1e-6)) << "x = -1 with x >= 0";
  EXPECT_FALSE(negative.broken());

  const double zero[] = {0.0};
  LinearProgramme unbounded(zero);
  const Entry minus[] = {{0, -1.0}};
  unbounded.set_gain(unbounded.add_column(one), 1.0);
  unbounded.add_column(minus);
  EXPECT_FALSE(unbounded.solve(1e-6)) << "x = y, maximise x";
  unbounded.set_upper(0, 2.0);
  ASSERT_TRUE(unbounded.solve(1e-6));
  EXPECT_NEAR(unbounded.value(0), 2.0, 1e-9);
}

TEST(LinearProgramme, StartsAgainFromABasis) {
  const double right[] = {1.0};
  LinearProgramme programme(right);
  const Entry one[] = {{0, 1.0}};
  const int x = programme.add_column(one), y = programme.add_column(one);
  programme.set_gain(x, 1.0);
  ASSERT_TRUE(programme.solve(1e-6));
  const auto basis = programme.basis();
  EXPECT_NEAR(programme.value(x), 1.0, 1e-12);
  programme.set_gain(y, 2.0);
  ASSERT_TRUE(programme.solve(1e-6));
  EXPECT_NEAR(programme.value(y), 1.0, 1e-12);
  programme.set_gain(y, 0.0);
  programme.set_basis(basis);
  ASSERT_TRUE(programme.solve(1e-6));
  EXPECT_NEAR(programme.value(x), 1.0, 1e-12);
}

/// GLPK by default prints to stdout, which carries data, and aborts the process on a wrong argument.
TEST(LinearProgramme, AnErrorInsideTheSolverIsAFailedSolveAndNeitherPrintedNorAnAbort) {
  testing::internal::CaptureStdout();
  const double right[] = {1.0};
  LinearProgramme before(right);
  {
    LinearProgramme wrong(right);
    const Entry outside[] = {{7, 1.0}};
    wrong.add_column(outside);
    EXPECT_TRUE(wrong.broken());
    EXPECT_FALSE(wrong.solve(1e-6));
    EXPECT_EQ(wrong.value(0), 0.0);
    EXPECT_EQ(wrong.multiplier(0), 0.0);
  }
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_TRUE(before.broken()) << "shared the memory that GLPK gave up";
  EXPECT_FALSE(before.solve(1e-6));
  EXPECT_NEAR(best_of_textbook(), 36.0, 1e-9) << "made afterwards on the same thread";
}

TEST(LinearProgramme, ThreadsDoNotDisturbEachOther) {
  std::vector<std::thread> threads;
  std::vector<int> wrong(4, 0);
  for (std::size_t t = 0; t < wrong.size(); ++t)
    threads.emplace_back([&wrong, t] {
      const double right[] = {1.0};
      for (int i = 0; i < 200; ++i) {
        if (t == 0 && i % 10 == 0) {  // one of them errs now and then
          LinearProgramme bad(right);
          const Entry outside[] = {{7, 1.0}};
          bad.add_column(outside);
        }
        wrong[t] += std::abs(best_of_textbook() - 36.0) > 1e-9 ? 1 : 0;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

}  // namespace
}  // namespace stonestack::physics
