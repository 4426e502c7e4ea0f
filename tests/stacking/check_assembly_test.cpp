#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "rooms.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/stacking/scene_tasks.hpp"
#include "temporary_folder.hpp"

namespace stonestack::stacking {
namespace {

using nlohmann::json;

/// A box as COMPAS stores a block.
json box_node(double z, bool support) {
  const double x[] = {-0.5, 0.5};
  json vertices = json::object();
  for (int i = 0; i < 8; ++i)
    vertices[std::to_string(i)] = {{"x", x[i & 1]}, {"y", x[(i >> 1) & 1]}, {"z", z + x[(i >> 2) & 1]}};
  const json faces = {{"0", {0, 2, 3, 1}}, {"1", {4, 5, 7, 6}}, {"2", {0, 1, 5, 4}},
                      {"3", {2, 6, 7, 3}}, {"4", {0, 4, 6, 2}}, {"5", {1, 3, 7, 5}}};
  return {{"is_support", support},
          {"block",
           {{"dtype", "compas_assembly.datastructures/Block"},
            {"data", {{"vertex", vertices}, {"face", faces}}}}}};
}

json two_boxes() {
  return {{"dtype", "compas_assembly.datastructures/Assembly"},
          {"data",
           {{"graph", {{"data", {{"node", {{"0", box_node(0.0, true)}, {"1", box_node(1.0, false)}}}}}}}}}};
}

json& node(json& document, const char* name) {
  return document["data"]["graph"]["data"]["node"][name];
}

class CheckAssembly : public testing::Test {
 protected:
  std::string write(const std::string& text) {
    const std::string path =
        (std::filesystem::path(test::temporary_folder()) / "check_assembly.json").string();
    std::ofstream(path) << text;
    return path;
  }
  AssemblyTask task(const json& document) {
    AssemblyTask out;
    out.path = write(document.dump());
    return out;
  }
  /// Text of the error.
  std::string refused(const AssemblyTask& task) {
    try {
      static_cast<void>(check_assembly(task));
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  }
  std::string refused(const json& document) { return refused(task(document)); }
};

TEST_F(CheckAssembly, ReadsBlocksAndFindsWhereTheyTouch) {
  AssemblyTask asked = task(two_boxes());
  asked.friction = 0.6;
  EXPECT_TRUE(is_assembly(asked.path));
  const AssemblyCheck found = check_assembly(asked);
  EXPECT_EQ(found.blocks.size(), 2U);
  EXPECT_FALSE(found.interfaces_given);
  EXPECT_TRUE(found.balance.stands);
  ASSERT_EQ(found.balance.contacts.size(), 4U);
  for (const Contact& c : found.balance.contacts) EXPECT_NEAR(c.p_W.z(), 0.5, 1e-9);
  EXPECT_NEAR(found.balance.margin, 0.6, 0.01);
  asked.tilt = 0.6;  // tan 0.6 is 0.68
  EXPECT_FALSE(check_assembly(asked).balance.stands);
}

TEST_F(CheckAssembly, TakesSupportsAndDensitiesFromTheTask) {
  AssemblyTask asked = task(two_boxes());
  asked.supports = "1";
  EXPECT_FALSE(check_assembly(asked).balance.stands) << "block 0 hangs below block 1";
  asked.supports = "0";
  asked.densities = "1=2.5";
  EXPECT_NEAR(check_assembly(asked).balance.bodies[0].mass, 2.5, 1e-9);
  asked.densities = "1=x";
  EXPECT_NE(refused(asked).find("BLOCK=NUMBER"), std::string::npos);
  asked.densities = "";
  asked.supports = "7";
  EXPECT_NE(refused(asked).find("no block 7"), std::string::npos);
}

TEST_F(CheckAssembly, NamesWhatIsWrongWithAFile) {
  EXPECT_NE(refused(json{{"a", 1}}).find("no COMPAS assembly"), std::string::npos);
  AssemblyTask text;
  text.path = write("{\"data\": NaN}");
  EXPECT_NE(refused(text).find("not JSON"), std::string::npos);
  text.path = write(std::string(100000, '['));
  EXPECT_NE(refused(text).find("not JSON"), std::string::npos);

  json document = two_boxes();
  node(document, "1").erase("block");
  EXPECT_NE(refused(document).find("block 1: block is missing"), std::string::npos) << refused(document);

  document = two_boxes();
  node(document, "1")["block"]["data"]["vertex"]["3"].erase("y");
  EXPECT_NE(refused(document).find("no number y"), std::string::npos) << refused(document);

  document = two_boxes();
  node(document, "1")["block"]["data"]["vertex"]["3"]["y"] = 1e300;
  EXPECT_NE(refused(document).find("1e+300"), std::string::npos) << refused(document);

  document = two_boxes();
  node(document, "1")["block"]["data"]["face"].erase("3");
  EXPECT_NE(refused(document).find("not closed"), std::string::npos) << refused(document);

  document = two_boxes();
  node(document, "1")["block"]["data"]["face"]["3"][0] = 99;
  EXPECT_NE(refused(document).find("names vertex 99"), std::string::npos) << refused(document);

  document = two_boxes();
  for (auto& vertex : node(document, "1")["block"]["data"]["vertex"]) vertex["z"] = vertex["x"];
  EXPECT_NE(refused(document).find("block 1"), std::string::npos) << refused(document);

  document = two_boxes();
  node(document, "0")["is_support"] = false;
  EXPECT_NE(refused(document).find("--supports"), std::string::npos) << refused(document);

  document = two_boxes();
  document["data"]["graph"]["data"]["edge"]["0"]["1"]["interfaces"] =
      json::parse(R"([{"data": {"points": [[0, 0, 1]]}}])");
  EXPECT_NE(refused(document).find("points"), std::string::npos) << refused(document);
}

TEST_F(CheckAssembly, BlocksThatShareNoFaceAreRefused) {
  json document = two_boxes();
  for (auto& [key, vertex] : node(document, "1")["block"]["data"]["vertex"].items())
    vertex["z"] = vertex["z"].get<double>() + 0.3;
  EXPECT_NE(refused(document).find("no two blocks share a face"), std::string::npos) << refused(document);
}

TEST_F(CheckAssembly, RefusesAMillionBlocks) {
  std::string text = R"({"graph": {"node": {)";
  for (int i = 0; i < 1000000; ++i) text += (i == 0 ? "\"" : ",\"") + std::to_string(i) + "\":0";
  AssemblyTask asked;
  asked.path = write(text + "}}}");
  EXPECT_NE(refused(asked).find("1000000 blocks"), std::string::npos);
}

}  // namespace
}  // namespace stonestack::stacking
