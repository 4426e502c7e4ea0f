#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stonestack/core/error.hpp"
#include "stonestack/experiment/experiment.hpp"

namespace stonestack::experiment {
namespace {

TEST(Shard, EveryRunIsInOneShard) {
  for (const int count : {1, 2, 3, 7})
    for (const int total : {1, 6, 7, 20}) {
      std::vector<int> shards_of_run(static_cast<std::size_t>(total), 0);
      for (int index = 1; index <= count; ++index) {
        const Shard shard{index, count};
        int runs = 0;
        for (int run = 1; run <= total; ++run) {
          if (!shard.has(run)) continue;
          EXPECT_EQ((run - 1) % count, index - 1);
          ++runs;
          ++shards_of_run[static_cast<std::size_t>(run - 1)];
        }
        EXPECT_EQ(shard.size(total), runs) << to_text(shard) << " of " << total;
      }
      EXPECT_THAT(shards_of_run, testing::Each(1)) << count << " shards of " << total;
    }
  EXPECT_TRUE(Shard().has(1) && Shard().has(2));
}

TEST(Shard, IsReadFromItsText) {
  const Shard shard = parse_shard("2/8");
  EXPECT_EQ(shard.index, 2);
  EXPECT_EQ(shard.count, 8);
  EXPECT_EQ(to_text(shard), "2/8");
  for (const char* text : {"", "2", "/", "0/3", "4/3", "-1/3", "0/0", "a/b", "1/", "/2", "1/2/3", "1/2x",
                           " 1/2", "+1/2", "1.0/2", "1/99999999999"})
    try {
      (void)parse_shard(text);
      ADD_FAILURE() << "read: " << text;
    } catch (const InvalidArgument& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(concat("'", text, "'")));
    }
}

}  // namespace
}  // namespace stonestack::experiment
