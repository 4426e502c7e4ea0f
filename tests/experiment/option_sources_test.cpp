#include "stonestack/experiment/option_sources.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::experiment {
namespace {

/// Every option, without the files of whoever runs the test.
class OptionSourcesTest : public testing::Test {
 protected:
  void SetUp() override {
    ::setenv("XDG_CONFIG_HOME", folder_.c_str(), 1);
    write_file(file_, "search:\n  friction: 0.21\nrun:\n  max_stones: 3\n");
  }
  void TearDown() override {
    ::unsetenv("XDG_CONFIG_HOME");
    ::unsetenv("STONESTACK_SEARCH_FRICTION");
    std::filesystem::remove_all(folder_);
  }

  std::string folder_ = test::temporary_folder() + concat("option_sources_", ::getpid());
  std::string file_ = folder_ + "/options.yaml";
  EveryOption every_;
  FieldList list_ = fields(every_);
};

TEST_F(OptionSourcesTest, AStrongerSourceWinsAndIsNamed) {
  OptionOrigins origins = apply_options(list_, {file_, {}, {}});
  EXPECT_EQ(every_.build.search.friction, 0.21);
  EXPECT_EQ(origin_of("search.friction", origins), "file " + file_);
  EXPECT_EQ(origin_of("search.method", origins), "default");
  ::setenv("STONESTACK_SEARCH_FRICTION", "0.22", 1);
  origins = apply_options(list_, {file_, {}, {}});
  EXPECT_EQ(every_.build.search.friction, 0.22);
  EXPECT_EQ(origin_of("search.friction", origins), "environment STONESTACK_SEARCH_FRICTION");
  origins = apply_options(list_, {file_, {{"--friction", "search.friction", "0.23"}}, {}});
  EXPECT_EQ(every_.build.search.friction, 0.23);
  EXPECT_EQ(origin_of("search.friction", origins), "flag --friction");
  origins =
      apply_options(list_, {file_, {{"--friction", "search.friction", "0.23"}}, {"search.friction=0.24"}});
  EXPECT_EQ(every_.build.search.friction, 0.24);
  EXPECT_EQ(origin_of("search.friction", origins), "flag --set");
  EXPECT_EQ(every_.build.max_stones, 3) << "what no other source sets is as in the file";
}

TEST_F(OptionSourcesTest, ReadsTheUsersFile) {
  write_file(folder_ + "/stonestack/config.yaml", "search: {friction: 0.25}\n");
  const OptionOrigins origins = apply_options(list_, {});
  EXPECT_EQ(every_.build.search.friction, 0.25);
  EXPECT_EQ(origin_of("search.friction", origins), "user file " + folder_ + "/stonestack/config.yaml");
}

TEST_F(OptionSourcesTest, OneFlagSetsEverySeed) {
  (void)apply_options(list_, {"", {{"--seed", "*.seed", "7"}}, {}});
  EXPECT_EQ(every_.build.search.seed, 7);
  EXPECT_EQ(every_.build.detection.seed, 7);
  EXPECT_EQ(every_.simulation.seed, 7);
}

TEST_F(OptionSourcesTest, AMethodSetsWhatItStandsForAndNothingThatSomebodySet) {
  const OptionOrigins origins = apply_options(list_, {"", {}, {"detection.method=paper"}});
  EXPECT_EQ(every_.build.detection.descriptor, "rops");
  EXPECT_EQ(origin_of("detection.descriptor", origins), "detection.method");
  EveryOption other;
  (void)apply_options(fields(other), {"", {}, {"detection.descriptor=fpfh", "detection.method=paper"}});
  EXPECT_EQ(other.build.detection.descriptor, "fpfh");
  EveryOption third;
  set_fields(fields(third), {"detection.descriptor=fpfh"});
  set_fields(fields(third), {"detection.method=paper"});
  EXPECT_EQ(third.build.detection.descriptor, "rops") << "the later assignment counts";
}

TEST_F(OptionSourcesTest, ACellSetsItsErrorsAndNothingThatSomebodySet) {
  const OptionOrigins origins =
      apply_options(list_, {"", {}, {"simulation.friction=0.2", "simulation.cell=lab"}});
  EXPECT_EQ(every_.simulation.cell, "lab");
  EXPECT_EQ(every_.simulation.foreign_objects, 2);
  EXPECT_EQ(every_.simulation.friction, 0.2);
  EXPECT_EQ(origin_of("simulation.foreign_objects", origins), "simulation.cell");
  EXPECT_EQ(origin_of("simulation.friction", origins), "flag --set");
  EXPECT_EQ(origin_of("simulation.regrip", origins), "default");
  EveryOption other;
  EXPECT_THROW((void)apply_options(fields(other), {"", {}, {"simulation.cell=moon"}}), InvalidArgument);
}

/// Plans know which gripper a named cell has, and can be given another.
TEST_F(OptionSourcesTest, ACellSetsTheGripperOfPlansToo) {
  const OptionOrigins origins = apply_options(list_, {"", {}, {"simulation.cell=lab"}});
  EXPECT_EQ(every_.simulation.linkage, "three_finger");
  EXPECT_EQ(every_.build.linkage, "three_finger");
  EXPECT_EQ(origin_of("gripper.linkage", origins), "simulation.cell");
  EveryOption apart;
  set_fields(fields(apart), {"simulation.cell=lab", "gripper.linkage=parallel"});
  EXPECT_EQ(apart.simulation.linkage, "three_finger");
  EXPECT_EQ(apart.build.linkage, "parallel");
  set_fields(fields(apart), {"simulation.cell=mild", "simulation.linkage=three_finger"});
  EXPECT_EQ(apart.build.linkage, "parallel") << "plans do not hear of the world";
  for (const std::string cell : {"hard", "paper"}) {
    set_fields(fields(apart), {"simulation.cell=" + cell});
    EXPECT_EQ(apart.build.linkage, "three_finger") << cell;
  }
}

TEST_F(OptionSourcesTest, ASecondCellTakesBackWhatTheFirstHadSet) {
  EveryOption run;
  set_fields(fields(run), {"simulation.cell=lab", "simulation.clearance=0.02"});
  EXPECT_EQ(run.simulation.table_height, 0.002);
  set_fields(fields(run), {"simulation.cell=mild"});
  EXPECT_EQ(run.simulation.table_height, 0.0);
  EXPECT_EQ(run.simulation.sensor, "sr300");
  EXPECT_EQ(run.simulation.clearance, 0.02) << "what somebody set stays";
}

TEST_F(OptionSourcesTest, AFileMayHoldOptionsOfOthersAndNoUnknownOnes) {
  FieldList search;
  for (const Field& field : list_)
    if (field.name.starts_with("search.")) search.push_back(field);
  (void)apply_options(search, {file_, {}, {}});
  EXPECT_EQ(every_.build.search.friction, 0.21);
  EXPECT_EQ(every_.build.max_stones, BuildOptions{}.max_stones);
  write_file(file_, "search: {frictoin: 0.2}\n");
  EXPECT_THROW((void)apply_options(search, {file_, {}, {}}), FileError);
  EXPECT_THROW((void)apply_options(list_, {"", {}, {"search.friction=-1"}}), InvalidArgument);
  ::setenv("STONESTACK_SEARCH_FRICTION", "rough", 1);
  EXPECT_THROW((void)apply_options(list_, {}), InvalidArgument);
}

TEST_F(OptionSourcesTest, JsonHasValueRangeUnitAndOrigin) {
  const FieldList list{field("length", every_.build.search.friction, {0.0, 2.0}, "m", "how long"),
                       field("free", every_.build.detection.seed, {}, "", "without bounds"),
                       field("name", every_.build.search.method, "of the method")};
  every_.build.search.friction = 0.5;
  const auto plain = nlohmann::json::parse(fields_json(list));
  EXPECT_EQ(plain.at("schema"), "stonestack.config/1");
  const auto& length = plain.at("options").at(0);
  EXPECT_EQ(length.at("name"), "length");
  EXPECT_EQ(length.at("value"), 0.5);
  EXPECT_EQ(length.at("range"), nlohmann::json({0.0, 2.0}));
  EXPECT_EQ(length.at("unit"), "m");
  EXPECT_FALSE(length.contains("origin"));
  EXPECT_TRUE(plain.at("options").at(1).at("range").at(0).is_null());
  EXPECT_FALSE(plain.at("options").at(2).contains("range"));
  const OptionOrigins origins{{"length", "flag --set"}};
  const auto commands = nlohmann::json::parse(fields_json(list, &origins));
  EXPECT_EQ(commands.at("options").at(0).at("origin"), "flag --set");
  EXPECT_EQ(commands.at("options").at(2).at("origin"), "default");
}

}  // namespace
}  // namespace stonestack::experiment
