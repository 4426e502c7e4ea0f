#include "stonestack/geometry/mesh.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "geometry/byte_order.hpp"
#include "geometry/mesh_parse.hpp"
#include "geometry/mutations.hpp"
#include "geometry/rough_stone.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::geometry {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const char* const kPyramid =
    "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 5\nproperty float x\nproperty float y\n"
    "property float z\nelement face 5\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 0.5 1\n4 0 3 2 1\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string mesh_problem(const std::string& extension, const std::string& content) {
  try {
    (void)parse_mesh("x." + extension, extension, content);
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

std::string binary_stl(const Mesh& mesh) {
  std::string file(80, ' ');
  file.replace(0, 5, "solid");  // as some programs write it
  append_little(file, static_cast<std::uint32_t>(mesh.faces.size()));
  for (const Eigen::Vector3i& face : mesh.faces) {
    for (int k = 0; k < 3; ++k) append_little(file, 0.0F);
    for (const int corner : face)
      for (const double x : mesh.vertices[static_cast<std::size_t>(corner)])
        append_little(file, static_cast<float>(x));
    append_little(file, std::uint16_t{0});
  }
  return file;
}

std::string ascii_stl(const Mesh& mesh) {
  std::string file = "solid a stone\n";
  for (const Eigen::Vector3i& face : mesh.faces) {
    file += " facet normal 0 0 0\n  outer loop\n";
    for (const int corner : face)
      file += concat("   vertex ", mesh.vertices[static_cast<std::size_t>(corner)].transpose(), "\n");
    file += "  endloop\n endfacet\n";
  }
  return file + "endsolid a stone\n";
}

std::string written(const Mesh& mesh, const std::string& name) {
  const std::string path = test::temporary_folder() + name;
  write_mesh(path, mesh);
  const std::string content = read_file(path, 1 << 26);
  std::filesystem::remove(path);
  return content;
}

TEST(MeshFile, RoundTripsExactly) {
  const Mesh stone = make_rough_stone(1);
  for (const char* name : {"mesh_file_test.ply", "mesh_file_test.obj"}) {
    const std::string path = test::temporary_folder() + name;
    write_mesh(path, stone);
    const Mesh again = read_mesh(path);
    EXPECT_EQ(again.vertices, stone.vertices) << name;
    EXPECT_EQ(again.faces, stone.faces) << name;
    std::filesystem::remove(path);
  }
  EXPECT_THROW(write_mesh("x.stl", stone), InvalidArgument);
}

TEST(MeshFile, PlyOfEveryKind) {
  EXPECT_NEAR(volume(parse_mesh("x", "ply", kPyramid)), 1.0 / 3.0, 1e-6);
  std::string crlf;
  for (const char* c = kPyramid; *c != '\0'; ++c)
    crlf += *c == '\n' ? std::string("\r\n") : std::string(1, *c);
  EXPECT_NEAR(volume(parse_mesh("x", "ply", crlf)), 1.0 / 3.0, 1e-6);
}

TEST(MeshFile, PlyBigEndianWithUnknownElements) {
  std::string file =
      "ply\nformat binary_big_endian 1.0\nelement camera 1\nproperty float view\nproperty list uchar short "
      "more\n"
      "element vertex 4\nproperty uchar red\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 4\nproperty list uchar uint vertex_index\nproperty uchar flag\nend_header\n";
  const auto big = [&](auto value) {
    std::string bytes;
    append_little(bytes, value);
    file.append(bytes.rbegin(), bytes.rend());
  };
  big(1.5F);
  big(std::uint8_t{2});
  big(std::int16_t{7});
  big(std::int16_t{8});
  for (const Eigen::Vector3f& p : {Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(1, 0, 0),
                                   Eigen::Vector3f(0, 1, 0), Eigen::Vector3f(0, 0, 1)}) {
    big(std::uint8_t{255});
    for (const float x : p) big(x);
  }
  for (const Eigen::Vector3i& f : {Eigen::Vector3i(0, 2, 1), Eigen::Vector3i(0, 1, 3),
                                   Eigen::Vector3i(0, 3, 2), Eigen::Vector3i(1, 2, 3)}) {
    big(std::uint8_t{3});
    for (const int corner : f) big(static_cast<std::uint32_t>(corner));
    big(std::uint8_t{0});
  }
  const Mesh corner = parse_mesh("x", "ply", file);
  EXPECT_NEAR(volume(corner), 1.0 / 6.0, 1e-12);
  EXPECT_THAT(mesh_problem("ply", file + "x"), HasSubstr("after the last element"));
}

TEST(MeshFile, StlIsWeldedBothWays) {
  const Mesh box = make_box({0.25, 0.5, 1.0});
  for (const std::string& file : {binary_stl(box), ascii_stl(box)}) {
    const Mesh read = parse_mesh("x", "stl", file);
    EXPECT_EQ(read.vertices.size(), 8U);
    EXPECT_TRUE(is_closed(read));
    EXPECT_NEAR(volume(read), 0.125, 1e-9);
  }
}

TEST(MeshFile, ObjWithColoursSeamsAndNegativeIndices) {
  const std::string file =
      "mtllib /etc/passwd\nv 0 0 0 0.1 0.2 0.3\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 0\nvt 0 0\nusemtl x\n"
      "f 1 3 2\nf -1/1 2/1 4/1\r\nf 5//1 4//1 3//1\n# the seam repeats vertex 1\nf 2/1/1 3/1/1 4/1/1\n";
  const Mesh corner = parse_mesh("x", "obj", file);
  EXPECT_EQ(corner.vertices.size(), 4U);
  EXPECT_TRUE(is_closed(corner));
  EXPECT_NEAR(volume(corner), 1.0 / 6.0, 1e-12);
}

TEST(MeshFile, RefusalsNameTheFault) {
  const std::string ply = kPyramid;
  EXPECT_THAT(mesh_problem("ply", replaced(ply, "vertex 5", "vertex 2000000000")),
              AllOf(HasSubstr("2000000000"), HasSubstr("truncated")));
  EXPECT_THAT(mesh_problem("ply", replaced(ply, "3 3 0 4", "3 3 0 5")), HasSubstr("from 0 to 4, got 5"));
  EXPECT_THAT(mesh_problem("ply", replaced(ply, "3 3 0 4", "3 3 0 -5")), HasSubstr("got -5"));
  EXPECT_THAT(mesh_problem("ply", replaced(ply, "0.5 0.5", "nan 0.5")), HasSubstr("finite"));
  EXPECT_THAT(mesh_problem("ply", replaced(ply, "0.5 0.5", "1e400 0.5")), HasSubstr("1e400"));
  EXPECT_THAT(mesh_problem("ply", replaced(ply, "0.5 0.5", "0,5 0.5")),
              HasSubstr("line 15: '0,5' is not a number"));
  EXPECT_THAT(mesh_problem("ply", replaced(ply, "0.5 0.5", "200000 0.5")), HasSubstr("within 100000"));
  EXPECT_THAT(mesh_problem("ply", replaced(ply, "float x", "list uchar float x")),
              HasSubstr("list property"));
  EXPECT_THAT(mesh_problem("ply", ply.substr(0, ply.size() - 6)), HasSubstr("ends too early"));
  EXPECT_THAT(mesh_problem("ply", "solid"), HasSubstr("begin with 'ply'"));
  EXPECT_THAT(mesh_problem("stl", std::string(14, 'a')), HasSubstr("14 bytes"));
  EXPECT_THAT(mesh_problem("stl", std::string(80, ' ') + "\xff\xff\xff\xff"), HasSubstr("4294967295 faces"));
  EXPECT_THAT(mesh_problem("stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0"),
              HasSubstr("too early"));
  EXPECT_THAT(mesh_problem("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
              HasSubstr("vertex 4, but there are 3"));
  EXPECT_THAT(mesh_problem("obj", "v 0 0 0\nf 1 1 1\n"), HasSubstr("three different corners"));
  EXPECT_THAT(mesh_problem("obj", "v 0 0 inf\n"), HasSubstr("line 1: 'inf' is not finite"));
  EXPECT_THAT(mesh_problem("obj", "v 0 0 0\nf 0 1 1\n"), HasSubstr("'0' is not a vertex index"));
  EXPECT_THAT(mesh_problem("obj", "v 0 0 0\n"), HasSubstr("no faces"));
  EXPECT_THROW((void)read_mesh("/nonexistent/a.ply"), FileError);
}

TEST(MeshFile, EveryTruncationIsRefused) {
  const Mesh box = make_box({1, 2, 3});
  const std::pair<std::string, std::string> files[] = {
      {"ply", written(box, "cut.ply")}, {"stl", binary_stl(box)}, {"stl", ascii_stl(box)}};
  for (const auto& [extension, whole] : files) {
    ASSERT_EQ(mesh_problem(extension, whole), "");
    for (std::size_t size = 0; size + 2 < whole.size(); ++size) {
      if (whole.substr(size).find_first_not_of("endsolid a stone\n") == std::string::npos) break;
      EXPECT_NE(mesh_problem(extension, whole.substr(0, size)), "") << extension << " cut to " << size;
    }
  }
}

TEST(MeshFile, DamagedFilesGiveAnErrorOrAMesh) {
  const Mesh box = make_box({1, 2, 3});
  const std::pair<std::string, std::string> files[] = {{"ply", kPyramid},
                                                       {"ply", written(box, "damage.ply")},
                                                       {"stl", binary_stl(box)},
                                                       {"stl", ascii_stl(box)},
                                                       {"obj", written(box, "damage.obj")}};
  int refused = 0;
  for (const auto& [extension, whole] : files) {
    for (std::uint64_t i = 0; i < 4000; ++i) {
      Random random = Random::stream(11, i);
      try {
        const Mesh mesh = parse_mesh("x", extension, mutated(whole, random));
        for (const Eigen::Vector3d& p : mesh.vertices) ASSERT_LE(p.cwiseAbs().maxCoeff(), 1e5);
        for (const Eigen::Vector3i& face : mesh.faces) {
          ASSERT_GE(face.minCoeff(), 0);
          ASSERT_LT(static_cast<std::size_t>(face.maxCoeff()), mesh.vertices.size());
        }
      } catch (const FileError&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 8000);
}

}  // namespace
}  // namespace stonestack::geometry
