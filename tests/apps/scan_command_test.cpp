#include "commands.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/geometry/mesh.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack {
namespace {

using ::testing::AllOf;

/// `stonestack scan` as a user runs it, in a folder of its own.
class ScanCommand : public Commands {
 protected:
  [[nodiscard]] Outcome scan(const std::string& arguments) const {
    return run("scan " + arguments + " --catalogue rocks");
  }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }
  /// Stones stored, hidden leftovers counted too.
  [[nodiscard]] long stored() const {
    if (!fs::exists(path("rocks"))) return 0;
    return std::distance(fs::directory_iterator(path("rocks")), fs::directory_iterator());
  }
};

TEST_F(ScanCommand, StoresAStoneAndDescribesIt) {
  write_mesh(path("my rock.ply"), make_box({0.10, 0.08, 0.06}));
  const Outcome outcome = scan("'my rock.ply' --mass 1.25 --friction 0.3 --json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out,
              AllOf(HasSubstr("\"schema\": \"stonestack.scan/1\""), HasSubstr("\"mass\": 1.25")));
  const Catalogue catalogue = read_catalogue(path("rocks"));
  ASSERT_EQ(catalogue.stones.size(), 1U);
  EXPECT_EQ(catalogue.stones[0].name, "my_rock");
  EXPECT_EQ(catalogue.stones[0].mass.mass, 1.25);
  EXPECT_EQ(catalogue.stones[0].friction, 0.3);
}

TEST_F(ScanCommand, GeneratesTheStonesThatComeWithTheProject) {
  const Outcome outcome = scan("--generate 1 --seed 1");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("limestone_1"));
  const std::string data = STONESTACK_SOURCE_DIR "/data/stones/limestone_1/";
  for (const char* name : {"stone.yaml", "mesh.ply", "scan.ply", "pieces/1.ply"})
    EXPECT_TRUE(read_file(data + name, 1 << 20) == read_file(path("rocks/limestone_1/") + name, 1 << 20))
        << name << " differs; make data/stones again as data/README.md says, if that is meant";
}

TEST_F(ScanCommand, StoresTheGoodNamesTheBadAndEndsWith3) {
  write_mesh(path("good.ply"), make_box({0.10, 0.08, 0.06}));
  write_mesh(path("huge.ply"), make_box({200, 150, 90}));
  Mesh sheet;
  sheet.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}};
  sheet.faces = {{0, 1, 2}};
  write_mesh(path("sheet.ply"), sheet);
  write_file(path("empty.ply"), "");
  write_file(path("nan.obj"), "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string whole = read_file(path("good.ply"), 1 << 20);
  write_file(path("truncated.ply"), whole.substr(0, whole.size() - 20));
  const Outcome outcome =
      scan("missing.ply huge.ply good.ply sheet.ply empty.ply nan.obj truncated.ply --json");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("missing.ply: "), HasSubstr("huge.ply: is 200 m long"),
                                 HasSubstr("sheet.ply: encloses no volume"), HasSubstr("empty.ply: "),
                                 HasSubstr("nan.obj: "), HasSubstr("truncated.ply: "), HasSubstr("6 of 7")));
  EXPECT_EQ(read_catalogue(path("rocks")).stones.size(), 1U);
  EXPECT_EQ(stored(), 1);
}

TEST_F(ScanCommand, ReportsThatNothingIsStoredWhereEveryFileFails) {
  write_file(path("empty.ply"), "");
  const Outcome outcome = scan("missing.ply empty.ply");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("2 of 2"), HasSubstr("none is stored")));
  EXPECT_THAT(outcome.err, ::testing::Not(HasSubstr("the others are stored")));
  EXPECT_EQ(stored(), 0);
}

TEST_F(ScanCommand, RefusesNamesThatWouldCollideBeforeItWorks) {
  fs::create_directories(path("a"));
  write_mesh(path("rock.ply"), make_box({0.10, 0.08, 0.06}));
  write_mesh(path("a/rock.obj"), make_box({0.10, 0.08, 0.06}));
  const Outcome twice = scan("rock.ply a/rock.obj");
  EXPECT_EQ(twice.code, 2);
  EXPECT_THAT(twice.err, HasSubstr("two stones would be named 'rock'"));
  EXPECT_EQ(stored(), 0);
  EXPECT_EQ(scan("rock.ply").code, 0);
  const Outcome again = scan("rock.ply");
  EXPECT_EQ(again.code, 2);
  EXPECT_THAT(again.err, HasSubstr("--force"));
  EXPECT_EQ(scan("rock.ply --force --density 2000").code, 0);
  EXPECT_NEAR(read_catalogue(path("rocks")).stones[0].density, 2000.0, 1e-6);
}

TEST_F(ScanCommand, RefusesWrongUsageWith2) {
  write_mesh(path("rock.ply"), make_box({0.10, 0.08, 0.06}));
  for (const char* arguments :
       {"", "rock.ply --units inch", "rock.ply --density -3", "rock.ply --friction nan",
        "rock.ply --mass 1 --density 2000", "rock.ply --generate 2 --name x", "rock.ply --name ../x",
        "rock.ply --scale 0", "--generate 0"})
    EXPECT_EQ(scan(arguments).code, 2) << arguments;
  EXPECT_EQ(stored(), 0);
}

}  // namespace
}  // namespace stonestack
