#include "stonestack/stone/catalogue.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/geometry/mesh.hpp"
#include "stonestack/stone/model_stone.hpp"
#include "temporary_folder.hpp"

namespace stonestack::stone {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// A catalogue with a box of 10 x 8 x 6 cm, in a folder of its own, and functions that corrupt it.
class CatalogueTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        test::temporary_folder() + concat("catalogue_test_", ::getpid(), "_",
                                          testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    write_stone(folder_, box_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string file(const std::string& name) const { return folder_ + "/box/" + name; }
  /// Replaces the value of a key in stone.yaml.
  void set(const std::string& key, const std::string& value) const {
    std::string text = read_file(file("stone.yaml"), 1 << 20);
    const auto at = text.find("\n" + key + ": ") + 1;
    text.replace(at, text.find('\n', at) - at, key + ": " + value);
    write_file(file("stone.yaml"), text);
  }
  [[nodiscard]] std::string problem() const {
    try {
      (void)read_catalogue(folder_);
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  }

  const Stone box_ = model_stone(make_box({0.10, 0.08, 0.06}), "box", "box.obj").stone;
  std::string folder_;
};

TEST_F(CatalogueTest, GivesBackWhatWasWritten) {
  Stone stone = model_stone(make_limestone(9), "limestone_9", "generated: \"limestone\", seed 9").stone;
  write_stone(folder_, stone);
  const Catalogue catalogue = read_catalogue(folder_);
  ASSERT_EQ(catalogue.stones.size(), 2U);
  EXPECT_EQ(catalogue.stones[0].name, "box");
  const Stone& again = catalogue[catalogue.index("limestone_9")];
  EXPECT_EQ(again.source, stone.source);
  EXPECT_EQ(again.mass.mass, stone.mass.mass);
  EXPECT_EQ(again.mass.p_O_M, stone.mass.p_O_M);
  EXPECT_EQ(again.mass.I_M, stone.mass.I_M);
  EXPECT_EQ(again.density, stone.density);
  EXPECT_EQ(again.friction, stone.friction);
  EXPECT_EQ(again.scale, stone.scale);
  EXPECT_EQ(again.contact_deviation.worst, stone.contact_deviation.worst);
  EXPECT_TRUE(again.T_O_file.isApprox(stone.T_O_file, 1e-12));
  EXPECT_EQ(again.mesh.faces, stone.mesh.faces);
  EXPECT_EQ(again.scan.faces, stone.scan.faces);
  EXPECT_EQ(again.pieces.size(), stone.pieces.size());
  for (std::size_t v = 0; v < stone.scan.vertices.size(); ++v)
    ASSERT_LT((again.scan.vertices[v] - stone.scan.vertices[v]).norm(), 1e-7);
}

TEST_F(CatalogueTest, KeepsHowWellASurfaceIsKnown) {
  Stone stone = box_;
  SurfaceKnowledge known;
  for (std::size_t v = 0; v < stone.scan.vertices.size(); ++v) {
    known.sigma.push_back(0.001 / static_cast<double>(v + 1));
    known.seen.push_back(v % 2 == 0 ? 1 : 0);
  }
  known.up_O_at_rest = {Eigen::Vector3d(0.6, 0.0, 0.8)};
  stone.surface = known;
  write_stone(folder_, stone);
  const Stone again = read_catalogue(folder_).stones[0];
  ASSERT_TRUE(again.surface.has_value());
  EXPECT_EQ(again.surface->sigma, known.sigma);
  EXPECT_EQ(again.surface->seen, known.seen);
  ASSERT_EQ(again.surface->up_O_at_rest.size(), 1U);
  EXPECT_LT((again.surface->up_O_at_rest[0] - known.up_O_at_rest[0]).norm(), 1e-15);
  write_stone(folder_, box_);
  EXPECT_FALSE(read_catalogue(folder_).stones[0].surface.has_value()) << "that of the old stone is gone";
}

TEST_F(CatalogueTest, NamesWhatIsWrongWithTheFileOfASurface) {
  const std::string head = R"({"schema": "stonestack.surface/1", )";
  std::string sigmas = "[0", marks = "[1";
  for (std::size_t v = 1; v < box_.scan.vertices.size(); ++v) sigmas += ", 0.001", marks += ", 0";
  sigmas += "]", marks += "]";
  const auto says = [&](const std::string& text) {
    write_file(file("surface.json"), text);
    return problem();
  };
  const std::string good = R"("sigma_m": )" + sigmas + R"(, "seen": )" + marks;
  EXPECT_EQ(says(head + good + R"(, "up_at_rest": [[0, 0, 1]]})"), "");
  EXPECT_THAT(says("{"), HasSubstr("surface.json"));
  EXPECT_THAT(says("[]"), HasSubstr("surface.json"));
  EXPECT_THAT(says(R"({"schema": "stonestack.surface/2"})"), HasSubstr("schema"));
  EXPECT_THAT(says(head + R"("sigma_m": [0.1], "seen": [1], "up_at_rest": []})"),
              HasSubstr("sigma_m is not"));
  EXPECT_THAT(says(head + good + R"(, "up_at_rest": [[0, 0, 2]]})"), HasSubstr("length 2"));
  EXPECT_THAT(says(head + good + R"(, "up_at_rest": [[0, 1]]})"), HasSubstr("3 finite numbers"));
  EXPECT_THAT(says(head + good + "}"), HasSubstr("up_at_rest"));
  std::string negative = good;
  negative.replace(negative.find("[0,"), 3, "[-1,");
  EXPECT_THAT(says(head + negative + R"(, "up_at_rest": []})"), HasSubstr("-1 m"));
  std::string text = good;
  text.replace(text.find("[0,"), 3, "[\"a\",");
  EXPECT_THAT(says(head + text + R"(, "up_at_rest": []})"), HasSubstr("sigma_m is not"));
  fs::remove(file("surface.json"));
  fs::create_symlink("surface.json", file("surface.json"));  // leads to itself
  EXPECT_THAT(problem(), HasSubstr("surface.json"));
}

TEST_F(CatalogueTest, ReplacesAStoneWholeAndLeavesNothingElse) {
  Stone heavier = box_;
  heavier.mass.mass *= 1.1;
  write_stone(folder_, heavier);
  EXPECT_EQ(read_catalogue(folder_).stones[0].mass.mass, heavier.mass.mass);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(CatalogueTest, LeavesNothingWhenItCannotWrite) {
  write_file(folder_ + "/file", "");
  EXPECT_THROW(write_stone(folder_ + "/file", box_), FileError);
  EXPECT_EQ(fs::file_size(folder_ + "/file"), 0U);
  Stone stray = box_;
  stray.name = "../stray";
  EXPECT_THROW(write_stone(folder_, stray), InvalidArgument);
}

TEST_F(CatalogueTest, NamesTheNearestStone) {
  try {
    (void)read_catalogue(folder_).index("bix");
    FAIL();
  } catch (const InvalidArgument& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("'bix'"), HasSubstr("'box'")));
  }
}

TEST_F(CatalogueTest, RefusesAFolderWithoutStones) {
  EXPECT_THROW((void)read_catalogue(folder_ + "/nowhere"), FileError);
  EXPECT_THROW((void)read_catalogue(file("stone.yaml")), FileError);
  fs::remove_all(folder_ + "/box");
  write_file(folder_ + "/README.md", "no stone");
  fs::create_directories(folder_ + "/.half.part-1");
  EXPECT_THAT(problem(), AllOf(HasSubstr("holds no stones"), HasSubstr("stonestack scan")));
}

TEST_F(CatalogueTest, RefusesMissingFiles) {
  for (const char* name : {"stone.yaml", "mesh.ply", "scan.ply", "pieces/1.ply"}) {
    fs::rename(file(name), file("elsewhere"));
    EXPECT_THAT(problem(), HasSubstr(file(name)));
    fs::rename(file("elsewhere"), file(name));
  }
  EXPECT_EQ(problem(), "");
}

TEST_F(CatalogueTest, RefusesValuesThatCannotBe) {
  const std::pair<const char*, const char*> cases[] = {
      {"mass", "0"},
      {"mass", ".nan"},
      {"mass", "-1"},
      {"mass", "heavy"},
      {"density", "0"},
      {"friction", "0"},
      {"friction", ".inf"},
      {"scale", "0"},
      {"faces", "501"},
      {"faces", "12.5"},
      {"pieces", "2"},
      {"name", "other"},
      {"schema", "stonestack.stone/2"},
      {"centre_of_mass", "{x: 0.06, y: 0, z: 0}"},
      {"centre_of_mass", "{x: .nan, y: 0, z: 0}"},
      {"centre_of_mass", "{x: 0, y: 0}"},
      {"inertia", "{xx: 1, yy: 1, zz: 9, xy: 0, xz: 0, yz: 0}"},
      {"inertia", "{xx: 0, yy: 0, zz: 0, xy: 0, xz: 0, yz: 0}"},
      {"inertia", "{xx: 1, yy: 1, zz: 1, xy: 0, xz: 0, yz: 0}"},
      {"T_O_file", "{x: 0, y: 0, z: 0, qx: 0, qy: 0, qz: 0, qw: 0}"},
      {"mesh_deviation", "{median: 0}"},
  };
  const std::string good = read_file(file("stone.yaml"), 1 << 20);
  for (const auto& [key, value] : cases) {
    set(key, value);
    EXPECT_THAT(problem(), AllOf(HasSubstr("/box/"), HasSubstr(key), HasSubstr("; ")))
        << key << ": " << value;
    write_file(file("stone.yaml"), good);
  }
  write_file(file("stone.yaml"), good + "colour: grey\n");
  EXPECT_THAT(problem(), HasSubstr("colour"));
  EXPECT_EQ((write_file(file("stone.yaml"), good), problem()), "");
}

TEST_F(CatalogueTest, RefusesMeshesThatAreNoStone) {
  write_mesh(file("mesh.ply"), make_sphere(0.05, 3));
  EXPECT_THAT(problem(), HasSubstr("mesh.ply"));
  write_mesh(file("mesh.ply"), transformed(box_.mesh, make_pose({0.05, 0, 0})));
  EXPECT_THAT(problem(), AllOf(HasSubstr("mesh.ply"), HasSubstr("off scan.ply")));
  write_mesh(file("mesh.ply"), box_.mesh);
  Mesh open = box_.scan;
  open.faces.pop_back();
  write_mesh(file("scan.ply"), open);
  EXPECT_THAT(problem(), AllOf(HasSubstr("scan.ply"), HasSubstr("not a closed surface")));
  write_mesh(file("scan.ply"), scaled(box_.scan, 1000.0));
  EXPECT_THAT(problem(), HasSubstr("100 m long"));
  Mesh inside_out = box_.scan;
  for (Eigen::Vector3i& face : inside_out.faces) std::swap(face[0], face[1]);
  write_mesh(file("scan.ply"), inside_out);
  EXPECT_THAT(problem(), HasSubstr("look inwards"));
}

/// The stones that come with the project: what the command makes today is what lies there.
TEST(DataStones, AreSixLimestonesThatTheCommandMakes) {
  const Catalogue catalogue = read_catalogue(STONESTACK_SOURCE_DIR "/data/stones");
  ASSERT_EQ(catalogue.stones.size(), 6U);
  for (const Stone& stone : catalogue.stones) {
    Eigen::Vector3d extents = bounds(stone.scan).sizes();
    std::sort(extents.data(), extents.data() + 3);
    EXPECT_GE(extents[2], 0.088) << stone.name;
    EXPECT_LE(extents[2], 0.202) << stone.name;
    EXPECT_LE(extents[1], 0.125) << stone.name << " must fit into a gripper that opens 155 mm";
    EXPECT_LE(stone.contact_deviation.median, 0.0002) << stone.name;
    EXPECT_LE(stone.contact_deviation.worst, 0.001) << stone.name;
    EXPECT_LT(fs::file_size(catalogue.path + "/" + stone.name + "/scan.ply"), 200000U);
  }
}

}  // namespace
}  // namespace stonestack::stone
