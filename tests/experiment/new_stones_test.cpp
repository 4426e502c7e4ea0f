#include "experiment/new_stones.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <set>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::experiment {
namespace {

std::vector<std::string> names(const Catalogue& catalogue) {
  std::vector<std::string> list;
  for (const Stone& stone : catalogue.stones) list.push_back(stone.name);
  return list;
}

TEST(NewStones, GeneratedOnesAreThoseOfTheRunAlone) {
  const RobotModel robot = read_robot("ur10");
  const NewStones stones(2, "", 1, robot);
  const Catalogue first = stones.of_run(1, 1001), second = stones.of_run(2, 1002);
  ASSERT_EQ(first.stones.size(), 2u);
  EXPECT_TRUE(first.stones[0].name.starts_with("limestone_1001_")) << first.stones[0].name;
  EXPECT_NE(first.stones[0].mass.mass, first.stones[1].mass.mass);
  EXPECT_NE(first.stones[0].mass.mass, second.stones[0].mass.mass);
  const Catalogue again = NewStones(2, "", 1, robot).of_run(1, 1001);
  EXPECT_EQ(names(again), names(first));
  EXPECT_EQ(again.stones[1].scan.vertices, first.stones[1].scan.vertices) << "same seed, same stones";
}

TEST(NewStones, DrawnOnesComeAgainOnlyAfterAllOthers) {
  const RobotModel robot = read_robot("ur10");
  const std::string folder = data_path("stones");  // six stones
  const NewStones stones(2, folder, 3, robot);
  for (const int round : {0, 1}) {
    std::set<std::string> seen;
    for (int k = 1; k <= 3; ++k)
      for (const std::string& name : names(stones.of_run(3 * round + k, 3000 + k))) seen.insert(name);
    EXPECT_EQ(seen.size(), 6u) << "round " << round;
  }
  EXPECT_EQ(names(NewStones(2, folder, 3, robot).of_run(5, 1)), names(stones.of_run(5, 2)));
  bool other = false;
  for (int k = 1; k <= 6; ++k)
    other = other || names(NewStones(2, folder, 4, robot).of_run(k, 1)) != names(stones.of_run(k, 1));
  EXPECT_TRUE(other) << "another seed, other stones";
}

TEST(NewStones, TooFewAreRefused) {
  const RobotModel robot = read_robot("ur10");
  EXPECT_THROW(NewStones(7, data_path("stones"), 1, robot), InvalidArgument);
  EXPECT_THROW(NewStones(0, "", 1, robot), InvalidArgument);
  EXPECT_THROW(NewStones(1, "/no/such/folder", 1, robot), FileError);
}

}  // namespace
}  // namespace stonestack::experiment
