#include "report/known_cells.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "rooms.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::report {
namespace {

class KnownCells : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder_);
    ::setenv("XDG_STATE_HOME", (folder_ + "/state").c_str(), 1);
    write_file(cell_, "robot: ur10\n");
  }
  void TearDown() override {
    ::unsetenv("XDG_STATE_HOME");
    std::filesystem::remove_all(folder_);
  }
  std::string folder_ = test::temporary_folder() + "known_cells";
  std::string cell_ = folder_ + "/lab.yaml";
};

TEST_F(KnownCells, AreKnownByPathAndContent) {
  EXPECT_FALSE(is_known_cell(cell_));
  note_known_cell(cell_);
  EXPECT_EQ(known_cells_path(), folder_ + "/state/stonestack/cells.json");
  EXPECT_TRUE(std::filesystem::exists(known_cells_path()));
  EXPECT_TRUE(is_known_cell(cell_));
  EXPECT_TRUE(
      is_known_cell(folder_ + "/../" + std::filesystem::path(folder_).filename().string() + "/lab.yaml"));
  write_file(folder_ + "/other.yaml", "robot: ur10\n");
  EXPECT_FALSE(is_known_cell(folder_ + "/other.yaml")) << "another cell with the same content";
  note_known_cell(folder_ + "/other.yaml");
  EXPECT_TRUE(is_known_cell(cell_)) << "both are kept";
  write_file(cell_, "robot: ur10\n# moved\n");
  EXPECT_FALSE(is_known_cell(cell_)) << "the cell has changed";
}

TEST_F(KnownCells, ADamagedMemoryKnowsNothingAndIsReplaced) {
  for (const char* damage : {"", "{", "[]", "{\"schema\": \"stonestack.cells/1\", \"cells\": 3}",
                             "{\"schema\": \"x\", \"cells\": {}}"}) {
    write_file(known_cells_path(), damage);
    EXPECT_FALSE(is_known_cell(cell_)) << damage;
    note_known_cell(cell_);
    EXPECT_TRUE(is_known_cell(cell_)) << damage;
  }
}

TEST_F(KnownCells, AMemoryThatCannotBeWrittenIsNoError) {
  write_file(folder_ + "/state", "a file in the way");
  note_known_cell(cell_);
  EXPECT_FALSE(is_known_cell(cell_));
}

}  // namespace
}  // namespace stonestack::report
