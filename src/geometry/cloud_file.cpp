#include "stonestack/geometry/cloud.hpp"

#include <array>
#include <cmath>
#include <limits>

#include "geometry/byte_order.hpp"
#include "geometry/cloud_parse.hpp"
#include "geometry/mesh_parse.hpp"
#include "geometry/pcd.hpp"
#include "geometry/ply.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::geometry {
namespace {

constexpr std::size_t kMaxFile = 256U << 20U;
constexpr float kMaxCoordinate = 1e5F;

Cloud from_ply(const PlyContent& ply) {
  Cloud cloud;
  cloud.points.reserve(ply.points.size());
  for (const Eigen::Vector3d& p : ply.points) cloud.points.emplace_back(p.cast<float>());
  cloud.normals = ply.normals;
  const auto count = static_cast<std::int64_t>(cloud.points.size());
  const bool organised = ply.height > 1 && static_cast<std::int64_t>(ply.width) * ply.height == count;
  cloud.width = organised ? ply.width : static_cast<int>(count);
  cloud.height = organised ? ply.height : 1;
  return cloud;
}

/// Points with a NaN become gaps as a whole; anything else must be near.
void settle_gaps(const std::string& path, Cloud& cloud) {
  bool has_point = false;
  for (Eigen::Vector3f& p : cloud.points) {
    if (p.hasNaN()) {
      p.setConstant(std::numeric_limits<float>::quiet_NaN());
      continue;
    }
    if (!(p.cwiseAbs().maxCoeff() <= kMaxCoordinate))
      throw FileError(path, concat("has a point at (", p.transpose(), ")"),
                      concat("coordinates must be within ", kMaxCoordinate));
    has_point = true;
  }
  if (!has_point) throw FileError(path, "has no point with coordinates", "take the picture again");
}

std::string values_of(const Cloud& cloud) {
  std::string bytes;
  bytes.reserve(cloud.points.size() * (cloud.normals.empty() ? 12 : 24));
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    for (const float x : cloud.points[i]) append_little(bytes, x);
    if (cloud.normals.empty()) continue;
    for (const float x : cloud.normals[i]) append_little(bytes, x);
  }
  return bytes;
}

std::string ply_text(const Cloud& cloud) {
  std::string head = "ply\nformat binary_little_endian 1.0\ncomment stonestack\n";
  if (cloud.height > 1)
    head += concat("comment width ", cloud.width, "\ncomment height ", cloud.height, "\n");
  head += concat("element vertex ", cloud.points.size(),
                 "\nproperty float x\nproperty float y\nproperty float z\n");
  if (!cloud.normals.empty()) head += "property float nx\nproperty float ny\nproperty float nz\n";
  return head + "end_header\n" + values_of(cloud);
}

std::string pcd_text(const Cloud& cloud) {
  const bool has_normals = !cloud.normals.empty();
  const std::size_t height = cloud.height > 1 ? static_cast<std::size_t>(cloud.height) : 1;
  return concat("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z",
                has_normals ? " normal_x normal_y normal_z" : "", "\nSIZE 4 4 4", has_normals ? " 4 4 4" : "",
                "\nTYPE F F F", has_normals ? " F F F" : "", "\nCOUNT 1 1 1", has_normals ? " 1 1 1" : "",
                "\nWIDTH ", cloud.points.size() / height, "\nHEIGHT ", height,
                "\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS ", cloud.points.size(), "\nDATA binary\n") +
         values_of(cloud);
}

}  // namespace

Cloud parse_cloud(const std::string& path, const std::string& extension, std::string_view content) {
  if (extension != "ply" && extension != "pcd")
    throw FileError(path, concat("has the extension '", extension, "'"), "convert it to PLY or PCD");
  Cloud cloud = extension == "ply" ? from_ply(parse_ply(path, content)) : parse_pcd(path, content);
  settle_gaps(path, cloud);
  return cloud;
}

Cloud read_cloud(const std::string& path) {
  const std::string content = read_file(path, kMaxFile);
  if (content.empty()) throw FileError(path, "is empty", "make it again");
  return parse_cloud(path, lower_case_extension(path), content);
}

void write_cloud(const std::string& path, const Cloud& cloud) {
  const std::string extension = lower_case_extension(path);
  require(extension == "ply" || extension == "pcd", "clouds are written as .ply or .pcd, got '", path, "'");
  require(cloud.normals.empty() || cloud.normals.size() == cloud.points.size(), "a cloud of ",
          cloud.points.size(), " points has ", cloud.normals.size(), " normals");
  const auto pixels = static_cast<std::int64_t>(cloud.width) * cloud.height;
  require(cloud.height <= 1 || pixels == static_cast<std::int64_t>(cloud.points.size()), "a cloud of ",
          cloud.width, " x ", cloud.height, " has ", cloud.points.size(), " points");
  write_file(path, extension == "ply" ? ply_text(cloud) : pcd_text(cloud));
}

}  // namespace stonestack::geometry
