#include <gmock/gmock.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/geometry/mesh.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "temporary_folder.hpp"

/// URDFs whose collision shapes are meshes, as the vendors' are.
namespace stonestack::kinematics {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

const std::string kMeshRobotUr10 = STONESTACK_SOURCE_DIR "/data/robots/ur10.urdf";

Mesh mesh_of(const LinkCapsule& capsule, double scale) {
  Mesh mesh = make_sphere(capsule.radius, 3);
  const Eigen::Vector3d axis = capsule.b - capsule.a;
  for (auto& v : mesh.vertices) v = scale * (v + (axis.dot(v) > 0.0 ? capsule.b : capsule.a));
  return mesh;
}

/// A folder of its own for each test, with a package `arm_description` in it: urdf/ur10.urdf, in which every
/// link's shapes are one mesh in meshes/.
class MeshRobot : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(test::temporary_folder()) /
            concat("mesh_robot_", testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(root_);
    fs::create_directories(package() / "urdf");
    fs::create_directories(package() / "meshes");
    write(1.0, "package://arm_description/meshes/", "");
  }
  void TearDown() override { fs::remove_all(root_); }

  [[nodiscard]] fs::path package() const { return root_ / "arm_description"; }
  [[nodiscard]] std::string urdf() const { return (package() / "urdf" / "ur10.urdf").string(); }

  /// The robot of this project with its shapes as meshes, `scale` times too large.
  void write(double scale, const std::string& prefix, const std::string& attribute) {
    const RobotModel robot = read_robot("ur10");
    std::string text = read_file(kMeshRobotUr10, 1 << 20);
    const char* links[] = {"base_link_inertia", "shoulder_link", "upper_arm_link", "forearm_link",
                           "wrist_1_link",      "wrist_2_link",  "wrist_3_link"};
    for (int link = 0; link < 7; ++link) {
      Mesh mesh;
      for (const LinkCapsule& capsule : robot.capsules) {
        if (capsule.link != link) continue;
        const Mesh part = mesh_of(capsule, scale);
        const auto offset = static_cast<int>(mesh.vertices.size());
        mesh.vertices.insert(mesh.vertices.end(), part.vertices.begin(), part.vertices.end());
        for (const auto& f : part.faces) mesh.faces.push_back(f + Eigen::Vector3i::Constant(offset));
      }
      const std::string name = links[link];
      write_mesh((package() / "meshes" / (name + ".obj")).string(), mesh);
      // The shapes of the base lie in base_link here, half a turn about z from base_link_inertia.
      const char* turn = link == 0 ? " rpy=\"0 0 3.141592653589793\"" : "";
      const std::string shape =
          concat("<collision><origin xyz=\"0 0 0\"", turn, "/><geometry><mesh filename=\"", prefix, name,
                 ".obj\"", attribute, "/></geometry></collision>");
      const auto at = text.find("<link name=\"" + name + "\">");
      for (auto from = text.find("<collision>", at); from < text.find("</link>", at);
           from = text.find("<collision>", at))
        text.erase(from, text.find("</collision>", from) + 12 - from);
      text.insert(text.find("</link>", at), shape);
    }
    write_file(urdf(), text);
  }

  [[nodiscard]] std::string answer() const {
    try {
      (void)read_robot(urdf());
    } catch (const FileError& problem) {
      return problem.what();
    }
    return "read";
  }

  fs::path root_;
};

double out_of(const LinkCapsule& capsule, const Eigen::Vector3d& p) {
  const Eigen::Vector3d segment = capsule.b - capsule.a;
  const double length2 = segment.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - capsule.a).dot(segment) / length2, 0.0, 1.0) : 0.0;
  return (p - capsule.a - t * segment).norm() - capsule.radius;
}

double out_of_link(const RobotModel& robot, int link, const Eigen::Vector3d& p) {
  double min = 1e9;
  for (const LinkCapsule& c : robot.capsules)
    if (c.link == link) min = std::min(min, out_of(c, p));
  return min;
}

TEST_F(MeshRobot, IsCoveredByCapsulesThatHoldItsMeshes) {
  const RobotModel known = read_robot("ur10"), read = read_robot(urdf());
  EXPECT_LE(read.capsules.size(), 42u);
  double beyond = 0.0;
  for (const LinkCapsule& capsule : known.capsules)
    for (const auto& p : mesh_of(capsule, 1.0).vertices)
      ASSERT_LE(out_of_link(read, capsule.link, p), 1e-6) << "link " << capsule.link;
  for (const LinkCapsule& capsule : read.capsules)
    for (const auto& p : mesh_of(capsule, 1.0).vertices)
      beyond = std::max(beyond, out_of_link(known, capsule.link, p));
  EXPECT_LT(beyond, 0.02) << "m beyond the shapes that the meshes were made of";
}

TEST_F(MeshRobot, IsFoundByItsPackageWhereverThatLies) {
  EXPECT_EQ(answer(), "read") << "the package holds the URDF";
  fs::create_directories(root_ / "elsewhere" / "share");
  fs::rename(package() / "meshes", root_ / "meshes");
  EXPECT_THAT(answer(), AllOf(HasSubstr("lies in no folder 'arm_description'"), HasSubstr("ROS_PACKAGE_PATH"),
                              HasSubstr("base_link_inertia.obj")));
  const fs::path other = root_ / "elsewhere" / "share" / "arm_description";
  fs::create_directories(other);
  fs::rename(root_ / "meshes", other / "meshes");
  for (const auto& [variable, folder] :
       {std::pair("ROS_PACKAGE_PATH", other.parent_path()), std::pair("ROS_PACKAGE_PATH", other),
        std::pair("AMENT_PREFIX_PATH", other.parent_path().parent_path())}) {
    ::setenv(variable, ("/nowhere:" + folder.string()).c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
    EXPECT_EQ(answer(), "read") << variable << " " << folder;
    ::unsetenv(variable);  // NOLINT(concurrency-mt-unsafe)
  }
}

TEST_F(MeshRobot, IsReadWithAPathFromItsFolderAndAScale) {
  fs::rename(package() / "meshes", package() / "urdf" / "m");
  fs::create_directories(package() / "meshes");
  write(1000.0, "m/", " scale=\"0.001 0.001 0.001\"");
  fs::remove_all(package() / "urdf" / "m");
  fs::rename(package() / "meshes", package() / "urdf" / "m");
  const RobotModel known = read_robot("ur10"), read = read_robot(urdf());
  for (const LinkCapsule& capsule : known.capsules)
    ASSERT_LE(out_of_link(read, capsule.link, capsule.a), 0.0);
}

TEST_F(MeshRobot, IsRefusedInMillimetres) {
  write(1000.0, "package://arm_description/meshes/", "");
  EXPECT_THAT(answer(), AllOf(HasSubstr("m across"), HasSubstr("scale=\"0.001 0.001 0.001\"")));
  write(1.0, "package://arm_description/meshes/", " scale=\"0 1 1\"");
  EXPECT_THAT(answer(), HasSubstr("(0 1 1)"));
}

TEST_F(MeshRobot, OpensOnlyWhatLiesWithIt) {
  for (const char* prefix : {"/etc/", "../meshes/", "package://arm_description/../meshes/", "package://../",
                             "file:///tmp/", "http://example.org/", "package:///"}) {
    write(1.0, prefix, "");
    EXPECT_THAT(answer(), AllOf(HasSubstr(urdf()), HasSubstr(prefix), HasSubstr("without '..'"))) << prefix;
  }
}

TEST_F(MeshRobot, NamesAMeshThatIsNone) {
  const std::string mesh = (package() / "meshes" / "forearm_link.obj").string();
  write_file(mesh, "v 1 2 nan\nf 1 1 1\n");
  EXPECT_THAT(answer(), HasSubstr(mesh));
  write_file(mesh, "");
  EXPECT_THAT(answer(), HasSubstr(mesh));
  fs::remove(mesh);
  EXPECT_THAT(answer(), HasSubstr("forearm_link"));
}

}  // namespace
}  // namespace stonestack::kinematics
