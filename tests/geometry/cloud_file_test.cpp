#include "stonestack/geometry/cloud.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "geometry/byte_order.hpp"
#include "geometry/cloud_parse.hpp"
#include "geometry/lzf.hpp"
#include "geometry/mutations.hpp"
#include "geometry/pcd.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::geometry {
namespace {

using ::testing::HasSubstr;

constexpr float kCloudFileNan = std::numeric_limits<float>::quiet_NaN();

Cloud organised_cloud() {
  Cloud cloud;
  cloud.width = 4;
  cloud.height = 3;
  for (int i = 0; i < 12; ++i) {
    const auto x = static_cast<float>(i);
    cloud.points.emplace_back(i == 5 ? Eigen::Vector3f::Constant(kCloudFileNan)
                                     : Eigen::Vector3f(x, 0.5F * x, 1.0F));
    cloud.normals.emplace_back(0, 0, 1);
  }
  return cloud;
}

bool same_point(const Eigen::Vector3f& p, const Eigen::Vector3f& q) {
  return p == q || (p.array().isNaN().all() && q.array().isNaN().all());
}

std::string problem(const std::string& extension, const std::string& content) {
  try {
    (void)parse_cloud("x." + extension, extension, content);
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

std::string written(const Cloud& cloud, const std::string& name) {
  const std::string path = test::temporary_folder() + name;
  write_cloud(path, cloud);
  const std::string content = read_file(path, 1 << 20);
  std::filesystem::remove(path);
  return content;
}

const char* const kHead = "VERSION .7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\n";

/// Two points, by field, in two literal runs and one back reference.
std::string compressed_pcd(const std::string& packed, std::uint32_t expanded) {
  std::string file = std::string(kHead) + "WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA binary_compressed\n";
  append_little(file, static_cast<std::uint32_t>(packed.size()));
  append_little(file, expanded);
  return file + packed;
}

std::string packed_points() {
  std::string values;
  for (const float x : {1.0F, 2.0F, 3.0F, 4.0F}) append_little(values, x);
  std::string packed(1, static_cast<char>(15));
  packed += values;  // x and y: 16 literals
  packed += static_cast<char>(((8 - 2) << 5) | 0);
  packed += static_cast<char>(16 - 1);  // z: 8 bytes from 16 back
  packed += static_cast<char>(0);
  packed += static_cast<char>(0);               // one literal 0
  packed += static_cast<char>(((7 - 2) << 5));  // and 7 copies of it
  packed += static_cast<char>(0);
  return packed;
}

TEST(CloudFile, RoundTripsOrganisedWithNormalsAndGaps) {
  const Cloud cloud = organised_cloud();
  for (const char* name : {"cloud_file_test.ply", "cloud_file_test.pcd"}) {
    const std::string path = test::temporary_folder() + name;
    write_cloud(path, cloud);
    const Cloud again = read_cloud(path);
    EXPECT_EQ(again.width, 4) << name;
    EXPECT_EQ(again.height, 3) << name;
    ASSERT_EQ(again.points.size(), 12U);
    for (std::size_t i = 0; i < 12; ++i)
      EXPECT_TRUE(same_point(again.points[i], cloud.points[i])) << name << i;
    EXPECT_EQ(again.normals, cloud.normals);
    std::filesystem::remove(path);
  }
}

TEST(CloudFile, PcdAsciiAndCompressedWithOtherFields) {
  const std::string ascii =
      std::string(kHead) +
      "WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n1 3 1 255\n2 4 2 7\n";
  for (const std::string& file : {ascii, compressed_pcd(packed_points(), 32)}) {
    const Cloud cloud = parse_cloud("x", "pcd", file);
    ASSERT_EQ(cloud.points.size(), 2U);
    EXPECT_EQ(cloud.points[0], Eigen::Vector3f(1, 3, 1));
    EXPECT_EQ(cloud.points[1], Eigen::Vector3f(2, 4, 2));
    EXPECT_TRUE(cloud.normals.empty());
  }
}

TEST(CloudFile, PcdOfOlderPclEndsWithZeros) {
  const std::string file = compressed_pcd(packed_points(), 32);
  const Cloud cloud = parse_cloud("x", "pcd", file + std::string(3901, '\0'));
  ASSERT_EQ(cloud.points.size(), 2U);
  EXPECT_EQ(cloud.points[1], Eigen::Vector3f(2, 4, 2));
  EXPECT_THAT(problem("pcd", file + std::string(3900, '\0') + "x"), HasSubstr("3901 bytes stand after"));
  EXPECT_THAT(problem("pcd", file + "x"), HasSubstr("1 bytes stand after"));
  std::string binary = std::string(kHead) + "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA binary\n";
  for (const float x : {1.0F, 2.0F, 3.0F, 0.0F}) append_little(binary, x);
  EXPECT_THAT(problem("pcd", binary), "");
  EXPECT_THAT(problem("pcd", binary + std::string(4, '\0')), HasSubstr("4 bytes stand after"))
      << "points that the header does not count";
}

TEST(CloudFile, LabelsOfAPcdFitTheirType) {
  const std::string head =
      "VERSION 0.7\nFIELDS x y z label\nSIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\n"
      "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA binary\n";
  const auto file = [&](std::uint32_t label) {
    std::string content = head;
    for (const float x : {1.0F, 2.0F, 3.0F}) append_little(content, x);
    append_little(content, label);
    return content;
  };
  EXPECT_EQ(parse_pcd_labels("a.pcd", file(2147483647U)), std::vector<int>{2147483647});
  EXPECT_THROW((void)parse_pcd_labels("a.pcd", file(2147483648U)), FileError);
}

TEST(CloudFile, ReadsThePublicCloudsOfPcl) {
  std::filesystem::path beside = STONESTACK_SOURCE_DIR;
  while (beside.has_relative_path() && !std::filesystem::exists(beside / "shared/real"))
    beside = beside.parent_path();
  int read = 0;
  for (const char* const part : {"mosd_learn", "pcl_milk"}) {
    const auto folder = beside / "shared/real" / part;
    if (!std::filesystem::exists(folder)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() != ".pcd") continue;
      EXPECT_GT(without_gaps(read_cloud(entry.path())).points.size(), 10000U) << entry.path();
      ++read;
    }
  }
  if (read == 0) GTEST_SKIP() << "no recordings beside the project";
}

TEST(CloudFile, RefusalsNameTheFault) {
  const std::string head = kHead;
  EXPECT_THAT(problem("pcd", head + "WIDTH 65536\nHEIGHT 65536\nPOINTS 0\nDATA binary\n"),
              HasSubstr("4294967296 points"));
  EXPECT_THAT(problem("pcd", "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3\n"), HasSubstr("no FIELDS"));
  EXPECT_THAT(problem("pcd", "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1000000000 1 1\n"),
              HasSubstr("1000000000"));
  EXPECT_THAT(problem("pcd", compressed_pcd(packed_points(), 0xfffffff0U)), HasSubstr("4294967280 bytes"));
  EXPECT_THAT(problem("pcd", compressed_pcd(packed_points().substr(1), 32)), HasSubstr("damaged"));
  EXPECT_THAT(problem("pcd", head + "WIDTH 20000000\nHEIGHT 1\nPOINTS 20000000\nDATA binary\n"),
              HasSubstr("too early"));
  EXPECT_THAT(problem("pcd", head + "WIDTH 3\nHEIGHT 1\nPOINTS 2\nDATA ascii\n"),
              HasSubstr("POINTS 2 is not"));
  EXPECT_THAT(problem("pcd", head + "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 inf 0\n"),
              HasSubstr("inf"));
  EXPECT_THAT(problem("pcd", head + "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\nnan 2 3 0\n"),
              HasSubstr("no point"));
  EXPECT_THAT(problem("pcd", "FIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 1\nDATA ascii\n1 2\n"),
              HasSubstr("lack"));
  EXPECT_THAT(problem("xyz", "1 2 3"), HasSubstr("'xyz'"));
  EXPECT_THROW((void)read_cloud("/nonexistent/a.pcd"), FileError);
  EXPECT_THROW(write_cloud("x.txt", organised_cloud()), InvalidArgument);
  Cloud wrong = organised_cloud();
  wrong.width = 7;
  EXPECT_THROW(write_cloud("x.pcd", wrong), InvalidArgument);
}

TEST(CloudFile, EveryTruncationIsRefused) {
  for (const char* extension : {"ply", "pcd"}) {
    const std::string whole = written(organised_cloud(), std::string("cut.") + extension);
    ASSERT_EQ(problem(extension, whole), "");
    for (std::size_t size = 0; size < whole.size(); ++size)
      EXPECT_NE(problem(extension, whole.substr(0, size)), "") << extension << " cut to " << size;
  }
  const std::string packed = compressed_pcd(packed_points(), 32);
  for (std::size_t size = 0; size < packed.size(); ++size)
    EXPECT_NE(problem("pcd", packed.substr(0, size)), "");
}

TEST(CloudFile, DamagedFilesGiveAnErrorOrACloud) {
  const std::pair<std::string, std::string> files[] = {
      {"ply", written(organised_cloud(), "damage.ply")},
      {"pcd", written(organised_cloud(), "damage.pcd")},
      {"pcd", compressed_pcd(packed_points(), 32)},
      {"pcd", std::string(kHead) + "WIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n1 3 1 255\n2 4 2 7\n"}};
  int refused = 0;
  for (const auto& [extension, whole] : files) {
    for (std::uint64_t i = 0; i < 4000; ++i) {
      Random random = Random::stream(13, i);
      try {
        const Cloud cloud = parse_cloud("x", extension, mutated(whole, random));
        ASSERT_EQ(static_cast<std::size_t>(cloud.width) * static_cast<std::size_t>(cloud.height),
                  cloud.points.size());
        for (const Eigen::Vector3f& p : cloud.points) ASSERT_TRUE(p.array().isNaN().all() || p.allFinite());
      } catch (const FileError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 6000);
}

TEST(Lzf, NeverLeavesItsBounds) {
  Random random = Random::stream(17, "lzf");
  for (int i = 0; i < 20000; ++i) {
    std::string packed(random.index(40), '\0');
    for (char& c : packed) c = static_cast<char>(random.index(256));
    const std::size_t expected = 1 + random.index(300);
    const std::string result = expand_lzf(packed, expected);
    EXPECT_TRUE(result.empty() || result.size() == expected);
  }
}

}  // namespace
}  // namespace stonestack::geometry
