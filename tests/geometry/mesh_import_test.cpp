#include "geometry/mesh_import.hpp"

#include <assimp/scene.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <assimp/Exporter.hpp>
#include <filesystem>
#include <memory>

#include "geometry/mutations.hpp"
#include "geometry/rough_stone.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/geometry/mesh.hpp"
#include "temporary_folder.hpp"

namespace stonestack::geometry {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

/// A folder of its own for files with the extension that decides.
class MeshImportTest : public ::testing::Test {
 protected:
  MeshImportTest() { fs::create_directories(folder_); }
  ~MeshImportTest() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string file(const std::string& name, const std::string& content) const {
    write_file((folder_ / name).string(), content);
    return (folder_ / name).string();
  }
  [[nodiscard]] std::string problem(const std::string& name, const std::string& content) const {
    try {
      (void)read_mesh(file(name, content));
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_ = fs::path(test::temporary_folder()) / concat("import-", ::getpid());
};

const char* const kTetrahedron =
    "OFF\n4 4 0\n0 0 0\n0.1 0 0\n0 0.1 0\n0 0 0.1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";

/// As a drawing program writes it: z up, millimetres, moved and turned by its node.
const char* const kCollada = R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="millimeter" meter="0.001"/><up_axis>Z_UP</up_axis></asset>
  <library_geometries><geometry id="g"><mesh>
    <source id="p"><float_array id="a" count="12">0 0 0 100 0 0 0 100 0 0 0 200</float_array>
      <technique_common><accessor source="#a" count="4" stride="3">
        <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
      </accessor></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/>
      <p>0 2 1 0 1 3 1 2 3 0 3 2</p></triangles>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="s"><node id="n">
    <translate>0 0 500</translate><rotate>0 0 1 90</rotate><instance_geometry url="#g"/>
  </node></visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#s"/></scene>
</COLLADA>
)";

/// `%` is where its buffer lies.
std::string gltf(const std::string& uri) {
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 4}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0,0,0], "max": [1,1,0]}],
"bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36}],
"buffers": [{"byteLength": 36, "uri": ")" +
         uri + "\"}]}";
}

TEST_F(MeshImportTest, ReadsOffAsItStands) {
  const Mesh mesh = read_mesh(file("stone.off", kTetrahedron));
  EXPECT_EQ(mesh.vertices.size(), 4U);
  EXPECT_EQ(mesh.faces.size(), 4U);
  EXPECT_NEAR(mass_properties(mesh, 1.0).mass, 1e-3 / 6.0, 1e-9);
}

TEST_F(MeshImportTest, AppliesColladasUnitAndNodesAndKeepsZUp) {
  const Mesh mesh = read_mesh(file("stand.DAE", kCollada));
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : mesh.vertices) box.extend(p);
  EXPECT_LT((box.min() - Eigen::Vector3d(-0.1, 0, 0.5)).norm(), 1e-6) << box.min().transpose();
  EXPECT_LT((box.max() - Eigen::Vector3d(0, 0.1, 0.7)).norm(), 1e-6) << box.max().transpose();
}

TEST_F(MeshImportTest, ReadsWhatTheLibraryWrites) {
  const Mesh stone = make_rough_stone(3);
  const double volume = mass_properties(stone, 1.0).mass;
  const auto scene = std::make_unique<aiScene>();
  scene->mRootNode = new aiNode("root");
  scene->mMaterials = new aiMaterial* [1] { new aiMaterial };
  scene->mNumMaterials = 1;
  auto* mesh = new aiMesh;
  scene->mMeshes = new aiMesh* [1] { mesh };
  scene->mNumMeshes = scene->mRootNode->mNumMeshes = 1;
  scene->mRootNode->mMeshes = new unsigned[1]{0};
  mesh->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
  mesh->mNumVertices = static_cast<unsigned>(stone.vertices.size());
  mesh->mVertices = new aiVector3D[mesh->mNumVertices];
  mesh->mNormals = new aiVector3D[mesh->mNumVertices];
  for (unsigned v = 0; v < mesh->mNumVertices; ++v) {
    const Eigen::Vector3f p = stone.vertices[v].cast<float>();
    mesh->mVertices[v] = {p.x(), p.y(), p.z()};
    mesh->mNormals[v] = {0, 0, 1};
  }
  mesh->mNumFaces = static_cast<unsigned>(stone.faces.size());
  mesh->mFaces = new aiFace[mesh->mNumFaces];
  for (unsigned f = 0; f < mesh->mNumFaces; ++f) {
    mesh->mFaces[f].mNumIndices = 3;
    mesh->mFaces[f].mIndices = new unsigned[3];
    for (unsigned k = 0; k < 3; ++k)
      mesh->mFaces[f].mIndices[k] = static_cast<unsigned>(stone.faces[f][static_cast<int>(k)]);
  }
  const std::pair<const char*, const char*> formats[] = {
      {"glb2", "glb"}, {"collada", "dae"}, {"3ds", "3ds"}, {"fbxa", "fbx"}};
  for (const auto& [writer, extension] : formats) {
    const std::string path = (folder_ / concat("stone.", extension)).string();
    Assimp::Exporter exporter;
    ASSERT_EQ(exporter.Export(scene.get(), writer, path), aiReturn_SUCCESS) << exporter.GetErrorString();
    const Mesh read = read_mesh(path);
    EXPECT_EQ(read.vertices.size(), stone.vertices.size()) << extension;
    EXPECT_EQ(read.faces.size(), stone.faces.size()) << extension;
    EXPECT_NEAR(mass_properties(read, 1.0).mass / volume, 1.0, 1e-4) << extension;
  }
}

TEST_F(MeshImportTest, OpensNoOtherFile) {
  const std::string other = file("buffer.bin", std::string(36, '\1'));
  for (const std::string& name : {std::string("buffer.bin"), other, std::string("/etc/passwd")})
    EXPECT_THAT(problem("names.gltf", gltf(name)),
                AllOf(HasSubstr("names.gltf"), HasSubstr("names another file")))
        << name;
}

TEST_F(MeshImportTest, RefusesWhatIsNone) {
  EXPECT_THAT(problem("empty.glb", ""), HasSubstr("empty"));
  EXPECT_THAT(problem("text.glb", "this is no mesh"),
              AllOf(HasSubstr("text.glb"), HasSubstr("convert it to PLY")));
  EXPECT_THAT(problem("cut.dae", std::string(kCollada).substr(0, 700)), HasSubstr("cut.dae"));
  EXPECT_THAT(problem("points.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n"), HasSubstr("points.off"));
  EXPECT_THAT(problem("stone.blend", "BLENDER"), AllOf(HasSubstr("'blend'"), HasSubstr("glTF")));
}

TEST_F(MeshImportTest, WarnsOfWhatAssimpMends) {
  const std::string path = file("index.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7777\n");
  ::testing::internal::CaptureStderr();
  (void)read_mesh(path);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              AllOf(HasSubstr("index.off"), HasSubstr("assimp reports: OFF: Vertex index")));
}

TEST_F(MeshImportTest, OutlivesDamagedFiles) {
  Random random = Random::stream(7, "damaged");
  int read = 0, refused = 0;
  for (int k = 0; k < 40; ++k) {
    const bool off = k % 2 == 0;
    const std::string content = mutated(off ? kTetrahedron : kCollada, random);
    (problem(off ? "damaged.off" : "damaged.dae", content).empty() ? read : refused) += 1;
  }
  EXPECT_GT(read, 0);
  EXPECT_GT(refused, 5);
}

TEST_F(MeshImportTest, EndsAnImporterThatHangsOrCrashes) {
  const auto message = [&](const std::string& script, double seconds) -> std::string {
    const std::string program = file("importer", "#!/bin/sh\n" + script + "\n");
    fs::permissions(program, fs::perms::owner_all);
    try {
      return import_as_ply("x.glb", "glb", "content", {program, seconds});
    } catch (const FileError& error) {
      return error.what();
    }
  };
  EXPECT_EQ(message("exec /bin/cat", 20.0), "content");
  EXPECT_THAT(message("exec /bin/sleep 600", 0.2), HasSubstr("x.glb: is not read after 0.2 s"));
  EXPECT_THAT(message("kill -SEGV $$", 20.0), HasSubstr("crash (signal 11)"));
  EXPECT_THAT(message("kill -XCPU $$", 20.0), HasSubstr("takes more than 10 s"));
  EXPECT_THAT(message("echo no such thing >&2; exit 1", 20.0), HasSubstr("x.glb: no such thing; convert it"));
}

}  // namespace
}  // namespace stonestack::geometry
