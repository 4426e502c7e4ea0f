// A run whose stones nobody scanned asks before each motion, and says how it ended.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "rooms.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/report/record_run.hpp"
#include "temporary_folder.hpp"

namespace stonestack::report {
namespace {

using ::testing::HasSubstr;

class UnseenRun : public testing::Test {
 protected:
  UnseenRun() {
    order_.robot = read_robot("ur10");
    order_.per_run = 2;
    order_.run.build.unseen = true;
    order_.out =
        test::temporary_folder() + "unseen_" + testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(order_.out);
  }
  ~UnseenRun() override { std::filesystem::remove_all(order_.out); }

  RunOrder order_;
  Catalogue catalogue_ = read_catalogue(data_path("stones"));
};

TEST_F(UnseenRun, NothingMovesThatIsNotAllowed) {
  int asked = 0;
  std::string first;
  order_.before_motion = [&](const PlannedStep& step) {
    if (asked++ == 0) first = step.name;
    return false;
  };
  const RecordedRun done = record_run(order_, catalogue_);
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(first, "move to a view");
  EXPECT_EQ(done.report.result.end, RunEnd::kInterrupted);
  EXPECT_FALSE(done.report.modelling.has_value());
}

TEST_F(UnseenRun, KnownStonesAreAskedForWithUnknownOnesAndKeptWhereTheyAre) {
  order_.known = data_path("stones");
  order_.save_catalogue = order_.known;
  EXPECT_THAT([&] { (void)record_run(order_, catalogue_); },
              testing::ThrowsMessage<InvalidArgument>(HasSubstr("save to another one")));
  order_.save_catalogue.clear();
  order_.run.build.unseen = false;
  EXPECT_THAT([&] { (void)record_run(order_, catalogue_); },
              testing::ThrowsMessage<InvalidArgument>(HasSubstr("--catalogue in place of --known")));
  order_.run.build.unseen = true;
  order_.known = "/no/such/folder";
  EXPECT_THROW((void)record_run(order_, catalogue_), FileError);
  EXPECT_FALSE(std::filesystem::exists(order_.out)) << "refused before anything is begun";
}

TEST_F(UnseenRun, EachMotionOfModellingIsAskedForAndInTheJournal) {
  order_.before_motion = [](const PlannedStep& step) { return step.name == "move to a view"; };
  const RecordedRun done = record_run(order_, catalogue_);
  EXPECT_EQ(done.report.result.end, RunEnd::kInterrupted);
  const std::string journal = read_file(done.folder + "/journal.jsonl", 1 << 22);
  EXPECT_THAT(journal, HasSubstr("move to a view"));
  ASSERT_TRUE(done.report.modelling.has_value()) << "the models from the first views are kept";
  EXPECT_EQ(done.report.modelling->stones.size(), 2U);
  EXPECT_EQ(read_catalogue(done.folder + "/stones").stones.size(), 2U);
}

}  // namespace
}  // namespace stonestack::report
