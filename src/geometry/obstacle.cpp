#include "stonestack/geometry/obstacle.hpp"

#include <algorithm>
#include <filesystem>

#include "core/yaml.hpp"
#include "geometry/convex_pieces.hpp"
#include "geometry/enclosing_shapes.hpp"
#include "geometry/pose_yaml.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::geometry {
namespace {

constexpr std::size_t kMaxObstacles = 200;           // obstacles
constexpr double kMinSize = 0.001, kMaxSize = 20.0;  // m
constexpr std::size_t kObstacleMaxFaces = 4000;      // that convex_pieces takes
constexpr const char* kShapes[] = {"box", "sphere", "cylinder", "mesh"};

std::vector<Mesh> read_pieces(yaml::Map& entry) {
  const std::string name = entry.text("mesh");
  const std::filesystem::path file = std::filesystem::path(entry.path()).parent_path() / name;  // or absolute
  const Mesh mesh = read_mesh(file.string());
  if (mesh.vertices.empty()) entry.fail("mesh", "is '" + name + "', which is empty", "give a mesh");
  const double size = bounds(mesh).diagonal().norm();
  if (!(size >= kMinSize && size <= kMaxSize))
    entry.fail("mesh", concat("is '", name, "', ", size, " m across"),
               concat("it must be in metres, ", kMinSize, " to ", kMaxSize, " m across"));
  try {
    ConvexPiecesOptions options;
    options.max_pieces = 16;
    if (is_closed(mesh) && mesh.faces.size() <= kObstacleMaxFaces) return convex_pieces(mesh, options);
    return {convex_hull(mesh)};
  } catch (const InvalidArgument& problem) {
    entry.fail("mesh", concat("is '", name, "': ", problem.what()), "give a body with a volume");
  }
}

std::vector<Mesh> read_shape(yaml::Map& entry) {
  std::string given;
  for (const char* shape : kShapes)
    if (entry.has(shape)) given += (given.empty() ? "" : " and ") + std::string(shape);
  const auto size = [](yaml::Map& map, const char* key) { return map.number(key, kMinSize, kMaxSize); };
  if (given == "mesh") return read_pieces(entry);
  if (given != "box" && given != "sphere" && given != "cylinder")
    entry.fail("box", given.empty() ? "is missing, as is any other shape" : "is not the only shape: " + given,
               "give one of box {x, y, z}, sphere {radius}, cylinder {radius, length}, mesh");
  yaml::Map shape = entry.map(given);
  Mesh mesh;
  if (given == "box") {
    const double x = size(shape, "x"), y = size(shape, "y");
    mesh = make_box({x, y, size(shape, "z")});
  } else {
    const double radius = size(shape, "radius");
    mesh = given == "sphere" ? around_sphere(radius) : around_cylinder(radius, size(shape, "length"));
  }
  shape.finish();
  return {mesh};
}

}  // namespace

std::vector<Obstacle> parse_obstacles(const std::string& text, const std::string& path,
                                      const std::string& where) {
  const YAML::Node list = yaml::parse(text, path);
  std::vector<Obstacle> obstacles;
  if (!list.IsDefined() || list.IsNull()) return obstacles;
  if (!list.IsSequence())
    throw FileError(path, where + " is not a list", "write '- {name: wall, box: {x, y, z}, T_W_O: {...}}'");
  if (list.size() > kMaxObstacles)
    throw FileError(path, concat(where, " has ", list.size(), " entries"),
                    concat("at most ", kMaxObstacles, " are read; join small ones"));
  for (std::size_t i = 0; i < list.size(); ++i) {
    yaml::Map entry(list[i], path, concat(where, "[", i, "]"));
    Obstacle obstacle;
    obstacle.name = entry.text("name");
    if (obstacle.name.empty()) entry.fail("name", "is empty", "name it, for messages");
    if (obstacle.name == "table")
      entry.fail("name", "is 'table'", "that is what everything stands on; name it otherwise");
    if (std::any_of(obstacles.begin(), obstacles.end(),
                    [&](const Obstacle& o) { return o.name == obstacle.name; }))
      entry.fail("name", concat("'", obstacle.name, "' stands for another obstacle, too"),
                 "give each a name of its own");
    obstacle.pieces = read_shape(entry);
    obstacle.T_W_O = read_pose(entry.map("T_W_O"));
    entry.finish();
    obstacles.push_back(std::move(obstacle));
  }
  return obstacles;
}

}  // namespace stonestack::geometry
