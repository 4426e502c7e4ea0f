#include "report/run_order.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "rooms.hpp"
#include "stacking/resume_point.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

/// How a run was started, read again so that it can go on.
namespace stonestack::report {
namespace {

using testing::HasSubstr;

/// A folder in which a run was begun, as its process left it.
struct BegunRun {
  std::string folder;
  Catalogue catalogue = read_catalogue(data_path("stones"));
  RunOrder order;

  explicit BegunRun(const std::string& name) : folder(test::temporary_folder() + name) {
    order.robot = read_robot("ur5");
    order.run.seed = 7;
    spread_seed(order.run);
    order.run.build.max_stones = 3;
    order.run.build.search.friction = 0.1 + 0.2;  // more digits than a person writes
    order.run.build.gripper = "robotiq-2f-140";
    order.run.simulation = options_of_cell("lab");
    order.run.simulation.seed = 7;
    order.per_run = 5;
  }
  void begin() const {
    write_order(folder, order, catalogue);
    const BuildOptions& options = order.run.build;
    const stacking::Models models{&catalogue, &order.robot, {}, {}, {}};
    const StageSeconds seconds;
    stacking::ResumeWriter(folder, models, options, seconds, nullptr).begin();
  }
  [[nodiscard]] std::string problem() const {
    try {
      (void)read_resumable_run(folder);
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  }
};

TEST(RunOrder, IsReadAsItWasGiven) {
  BegunRun run("order");
  run.begin();
  ResumableRun read = read_resumable_run(run.folder);
  EXPECT_EQ(read.order.resume, run.folder);
  EXPECT_EQ(read.order.robot.name, "ur5");
  EXPECT_EQ(read.order.per_run, 5);
  EXPECT_EQ(read.order.run.build.search.friction, 0.1 + 0.2);
  EXPECT_EQ(write_fields(fields(read.order.run)), write_fields(fields(run.order.run)));
  EXPECT_EQ(read.catalogue.stones.size(), run.catalogue.stones.size());
  EXPECT_FALSE(read.order.cell);
}

TEST(RunOrder, AFolderWhoseRunCannotGoOnIsRefusedWithTheReason) {
  const BegunRun run("refused");
  EXPECT_THAT(run.problem(), HasSubstr("is no folder"));
  std::filesystem::create_directories(run.folder);
  EXPECT_THAT(run.problem(), HasSubstr("no run that can go on was begun in this folder; start a new run"));
  run.begin();
  EXPECT_EQ(run.problem(), "");
  {
    const RecordFolder under_way(run.folder);
    EXPECT_THAT(run.problem(), HasSubstr("wait until the run in it has ended"));
  }
  write_file(run.folder + "/report.html", "page");
  for (const auto& [ended, refused] :
       {std::pair("interrupted", false), {"stopped", false}, {"all_placed", true}}) {
    write_file(run.folder + "/result.json", concat(R"({"ended": ")", ended, R"("})"));
    EXPECT_THAT(run.problem(), HasSubstr(refused ? "holds a run that ended (all_placed)" : "")) << ended;
    EXPECT_EQ(run.problem().empty(), !refused) << ended;
  }
  std::filesystem::remove(run.folder + "/result.json");
  const std::string order = run.folder + "/order.json", whole = read_file(order, 1 << 20);
  write_file(order, whole.substr(0, whole.size() / 2));
  EXPECT_THAT(run.problem(), HasSubstr("order.json: is not what a run wrote"));
  std::string other = whole;
  other.replace(other.find("stonestack.order/1"), 18, "stonestack.order/9");
  write_file(order, other);
  EXPECT_THAT(run.problem(), HasSubstr("its schema is not stonestack.order/1"));
  write_file(order, whole);
  write_file(run.folder + "/resume.json", "{");
  EXPECT_THAT(run.problem(), HasSubstr("resume.json"));
}

TEST(RunOrder, ACellThatIsBuiltOtherwiseIsRefused) {
  BegunRun run("cell");
  const std::string cell = test::temporary_folder() + "cell.yaml";
  const std::string text = "robot: ur10\narm:\n  address: 192.0.2.1\nlayout:\n  site: {x: 0.7, y: ";
  write_file(cell, text + "0.28}\n");
  run.order.cell = read_cell(cell);
  run.order.run.build.gripper.clear();
  run.begin();
  EXPECT_EQ(run.problem(), "");
  EXPECT_EQ(read_resumable_run(run.folder).order.cell->arm_address(), "192.0.2.1");
  write_file(cell, text + "0.30}\n");
  EXPECT_THAT(run.problem(),
              HasSubstr("has another layout than when the run began; take back what was changed"));
}

TEST(RunOrder, SimulatedDevicesOnSocketsEndWithTheirProcess) {
  RunOrder order;
  EXPECT_TRUE(can_resume(order));
  order.dry = true;
  EXPECT_FALSE(can_resume(order));
  order.dry = false;
  order.cell = read_cell("loopback-ur10");
  EXPECT_FALSE(can_resume(order));
}

}  // namespace
}  // namespace stonestack::report
