#include "stonestack/stacking/scene_tasks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::stacking {
namespace {

std::string temporary(const std::string& name) {
  return (std::filesystem::path(test::temporary_folder()) / name).string();
}

/// Jumps a minute each time it is read.
class HastyClock : public Clock {
 public:
  [[nodiscard]] double now() const override { return now_ += 60.0; }

 private:
  mutable double now_ = 0.0;
};

TEST(SearchInScene, EndsWithAReasonWhereTheTimeIsOver) {
  SceneSearchTask task;
  task.catalogue = data_path("stones");
  task.stones = "limestone_1";
  task.search.budget = 1.0;
  const HastyClock clock;
  const TimeLimit limit(task.search.budget, clock);
  const SceneSearch found = search_in_scene(task);
  EXPECT_TRUE(found.placements.empty());
  EXPECT_THAT(found.reason, testing::HasSubstr("time was over"));
  EXPECT_FALSE(found.repeatable);
}

TEST(SearchInScene, AnArmNeedsAScene) {
  SceneSearchTask task;
  task.catalogue = data_path("stones");
  task.stones = "limestone_1";
  task.robot = "ur10";
  EXPECT_THROW((void)search_in_scene(task), InvalidArgument);
}

TEST(SearchInScene, PlansAWallOfStonesThatTheArmReaches) {
  SceneFile scene;
  for (int k = 0; k < 4; ++k)  // stones 2 m away are out of reach
    scene.stones.push_back(
        {concat("limestone_", k + 1), make_pose({k < 2 ? 0.6 : 2.0, -0.2 - 0.2 * k, 0.04})});
  SceneSearchTask task;
  task.catalogue = data_path("stones");
  task.scene = temporary("scene_tasks_wall.yaml");
  write_scene_file(task.scene, scene);
  task.wall = "2";
  task.robot = "ur10";
  task.search.friction = 0.35;
  const SceneSearch found = search_in_scene(task);
  ASSERT_EQ(found.placements.size(), 2U) << found.reason;
  for (const Placement& next : found.placements) EXPECT_LT(next.stone, 2_stone) << "out of reach";
  const double apart =
      (found.placements[0].T_W_O.translation() - found.placements[1].T_W_O.translation()).norm();
  EXPECT_GT(apart, 0.09) << "side by side";
}

TEST(PlanInScene, NamesWhatStandsInTheWayOfEachTarget) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  SceneFile scene;
  scene.stones = {{"limestone_1", make_pose({0.6, -0.2, -0.03})}};  // deep in the table
  ScenePlanTask task;
  task.scene = temporary("scene_tasks_test.yaml");
  write_scene_file(task.scene, scene);
  task.robot = read_robot("ur10");
  task.q_start << 0.0, -1.75, 1.85, -1.67, -1.57, 0.0;
  task.targets = {{"limestone_1", make_pose({0.7, 0.28, 0.05})},
                  {"limestone_1", make_pose({0.7, 0.2, 0.05})}};
  const ScenePlan planned = plan_in_scene(task, catalogue);
  EXPECT_NE(planned.plan.status, PickAndPlacePlan::Status::kPlanned);
  EXPECT_THAT(planned.plan.reason, testing::StartsWith("limestone_1: "));
  EXPECT_THAT(planned.plan.reason, testing::Not(testing::HasSubstr("; ")));  // the same for both: named once
  task.targets = {{"boulder", make_pose({0.7, 0.28, 0.05})}};
  EXPECT_THROW((void)plan_in_scene(task, catalogue), InvalidArgument);
}

TEST(CheckTower, RefusesStonesThatOverlapAndFilesWithoutAStack) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const std::string path = temporary("scene_tasks_tower.yaml");
  SceneFile scene;
  write_scene_file(path, scene);
  EXPECT_THROW((void)check_tower(path, catalogue, 0.3, 1.0), FileError);
  scene.stack = {{"limestone_1", make_pose({0.7, 0.28, 0.03})},
                 {"limestone_2", make_pose({0.7, 0.28, 0.03})}};
  write_scene_file(path, scene);
  EXPECT_THROW((void)check_tower(path, catalogue, 0.3, 1.0), FileError);
  EXPECT_THROW((void)check_tower("tower.ply", catalogue, 0.3, 1.0), FileError);
}

}  // namespace
}  // namespace stonestack::stacking
