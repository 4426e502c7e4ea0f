#include "benchmarks/results_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::bench {
namespace {

using ::testing::HasSubstr;

class ResultsPage : public testing::Test {
 protected:
  ResultsPage()
      : folder_((std::filesystem::temp_directory_path() / concat("results_page_", ::getpid())).string()) {
    std::filesystem::remove_all(folder_);
  }
  ~ResultsPage() override { std::filesystem::remove_all(folder_); }

  /// Writes a section of one row with these values and this text.
  void write(const std::string& values, const std::string& figure = "{a}") const {
    write_file(
        folder_ + "/1.json",
        concat(
            R"({"schema": "stonestack.results/1", "section": "Search", "rows": [{"what": "height", "figure": ")",
            figure, R"(", "values": )", values,
            R"(, "command": "bench search --seed 1", "version": "0.1.0"}]})"));
  }
  [[nodiscard]] std::string page() const { return results_page(folder_); }

  std::string folder_;
};

TEST(ResultsDocument, IsWhatTheRecordsGive) {
  const std::string docs = STONESTACK_SOURCE_DIR "/docs/";
  EXPECT_EQ(results_page(docs + "results"), read_file(docs + "results.md", 1U << 20U))
      << "run ./dev bench results > docs/results.md";
}

TEST_F(ResultsPage, StatesFigureMarkAndCommand) {
  write(R"({"a": {"value": 3.96, "decimals": 1, "unit": "m", "min": 3.8}})");
  EXPECT_THAT(page(), HasSubstr("## Search\n"));
  EXPECT_THAT(page(), HasSubstr("| height | 4.0 m | at least 3.8 m | `bench search --seed 1` | 0.1.0 |"));
}

TEST_F(ResultsPage, AFigureOutsideItsMarkIsBold) {
  write(R"({"a": {"value": 3.7, "min": 3.8}})");
  EXPECT_THAT(page(), HasSubstr("| **3.7** | at least 3.8 |"));
  write(R"({"a": {"value": 5, "max": 0}})");
  EXPECT_THAT(page(), HasSubstr("| **5** | at most 0 |"));
}

TEST_F(ResultsPage, AMarkOfACountIsAShare) {
  write(R"({"a": {"value": 95, "of": 100, "min": 0.95}})");
  EXPECT_THAT(page(), HasSubstr("| 95 of 100 | at least 95 % |"));
  write(R"({"a": {"value": 94, "of": 100, "min": 0.95}})");
  EXPECT_THAT(page(), HasSubstr("| **94 of 100** | at least 95 % |"));
}

TEST_F(ResultsPage, OneMarkStandsForSeveralEqualOnes) {
  write(R"({"a": {"value": 1, "max": 2}, "b": {"value": 3, "max": 2}})", "{a}, {b}");
  EXPECT_THAT(page(), HasSubstr("| 1, **3** | at most 2 |"));
  write(R"({"a": {"value": 1, "max": 2}, "b": {"value": 3}})", "{a}, {b}");
  EXPECT_THAT(page(), HasSubstr("| 1, 3 | at most 2, - |"));
}

TEST_F(ResultsPage, AValueComesFromTheRecordOfABenchmark) {
  write_file(folder_ + "/records/search.json", R"({"tables": [{"rows": [{"height": 3.25}]}]})");
  write(R"({"a": {"value": {"record": "records/search.json", "at": "/tables/0/rows/0/height"}}})");
  EXPECT_THAT(page(), HasSubstr("| 3.25 |"));
  write(R"({"a": {"value": {"record": "records/search.json", "at": "/tables/1"}}})");
  EXPECT_THROW((void)page(), FileError);
}

TEST_F(ResultsPage, RefusesWhatItCannotPrint) {
  EXPECT_THROW((void)page(), FileError) << "no records";
  write(R"({"a": {"value": 1}})", "{b}");
  EXPECT_THROW((void)page(), FileError) << "a name without a value";
  write(R"({"a": {"value": 1}, "b": {"value": 1}})");
  EXPECT_THROW((void)page(), FileError) << "a value that is not printed";
  write(R"({"a": {"value": "many"}})");
  EXPECT_THROW((void)page(), FileError);
  write(R"({"a": {"value": 1}})", "{a");
  EXPECT_THROW((void)page(), FileError);
}

}  // namespace
}  // namespace stonestack::bench
