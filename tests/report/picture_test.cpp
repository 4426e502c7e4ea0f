#include "report/picture.hpp"

#include <gtest/gtest.h>
#include <png.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "report/drawn_arm.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/report/results.hpp"
#include "stonestack/stacking/observe.hpp"
#include "stonestack/stone/catalogue.hpp"

#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::report {
namespace {

View small_view() {
  View view;
  view.width = 120;
  view.height = 90;
  view.p_W_target = {0.7, 0.28, 0.05};
  return view;
}

double brightness(const Picture& picture, int column, int row) {
  const auto at = 3 * static_cast<std::size_t>(row * picture.width + column);
  return picture.rgb[at] + picture.rgb[at + 1] + picture.rgb[at + 2];
}

TEST(Picture, ShowsTheMeshWhereItIs) {
  const DrawnMesh red{make_box({0.1, 0.1, 0.1}), make_pose({0.7, 0.28, 0.05}), {0.9, 0.1, 0.1}};
  const Picture picture = draw({red}, small_view());
  const auto centre = 3 * static_cast<std::size_t>(45 * picture.width + 60);
  EXPECT_GT(picture.rgb[centre], 2 * picture.rgb[centre + 1]);
  EXPECT_LT(std::abs(picture.rgb[0] - picture.rgb[1]), 40) << "the corner shows table or sky";
}

TEST(Picture, CastsAShadow) {
  const View view = small_view();
  const Picture empty = draw({}, view);
  const Picture with =
      draw({{make_box({0.1, 0.1, 0.3}), make_pose({0.7, 0.28, 0.15}), {0.9, 0.9, 0.9}}}, view);
  int darker = 0;
  for (int row = 0; row < view.height; ++row)
    for (int column = 0; column < view.width; ++column)
      darker += brightness(with, column, row) < 0.7 * brightness(empty, column, row) ? 1 : 0;
  EXPECT_GT(darker, 50);
}

TEST(Picture, IsDeterministicAndWritesAPng) {
  const DrawnMesh box{make_box({0.1, 0.1, 0.1}), make_pose({0.7, 0.28, 0.05}), {0.9, 0.5, 0.1}};
  const Picture a = draw({box}, small_view());
  EXPECT_EQ(a.rgb, draw({box}, small_view()).rgb);
  const std::string path = test::temporary_folder() + "picture_test.png";
  write_png(path, a);
  const std::string bytes = read_file(path, 1 << 20);
  EXPECT_EQ(bytes.substr(1, 3), "PNG");
  std::filesystem::remove(path);
}

TEST(Picture, RefusesSenselessViews) {
  View view = small_view();
  view.width = 0;
  EXPECT_THROW((void)draw({}, view), InvalidArgument);
  view = small_view();
  view.p_W_eye = view.p_W_target + Eigen::Vector3d(0, 0, 1);
  EXPECT_THROW((void)draw({}, view), InvalidArgument);
}

/// Pixels of a PNG of the size of `picture`.
std::vector<std::uint8_t> pixels_of(const std::string& path, const Picture& picture) {
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, path.c_str()) == 0) return {};
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> pixels(PNG_IMAGE_SIZE(image));
  const bool same =
      static_cast<int>(image.width) == picture.width && static_cast<int>(image.height) == picture.height;
  if (png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr) == 0 || !same) return {};
  return pixels;
}

/// Compares a picture with the one that was accepted, in tests/data/pictures: at most 1 % of the values may
/// differ by more than 16 of 255. To accept new ones, draw them into that folder: STONESTACK_PICTURES=FOLDER.
void expect_as_accepted(const std::string& name, const Picture& drawn) {
  const char* kept = std::getenv("STONESTACK_PICTURES");  // a folder that they are to be written to, too
  const std::string now = (kept != nullptr ? std::string(kept) + "/" : test::temporary_folder()) + name;
  write_png(now, drawn);
  const std::vector<std::uint8_t> accepted =
      pixels_of(STONESTACK_SOURCE_DIR "/tests/data/pictures/" + name, drawn);
  ASSERT_EQ(accepted.size(), drawn.rgb.size()) << "no accepted picture of this size";
  std::size_t off = 0;
  for (std::size_t k = 0; k < accepted.size(); ++k)
    off += std::abs(static_cast<int>(accepted[k]) - static_cast<int>(drawn.rgb[k])) > 16 ? 1 : 0;
  EXPECT_LT(static_cast<double>(off), 0.01 * static_cast<double>(accepted.size())) << name;
}

View golden_view() {
  View view;
  view.width = 240;
  view.height = 180;
  return view;
}

TEST(GoldenPicture, StonesOnATable) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  std::vector<PlacedStone> stones;
  for (int k = 0; k < 3; ++k)
    stones.push_back({StoneIndex(k), make_pose(Eigen::Vector3d(0.5 + 0.2 * k, 0.28, 0.05))});
  View near = golden_view();
  near.p_W_eye = {0.85, -0.35, 0.4};
  near.p_W_target = {0.7, 0.28, 0.05};
  expect_as_accepted("stones.png", draw(drawn_stones(catalogue, stones), near));
}

TEST(GoldenPicture, TheArmWithItsGripper) {
  const RobotModel robot = read_robot("ur10");
  ArmPose pose;
  pose.q << 0.3, -1.6, 1.9, -1.8, -1.57, 0.0;
  View view = golden_view();
  view.p_W_eye = {2.2, -1.6, 1.2};
  view.p_W_target = {0.3, 0.1, 0.4};
  const CellLayout layout;
  expect_as_accepted(
      "arm.png",
      draw(drawn_arm(robot, stacking::gripper_of(layout), layout.T_W_R, layout.T_F_T, pose), view));
}

Stone box_stone(const std::string& name, const Eigen::Vector3d& size) {
  Stone stone;
  stone.name = name;
  stone.mesh = stone.scan = make_box(size);
  stone.mass = mass_properties(stone.scan, stone.density);
  return stone;
}

TEST(Picture, ATowerShowsWhereItsStonesTouch) {
  Catalogue catalogue;
  catalogue.stones = {box_stone("below", {0.12, 0.12, 0.1}), box_stone("above", {0.08, 0.08, 0.06})};
  const std::string path = test::temporary_folder() + "tower.png";
  const auto red_pixels = [&](double gap) {
    const std::vector<PlacedStone> tower = {{0_stone, make_pose(Eigen::Vector3d(0.7, 0.28, 0.05))},
                                            {1_stone, make_pose(Eigen::Vector3d(0.7, 0.28, 0.13 + gap))}};
    draw_tower(path, catalogue, tower, {0.7, 0.28});
    const std::vector<std::uint8_t> pixels = pixels_of(path, {1200, 900, {}});
    int red = 0;
    for (std::size_t k = 0; k + 2 < pixels.size(); k += 3)
      red += pixels[k] > 2 * pixels[k + 1] && pixels[k] > 2 * pixels[k + 2] ? 1 : 0;
    return red;
  };
  EXPECT_GT(red_pixels(0.0), 50) << "the corners of the upper box";
  EXPECT_EQ(red_pixels(0.01), 0) << "nothing touches";
  const auto clock = make_steady_clock();
  const TimeLimit over(1e-9, *clock);
  EXPECT_GT(red_pixels(0.0), 50) << "of a search that was interrupted, too";
}

}  // namespace
}  // namespace stonestack::report
