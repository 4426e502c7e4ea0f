#include <filesystem>
#include <utility>

#include "report/text.hpp"
#include "stonestack/geometry/convex_pieces.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

json deviation_json(const Deviation& deviation) {
  return {{"median", deviation.median}, {"worst", deviation.worst}};
}

/// As the scan's file has it: qw of either sign.
json file_pose_json(const Pose& T_O_file) {
  const Eigen::Vector3d p = T_O_file.translation();
  const Eigen::Quaterniond q(T_O_file.linear());
  return {{"x", p.x()},  {"y", p.y()},  {"z", p.z()}, {"qx", q.x()},
          {"qy", q.y()}, {"qz", q.z()}, {"qw", q.w()}};
}

json stone_json(const StoneSummary& summary, const std::string& catalogue) {
  const Stone& s = summary.stone;
  const Eigen::Vector3d& extents = summary.extents;
  return {{"name", s.name},
          {"folder", (std::filesystem::path(catalogue) / s.name).string()},
          {"source", s.source},
          {"mass", s.mass.mass},
          {"density", s.density},
          {"friction", s.friction},
          {"volume", summary.volume},
          {"volume_over_hull", summary.volume_over_hull},
          {"extents", {extents.x(), extents.y(), extents.z()}},
          {"scale", s.scale},
          {"T_O_file", file_pose_json(s.T_O_file)},
          {"scan_faces", summary.scan_faces},
          {"faces", summary.faces},
          {"pieces", summary.pieces},
          {"mesh_deviation", deviation_json(s.mesh_deviation)},
          {"contact_deviation", deviation_json(s.contact_deviation)},
          {"warnings", summary.warnings}};
}

}  // namespace

StoneSummary summary_of(ModelResult result) {
  StoneSummary summary;
  Stone& stone = result.stone;
  summary.extents = bounds(stone.scan).sizes();
  summary.volume = volume(stone.scan);
  summary.volume_over_hull = summary.volume / volume(convex_hull(stone.scan));
  summary.scan_faces = stone.scan.faces.size();
  summary.faces = stone.mesh.faces.size();
  summary.pieces = stone.pieces.size();
  summary.warnings = std::move(result.warnings);
  stone.scan = stone.mesh = Mesh{};
  stone.pieces.clear();
  summary.stone = std::move(stone);
  return summary;
}

std::string stones_json(const std::vector<StoneSummary>& stones, const std::string& catalogue,
                        const std::vector<FailedScan>& failed) {
  json made = json::array(), not_made = json::array();
  for (const StoneSummary& stone : stones) made.push_back(stone_json(stone, catalogue));
  for (const FailedScan& scan : failed) not_made.push_back({{"file", scan.file}, {"error", scan.error}});
  return document({{"schema", "stonestack.scan/1"}, {"stones", made}, {"failed", not_made}});
}

std::string stones_table(const std::vector<StoneSummary>& stones) {
  std::string text =
      "stone                 size (cm)           mass (kg)  vol/hull  faces  pieces"
      "  mesh off scan (mm)  contact off scan (mm): median / worst\n";
  for (const StoneSummary& summary : stones) {
    const Stone& s = summary.stone;
    const Eigen::Vector3d cm = 100.0 * summary.extents;
    const Deviation &mesh = s.mesh_deviation, &contact = s.contact_deviation;
    text +=
        format("%-20s%6.1f%6.1f%6.1f%13.2f%10.3f%7zu%8zu%11.3f /%6.3f%15.3f /%6.3f\n", s.name.c_str(), cm.x(),
               cm.y(), cm.z(), s.mass.mass, summary.volume_over_hull, summary.faces, summary.pieces,
               1000.0 * mesh.median, 1000.0 * mesh.worst, 1000.0 * contact.median, 1000.0 * contact.worst);
  }
  return text;
}

std::string scene_json(const SimulatedScene& scene, const Catalogue& catalogue, const std::string& folder,
                       int seed) {
  json stones = json::array();
  for (const auto& placed : scene.stones) {
    json stone = placed_json(catalogue, placed.stone, placed.T_W_O);
    stone["T_C_O"] = pose_json(scene.T_W_C.inverse() * placed.T_W_O);
    stones.push_back(stone);
  }
  return document({{"schema", "stonestack.render/1"},
                   {"folder", folder},
                   {"seed", seed},
                   {"T_W_C", pose_json(scene.T_W_C)},
                   {"depth_unit", scene.depth_unit},
                   {"stones", stones}});
}

std::string scene_table(const SimulatedScene& scene, const Catalogue& catalogue) {
  std::string text = format("%-20s   true position in the world (m)\n", "stone");
  for (const auto& placed : scene.stones) {
    const auto& p = placed.T_W_O.translation();
    text +=
        format("%-20s   %7.4f %7.4f %7.4f\n", name_of(catalogue, placed.stone).c_str(), p.x(), p.y(), p.z());
  }
  return text;
}

}  // namespace stonestack::report
