#include "stonestack/hardware/cell_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "hardware/cell_config.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/hand_eye.hpp"
#include "temporary_folder.hpp"

namespace stonestack::hardware {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class CellEdit : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = test::temporary_folder() + "cell_edit_" +
              testing::UnitTest::GetInstance()->current_test_info()->name() + "/";
    std::filesystem::create_directories(folder_);
    path_ = folder_ + "cell.yaml";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string text() const { return read_file(path_, 1 << 20); }
  [[nodiscard]] CellLayout layout() const {
    bool simulate = false;
    return to_layout(read_cell_file(path_, {field("simulate", simulate, "")}));
  }
  /// Writes the calibration into a file of that text; the file then says it, by T_T_C.
  std::string edited(const std::string& before) const {
    write_file(path_, before);
    write_mount(path_, T_F_C_);
    const CellLayout now = layout();
    EXPECT_TRUE((now.T_F_T * now.T_T_C).isApprox(T_F_C_, 1e-5)) << text();
    return text();
  }
  /// Lines that `edited` changed.
  static std::vector<std::string> changed_lines(const std::string& before, const std::string& after) {
    std::vector<std::string> old, changed;
    std::istringstream a(before), b(after);
    for (std::string line; std::getline(a, line);) old.push_back(line);
    for (std::string line; std::getline(b, line);)
      if (std::find(old.begin(), old.end(), line) == old.end()) changed.push_back(line);
    return changed;
  }

  std::string folder_, path_;
  Pose T_F_C_ = make_pose({0.012, -0.104, 0.0871234567}, Eigen::Quaterniond(0.95, 0.05, -0.1, 0.25));
};

TEST_F(CellEdit, ReplacesTheNumbersOfTheTemplateAndNothingElse) {
  const std::string before = read_file(data_path("cells/lab-ur10.yaml"), 1 << 20);
  const std::string after = edited(before);
  const auto changed = changed_lines(before, after);
  ASSERT_EQ(changed.size(), 1U) << after;
  EXPECT_THAT(changed[0], HasSubstr("  T_T_C: {x: 0.012, y: -0.104, z: -0.1768765, qx: "));
  EXPECT_THAT(changed[0], HasSubstr("}   # stonestack calibrate")) << "its comment stays";
  EXPECT_EQ(std::count(before.begin(), before.end(), '\n'), std::count(after.begin(), after.end(), '\n'));
}

TEST_F(CellEdit, WritesTheBaseAndNothingElse) {
  const Pose T_W_R = make_pose({0.001, -0.002, 0.0123}, Eigen::Quaterniond(0.9999, 0.01, -0.005, 0.0));
  const std::string before = read_file(data_path("cells/lab-ur10.yaml"), 1 << 20);
  for (const std::string& text :
       {before, before + "layout.T_W_R.z: 0.5  # of the base\n",
        std::string("layout:\n  T_W_R: {x: 0.1, qw: 1.0}  # base\n  site: {x: 0.5}\n"),
        std::string("robot: ur10\n")}) {
    write_file(path_, text);
    const CellLayout old = layout();
    EXPECT_THAT(write_base(path_, T_W_R), HasSubstr("layout.T_W_R: {x: 0.001, y: -0.002, z: 0.0123, qx: "));
    const CellLayout now = layout();
    EXPECT_TRUE(now.T_W_R.isApprox(T_W_R, 1e-5)) << this->text();
    EXPECT_TRUE(now.T_T_C.isApprox(old.T_T_C)) << this->text();
    EXPECT_EQ(now.site, old.site);
    EXPECT_LE(changed_lines(text, this->text()).size(), 8U) << this->text();
    const std::string written = this->text();
    write_base(path_, T_W_R);
    EXPECT_EQ(this->text(), written) << "twice is as once";
  }
  write_file(path_, "layout: &shared\n  T_W_R: &base {x: 0.0}\nother: *base\n");
  const std::string odd = text();
  EXPECT_THROW(write_base(path_, T_W_R), FileError);
  EXPECT_EQ(text(), odd);
  EXPECT_THROW(write_base(folder_ + "none.yaml", T_W_R), FileError);
}

TEST_F(CellEdit, EditsEveryManner) {
  const std::string comment = "# Größe: 3 µm – not ASCII, before what is edited\n";
  // maps in lines
  std::string after =
      edited(comment +
             "layout:\n  T_T_C:   # eye\n    x: 0.1  # 100 mm\n    y: 0\n    z: -0.17\n"
             "    qx: 0\n    qy: 0\n    qz: 0\n    qw: 1  # none\n  site: {x: 0.5}  # here\n");
  EXPECT_THAT(after, HasSubstr("    x: 0.012  # 100 mm\n"));
  EXPECT_THAT(after, HasSubstr("  # none\n  site: {x: 0.5}  # here\n"));
  // full names, as `config cell` prints them
  after = edited(comment + "layout.T_T_C.z: -0.17  # m\nlayout.T_T_C.qw: 1.0\nlayout.site.x: 0.5  # m\n");
  EXPECT_THAT(after, HasSubstr("layout.T_T_C.z: -0.1768765  # m\n"));
  EXPECT_THAT(after, HasSubstr("\nlayout.T_T_C.qx: "));
  EXPECT_THAT(after, HasSubstr("\nlayout.site.x: 0.5  # m\n"));
  // braces, some numbers left out, quotes
  after = edited(comment + "layout: {T_T_C: {x: '0.1', qw: \"1\"}, site: {x: 0.5}}  # all\n");
  EXPECT_THAT(after, HasSubstr("layout: {T_T_C: {x: 0.012, qw: "));
  EXPECT_THAT(after, HasSubstr("}, site: {x: 0.5}}  # all\n"));
  // over two lines
  after = edited("layout:\n  T_T_C: {x: 0.1, y: 0, z: 0, qx: 0,\n    qy: 0, qz: 0, qw: 1}   # calibrated\n");
  EXPECT_THAT(after, HasSubstr("}   # calibrated\n"));
}

TEST_F(CellEdit, AddsWhatIsNotThere) {
  EXPECT_THAT(edited("robot: ur10\nlayout:   # where\n  # the tower\n  site: {x: 0.5, y: 0.3}\n"),
              HasSubstr("layout:   # where\n  # the tower\n  T_T_C: {x: 0.012"));
  EXPECT_THAT(edited("layout: {site: {x: 0.5}}  # flow\n"), HasSubstr(", site: {x: 0.5}}  # flow\n"));
  EXPECT_THAT(edited("# nothing else\nrobot: ur10"), HasSubstr("robot: ur10\nlayout:\n  T_T_C: {x: 0.012"));
  EXPECT_THAT(edited("layout:\nrobot: ur5\n"), HasSubstr("robot: ur5\nlayout.T_T_C: {"));
  EXPECT_THAT(edited("{robot: ur5}\n"), HasSubstr("robot: ur5}"));
  EXPECT_EQ(edited("").substr(0, 8), "layout:\n");
}

TEST_F(CellEdit, NamesTheFileOfTheCalibration) {
  EasyHandEye calibration;
  calibration.T_A_C = T_F_C_;
  const auto named = [&](const std::string& file, const std::string& before) {
    write_easy_handeye(file, calibration);
    write_file(path_, before);
    write_mount(path_, T_F_C_, file);
    const CellLayout now = layout();
    EXPECT_TRUE((now.T_F_T * now.T_T_C).isApprox(T_F_C_, 1e-6)) << text();
    return text();
  };
  const std::string tip = "  T_F_T: {z: 0.3}\n";
  EXPECT_EQ(named(folder_ + "eye.yaml", "layout:  # lab\n" + tip),
            "layout:  # lab\n  hand_eye: eye.yaml\n" + tip);
  EXPECT_EQ(named(folder_ + "eyes/my eye.yaml", "layout:\n  hand_eye: old.yaml  # mine\n" + tip),
            "layout:\n  hand_eye: 'eyes/my eye.yaml'  # mine\n" + tip);
  const std::string outside = test::temporary_folder() + "cell_edit_outside.yaml";
  EXPECT_THAT(named(outside, "robot: ur10\n"), HasSubstr("hand_eye: " + outside));
  std::filesystem::remove(outside);
  // Without a file the pose takes the place of the name; a cell that has the pose keeps it.
  EXPECT_THAT(edited("layout: {hand_eye: eye.yaml, site: {x: 0.5}}\n"),
              HasSubstr("layout: {T_T_C: {x: 0.012"));
  EXPECT_THAT(named(folder_ + "eye.yaml", "layout:\n  T_T_C: {x: 0.1}\n"), Not(HasSubstr("hand_eye")));
}

TEST_F(CellEdit, LeavesAloneWhatItCannotEdit) {
  const auto refused = [&](const std::string& before) -> std::string {
    write_file(path_, before);
    try {
      write_mount(path_, T_F_C_);
    } catch (const FileError& problem) {
      EXPECT_EQ(text(), before);
      return problem.what();
    }
    ADD_FAILURE() << text();
    return "";
  };
  const std::string shared = "&zero 0.0";
  EXPECT_THAT(refused("layout:\n  T_T_C: {x: " + shared + ", y: *zero, z: -0.1}\n  T_W_R: {x: *zero}\n"),
              HasSubstr("write below `layout`: T_T_C: {x: 0.012"));
  EXPECT_THAT(refused("robot: ur10\n...\n"), HasSubstr("write below `layout`"));
  EXPECT_THAT(refused("layout: {T_T_C: {x: 0.1}, hand_eye: eye.yaml}\n"), HasSubstr("the same thing"));
  EXPECT_THAT(refused("layout: {T_F_T: {z: 99}}\n"), HasSubstr("layout.T_F_T.z"));
  EXPECT_THAT(refused("layout: [1,\n"), HasSubstr("not YAML"));
  EXPECT_THROW(write_mount(folder_ + "none.yaml", T_F_C_), FileError);
}

TEST_F(CellEdit, KeepsRightsAndLinks) {
  namespace fs = std::filesystem;
  write_file(folder_ + "real.yaml", "robot: ur10\n");
  fs::permissions(folder_ + "real.yaml", fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink("real.yaml", path_);
  write_mount(path_, T_F_C_);
  EXPECT_TRUE(fs::is_symlink(path_));
  EXPECT_THAT(read_file(folder_ + "real.yaml", 1 << 20), HasSubstr("T_T_C"));
  EXPECT_EQ(fs::status(path_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

}  // namespace
}  // namespace stonestack::hardware
