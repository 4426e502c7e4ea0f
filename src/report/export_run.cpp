#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>

#include "report/export_formats.hpp"
#include "report/picture.hpp"
#include "report/run_record.hpp"
#include "report/text.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/report/record_run.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

constexpr double kExportDensity = 2600.0;  // kg/m^3, limestone (`Stone::density`): the record has no masses
constexpr double kSupportSide = 1.0, kSupportHeight = 0.1;  // m, of the block that stands for the table

/// A stone's name as a name in a file: letters, digits, '_', '-', '.'.
std::string safe_name(const std::string& name) {
  std::string safe = name;
  for (char& c : safe)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_' && c != '-' && c != '.') c = '_';
  return safe;
}

const Pose& last_pose(const RecordedStone& stone) {
  return stone.motion.back().T_W_O;
}

// PLY

std::string export_ply(const RunRecord& record, const std::string& folder) {
  Mesh tower;
  for (const std::size_t i : tower_of(record)) {
    const Mesh mesh = transformed(record.stones[i].mesh, last_pose(record.stones[i]));
    const auto offset = static_cast<int>(tower.vertices.size());
    tower.vertices.insert(tower.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    for (const Eigen::Vector3i& face : mesh.faces) tower.faces.push_back(face.array() + offset);
  }
  if (tower.faces.empty())
    throw FileError(record.folder, "holds no tower: no stone was placed", "export csv or mcap");
  const std::string path = folder + "/tower.ply";
  write_mesh(path, tower);
  return path;
}

// URDF

/// Binary STL, which every reader of URDF knows.
std::string stl_of(const Mesh& mesh) {
  std::string bytes(80, ' ');
  const auto put = [&](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  const auto put_vector = [&](const Eigen::Vector3d& v) {
    for (const double x : v) put(static_cast<float>(x));
  };
  put(static_cast<std::uint32_t>(mesh.faces.size()));
  const auto normals = face_normals(mesh);
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    put_vector(normals[i]);
    for (const int corner : mesh.faces[i]) put_vector(mesh.vertices[static_cast<std::size_t>(corner)]);
    put(std::uint16_t{0});
  }
  return bytes;
}

std::string vector_text(const Eigen::Vector3d& v) {
  return format("%.9g %.9g %.9g", v.x(), v.y(), v.z());
}

/// Roll, pitch, yaw about fixed axes, as URDF has them.
Eigen::Vector3d roll_pitch_yaw(const Eigen::Matrix3d& R) {
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  if (std::hypot(R(0, 0), R(1, 0)) < 1e-9) return {std::atan2(-R(1, 2), R(1, 1)), pitch, 0.0};
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

std::vector<std::string> export_urdf(const RunRecord& record, const std::string& folder) {
  std::vector<std::string> written{folder + "/tower.urdf"};
  std::string text = "<?xml version=\"1.0\"?>\n<robot name=\"stonestack_run\">\n  <link name=\"world\"/>\n";
  for (const RecordedStone& stone : record.stones) {
    if (stone.motion.empty()) continue;
    const std::string name = safe_name(stone.name), file = "meshes/" + name + ".stl";
    const MassProperties mass = mass_properties(stone.mesh, kExportDensity);
    const std::string geometry = "<geometry><mesh filename=\"" + file + "\"/></geometry>";
    text += "  <link name=\"" + name + "\">\n    <inertial>\n      <origin xyz=\"" + vector_text(mass.p_O_M) +
            "\"/>\n" +
            format(
                "      <mass value=\"%.9g\"/>\n      <inertia ixx=\"%.9g\" ixy=\"%.9g\" ixz=\"%.9g\" "
                "iyy=\"%.9g\" "
                "iyz=\"%.9g\" izz=\"%.9g\"/>\n    </inertial>\n",
                mass.mass, mass.I_M(0, 0), mass.I_M(0, 1), mass.I_M(0, 2), mass.I_M(1, 1), mass.I_M(1, 2),
                mass.I_M(2, 2)) +
            "    <visual>" + geometry + "</visual>\n    <collision>" + geometry + "</collision>\n  </link>\n";
    const Pose& T_W_O = last_pose(stone);
    text += "  <joint name=\"world_" + name +
            "\" type=\"fixed\">\n    <parent link=\"world\"/>\n    <child link=\"" + name +
            "\"/>\n    <origin xyz=\"" + vector_text(T_W_O.translation()) + "\" rpy=\"" +
            vector_text(roll_pitch_yaw(T_W_O.linear())) + "\"/>\n  </joint>\n";
    written.push_back(folder + "/" + file);
    write_file(written.back(), stl_of(stone.mesh));
  }
  write_file(written.front(), text + "</robot>\n");
  return written;
}

// CSV

std::string pose_columns(const std::optional<Pose>& pose) {
  if (!pose) return ",,,,,,,";
  Eigen::Quaterniond q(pose->linear());
  if (q.w() < 0) q.coeffs() *= -1;
  const Eigen::Vector3d& p = pose->translation();
  return format(",%.12g,%.12g,%.12g,%.12g,%.12g,%.12g,%.12g", p.x(), p.y(), p.z(), q.x(), q.y(), q.z(),
                q.w());
}

std::string pose_header(const char* prefix) {
  std::string text;
  for (const char* name : {"x", "y", "z", "qx", "qy", "qz", "qw"}) text += concat(',', prefix, '_', name);
  return text;
}

std::vector<std::string> export_csv(const RunRecord& record, const std::string& folder) {
  std::string placements = "number,stone,level,outcome,cost,predicted_success" + pose_header("planned") +
                           pose_header("measured") + "\n";
  int number = 0;
  for (const RecordedPlacement& p : record.placements)
    placements += format("%d,%s,%d,%s,%.12g,%.12g", ++number, safe_name(p.stone).c_str(), p.level,
                         p.outcome.c_str(), p.cost, p.predicted_success) +
                  pose_columns(p.T_W_O_planned) + pose_columns(p.T_W_O_measured) + "\n";
  std::string trajectory = "t,q0,q1,q2,q3,q4,q5,opening,force,holds\n";
  for (const RecordedSample& s : record.samples) {
    trajectory += format("%.9g", s.time);
    for (const double q : s.q) trajectory += format(",%.9g", q);
    trajectory += format(",%.9g,%.9g,%d\n", s.opening, s.force, s.holds ? 1 : 0);
  }
  const std::vector<std::string> paths{folder + "/placements.csv", folder + "/trajectory.csv"};
  write_file(paths[0], placements);
  write_file(paths[1], trajectory);
  return paths;
}

// PNG

std::string export_png(const RunRecord& record, const std::string& folder) {
  static const std::array<Eigen::Vector3d, 3> kTints{
      {{0.72, 0.68, 0.60}, {0.62, 0.60, 0.57}, {0.70, 0.60, 0.50}}};
  std::vector<DrawnMesh> meshes;
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < record.stones.size(); ++i) {
    const RecordedStone& stone = record.stones[i];
    if (stone.motion.empty()) continue;
    meshes.push_back({stone.mesh, last_pose(stone), kTints[i % kTints.size()]});
    if (stone.level > 0 || record.height == 0) box.extend(bounds(transformed(stone.mesh, last_pose(stone))));
  }
  if (meshes.empty()) throw FileError(record.folder, "holds no stone: none was seen", "export csv or mcap");
  if (box.isEmpty()) box = bounds(transformed(meshes.front().mesh, meshes.front().T_W_A));
  const std::string path = folder + "/tower.png";
  write_png(path, draw(meshes, view_of_site(box.center().head<2>(), box.max().z())));
  return path;
}

// COMPAS

/// compas_assembly's Block of a mesh in W.
json compas_block(const Mesh& mesh, const std::string& name) {
  json vertices = json::object(), faces = json::object(), data = json::object();
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3d& v = mesh.vertices[i];
    vertices[std::to_string(i)] = {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}};
  }
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    faces[std::to_string(i)] = {mesh.faces[i][0], mesh.faces[i][1], mesh.faces[i][2]};
    data[std::to_string(i)] = json::object();
  }
  return {{"dtype", "compas_assembly.datastructures/Block"},
          {"data",
           {{"attributes", {{"name", name}}},
            {"default_vertex_attributes", {{"x", 0.0}, {"y", 0.0}, {"z", 0.0}}},
            {"default_edge_attributes", json::object()},
            {"default_face_attributes", json::object()},
            {"vertex", vertices},
            {"face", faces},
            {"facedata", data},
            {"edgedata", json::object()},
            {"max_vertex", static_cast<int>(mesh.vertices.size()) - 1},
            {"max_face", static_cast<int>(mesh.faces.size()) - 1}}}};
}

/// Joint motion from a grasp to the release.
json compas_trajectory(const RunRecord& record, const RecordedCarry& carry) {
  json points = json::array();
  for (const RecordedSample& s : record.samples) {
    if (s.time < carry.begin || s.time > carry.end) continue;
    const double time = s.time - carry.begin, seconds = std::floor(time);
    points.push_back(
        {{"joint_values", std::vector<double>(s.q.begin(), s.q.end())},
         {"joint_types", {0, 0, 0, 0, 0, 0}},  // revolute
         {"time_from_start",
          {{"secs", static_cast<long>(seconds)}, {"nsecs", std::lround((time - seconds) * 1e9)}}}});
  }
  return {{"stone", record.stones[static_cast<std::size_t>(carry.stone)].name},
          {"start", carry.begin},
          {"T_T_O", pose_json(carry.T_T_O)},
          {"joint_names",
           {"shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint",
            "wrist_3_joint"}},
          {"points", points}};
}

json compas_node(const Mesh& mesh, const std::string& name, const Eigen::Vector3d& p_W, bool support) {
  return {{"block", compas_block(mesh, name)},
          {"is_support", support},
          {"x", p_W.x()},
          {"y", p_W.y()},
          {"z", p_W.z()}};
}

}  // namespace

std::string to_compas(const RunRecord& record) {
  json nodes = json::object(), edges = json::object(), sequence = json::array(), trajectories = json::array();
  const auto tower = tower_of(record);
  Eigen::Vector3d p_W_site(0.0, 0.0, 0.0);
  if (!tower.empty()) p_W_site = last_pose(record.stones[tower.front()]).translation();
  const Pose T_W_table(Eigen::Translation3d(p_W_site.x(), p_W_site.y(), -kSupportHeight / 2));
  nodes["0"] = compas_node(transformed(make_box({kSupportSide, kSupportSide, kSupportHeight}), T_W_table),
                           "table", T_W_table.translation(), true);
  edges["0"] = json::object();
  for (std::size_t level = 1; level <= tower.size(); ++level) {
    const RecordedStone& stone = record.stones[tower[level - 1]];
    const Pose& T_W_O = last_pose(stone);
    json node = compas_node(transformed(stone.mesh, T_W_O), stone.name, T_W_O.translation(), false);
    node["T_W_O"] = pose_json(T_W_O);
    nodes[std::to_string(level)] = node;
    edges[std::to_string(level - 1)][std::to_string(level)] = {{"interfaces", nullptr}};
    edges[std::to_string(level)] = json::object();
    sequence.push_back(level);
  }
  for (const RecordedCarry& carry : record.carries) trajectories.push_back(compas_trajectory(record, carry));
  const json graph{{"attributes", {{"name", "Graph"}}},
                   {"default_node_attributes", {{"block", nullptr}, {"is_support", false}}},
                   {"default_edge_attributes", {{"interfaces", nullptr}}},
                   {"node", nodes},
                   {"edge", edges},
                   {"max_node", tower.size()}};
  return document({{"dtype", "compas_assembly.datastructures/Assembly"},
                   {"data",
                    {{"attributes",
                      {{"name", "stonestack run"},
                       {"robot", record.robot},
                       {"seed", record.seed},
                       {"T_W_R", pose_json(record.T_W_R)},
                       {"sequence", sequence},
                       {"trajectories", trajectories}}},
                     {"graph", {{"dtype", "compas.datastructures/Graph"}, {"data", graph}}}}}},
                  -1);
}

std::vector<std::string> export_formats() {
  return {"glb", "ply", "urdf", "csv", "mcap", "png", "compas"};
}

std::vector<std::string> export_run(const std::string& run, const std::string& format,
                                    const std::string& out) {
  const auto known = export_formats();
  require(std::find(known.begin(), known.end(), format) != known.end(), "a run is not exported to '", format,
          "'; formats: glb, ply, urdf, csv, mcap, png, compas");
  const RunRecord record = read_run_record(run);
  const std::string folder = out.empty() ? run + "/export" : out;
  const auto written = [&](const std::string& name, const std::string& content) {
    write_file(folder + "/" + name, content);
    return std::vector<std::string>{folder + "/" + name};
  };
  if (format == "glb") return written("run.glb", to_glb(record));
  if (format == "mcap") return written("run.mcap", to_mcap(record));
  if (format == "compas") return written("assembly.json", to_compas(record));
  if (format == "urdf") return export_urdf(record, folder);
  if (format == "csv") return export_csv(record, folder);
  if (format == "ply") return {export_ply(record, folder)};
  return {export_png(record, folder)};
}

std::string export_json(const std::string& format, const std::vector<std::string>& files) {
  return document({{"schema", "stonestack.export/1"}, {"format", format}, {"files", files}});
}

}  // namespace stonestack::report
