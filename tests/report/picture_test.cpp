#include "report/picture.hpp"

#include <gtest/gtest.h>

#include <filesystem>

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

}  // namespace
}  // namespace stonestack::report
