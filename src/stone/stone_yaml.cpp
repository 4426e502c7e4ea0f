#include "stone/stone_yaml.hpp"

#include <array>
#include <charconv>
#include <cmath>

#include "core/yaml.hpp"
#include "geometry/pose_yaml.hpp"

namespace stonestack::stone {
namespace {

constexpr const char* kStoneSchema = "stonestack.stone/1";
constexpr std::size_t kMaxSymmetries = 100;  // axes, or planes

/// Shortest text that reads back as the same number.
std::string number(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value + 0.0);
  return {text.data(), end.ptr};
}

/// In double quotes, whatever a file name holds.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return result + '"';
}

std::string deviation_text(const Deviation& d) {
  return concat("{median: ", number(d.median), ", worst: ", number(d.worst), "}");
}

Deviation read_deviation(yaml::Map map) {
  Deviation result;
  result.median = map.number("median", 0.0, 2.0);
  result.worst = map.number("worst", 0.0, 2.0);
  map.finish();
  return result;
}

Eigen::Vector3d read_vector(yaml::Map map) {
  const Eigen::Vector3d p(map.number("x", -2.0, 2.0), map.number("y", -2.0, 2.0), map.number("z", -2.0, 2.0));
  map.finish();
  return p;
}

Eigen::Matrix3d read_inertia(yaml::Map map) {
  const auto moment = [&](const char* key) { return map.number(key, 0.0, 1e5); };
  const auto product = [&](const char* key) { return map.number(key, -1e5, 1e5); };
  const double xx = moment("xx"), yy = moment("yy"), zz = moment("zz");
  const double xy = product("xy"), xz = product("xz"), yz = product("yz");
  map.finish();
  Eigen::Matrix3d inertia;
  inertia << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  return inertia;
}

int read_count(yaml::Map& map, const std::string& key, int low, int high) {
  const double value = map.number(key, low, high);
  const int count = static_cast<int>(value);
  if (count != value) map.fail(key, concat("is ", value), "it must be a whole number");
  return count;
}

std::string vector_text(const Eigen::Vector3d& v) {
  return concat("{x: ", number(v.x()), ", y: ", number(v.y()), ", z: ", number(v.z()), "}");
}

std::string symmetries_text(const Symmetries& s) {
  if (s.axes.empty() && s.planes.empty()) return "";
  std::string text =
      concat("symmetries:  # of the shape; order 0: turned by any angle\n  point: ", vector_text(s.p_O),
             "  # m, in O, of all axes and planes\n  axes: [");
  for (const auto& axis : s.axes)
    text += concat(&axis == &s.axes.front() ? "" : ",\n         ", "{direction: ", vector_text(axis.n_O),
                   ", order: ", axis.order, ", deviation: ", number(axis.deviation), "}");
  text += "]\n  planes: [";
  for (const auto& plane : s.planes)
    text += concat(&plane == &s.planes.front() ? "" : ",\n           ", "{normal: ", vector_text(plane.n_O),
                   ", deviation: ", number(plane.deviation), "}");
  return text + "]\n";
}

Eigen::Vector3d read_direction(yaml::Map& map, const std::string& key) {
  const Eigen::Vector3d n = read_vector(map.map(key));
  if (std::abs(n.norm() - 1.0) > 1e-3) map.fail(key, concat("is ", n.norm(), " long"), "it must be 1 long");
  return n;
}

/// Calls `read` for every map of the list `key`.
template <class Read>
void for_each_map(yaml::Map& map, const std::string& key, const Read& read) {
  const YAML::Node list = map.node(key);
  if (!list.IsSequence() || list.size() > kMaxSymmetries)
    map.fail(key, "is no short list", concat("it must be a list of at most ", kMaxSymmetries, " entries"));
  for (std::size_t k = 0; k < list.size(); ++k) {
    yaml::Map entry(list[k], map.path(), concat("symmetries.", key, "[", k, "]"));
    read(entry);
    entry.finish();
  }
}

Symmetries read_symmetries(yaml::Map map) {
  Symmetries s;
  s.p_O = read_vector(map.map("point"));
  for_each_map(map, "axes", [&](yaml::Map& entry) {
    const Eigen::Vector3d n = read_direction(entry, "direction");
    const int order = read_count(entry, "order", 0, 100);
    s.axes.push_back({n, order, entry.number("deviation", 0.0, 2.0)});
  });
  for_each_map(map, "planes", [&](yaml::Map& entry) {
    const Eigen::Vector3d n = read_direction(entry, "normal");
    s.planes.push_back({n, entry.number("deviation", 0.0, 2.0)});
  });
  map.finish();
  return s;
}

double read_positive(yaml::Map& map, const std::string& key, double max, const std::string& unit) {
  const double value = map.number(key);
  if (value <= 0.0 || value > max)
    map.fail(key, concat("is ", value), concat("it must be above 0 and at most ", max, unit));
  return value;
}

}  // namespace

std::string stone_to_yaml(const Stone& s, const Symmetries& symmetries) {
  const Eigen::Vector3d& c = s.mass.p_O_M;
  const Eigen::Matrix3d& I = s.mass.I_M;
  return concat(
      "schema: ", kStoneSchema, "\nname: ", quoted(s.name), "\nsource: ", quoted(s.source),
      "\nmass: ", number(s.mass.mass), "  # kg\ndensity: ", number(s.density),
      "  # kg/m^3\nfriction: ", number(s.friction), "  # stone on stone, what the planner assumes\n",
      "centre_of_mass: {x: ", number(c.x()), ", y: ", number(c.y()), ", z: ", number(c.z()), "}  # m, in O\n",
      "inertia: {xx: ", number(I(0, 0)), ", yy: ", number(I(1, 1)), ", zz: ", number(I(2, 2)),
      ", xy: ", number(I(0, 1)), ", xz: ", number(I(0, 2)), ", yz: ", number(I(1, 2)),
      "}  # kg m^2, about the centre of mass, axes of O\n", "scale: ", number(s.scale),
      "  # metres per unit of the scanned file\n", "T_O_file: ", to_text(s.T_O_file),
      "  # the file's frame, scaled to metres, in O\n", "faces: ", s.mesh.faces.size(),
      "  # of mesh.ply\npieces: ", s.pieces.size(), "  # convex pieces, pieces/1.ply and so on\n",
      "mesh_deviation: ", deviation_text(s.mesh_deviation), "  # m, mesh.ply from scan.ply, both ways\n",
      "contact_deviation: ", deviation_text(s.contact_deviation),
      "  # m, the surface that physics collides with from scan.ply\n", symmetries_text(symmetries));
}

StoneFile read_stone_yaml(const std::string& path) {
  yaml::Map map(yaml::read_file(path), path);
  const std::string schema = map.text("schema");
  if (schema != kStoneSchema)
    throw FileError(path, concat("is a ", schema, " file by its schema"),
                    concat("give a ", kStoneSchema, " file, as `scan` writes into a catalogue"));
  StoneFile file;
  Stone& stone = file.stone;
  stone.name = map.text("name");
  stone.source = map.text("source");
  stone.mass.mass = read_positive(map, "mass", 1e4, " kg");
  stone.density = read_positive(map, "density", 25000.0, " kg/m^3");
  stone.friction = read_positive(map, "friction", 2.0, "");
  stone.mass.p_O_M = read_vector(map.map("centre_of_mass"));
  stone.mass.I_M = read_inertia(map.map("inertia"));
  stone.scale = read_positive(map, "scale", 1e6, " m");
  stone.T_O_file = read_pose(map.map("T_O_file"));
  file.faces = read_count(map, "faces", 4, 500);
  file.pieces = read_count(map, "pieces", 1, 1000);
  stone.mesh_deviation = read_deviation(map.map("mesh_deviation"));
  stone.contact_deviation = read_deviation(map.map("contact_deviation"));
  if (map.has("symmetries")) file.symmetries = read_symmetries(map.map("symmetries"));
  map.finish();
  return file;
}

}  // namespace stonestack::stone
