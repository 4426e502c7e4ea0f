#include "detection/trace.hpp"

#include <nlohmann/json.hpp>

#include "geometry/pose_json.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/geometry/cloud.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::detection {
namespace {

using nlohmann::json;

json point_json(const Eigen::Vector3f& p) {
  return {p.x(), p.y(), p.z()};
}

void write_points(const std::string& path, std::vector<Eigen::Vector3f> points) {
  if (points.empty()) return;  // a cloud file without points is refused by every reader
  Cloud cloud;
  cloud.width = static_cast<int>(points.size());
  cloud.height = 1;
  cloud.points = std::move(points);
  write_cloud(path, cloud);
}

void write_clusters(const std::string& folder, const TracedTurn& turn) {
  std::vector<std::vector<Eigen::Vector3f>> clusters;
  for (std::size_t i = 0; i < turn.cluster.size(); ++i) {
    if (turn.cluster[i] < 0) continue;
    const auto k = static_cast<std::size_t>(turn.cluster[i]);
    if (clusters.size() <= k) clusters.resize(k + 1);
    clusters[k].push_back(turn.surface_C[i]);
  }
  for (std::size_t k = 0; k < clusters.size(); ++k)
    write_points(concat(folder, "/cluster_", k, ".ply"), std::move(clusters[k]));
}

/// Keypoints of the scene that have a match.
void write_matches(const std::string& folder, const TracedTurn& turn) {
  std::vector<Eigen::Vector3f> points;
  for (const auto& m : turn.matches) points.push_back(m.p_C);
  write_points(folder + "/matches.ply", std::move(points));
}

/// The middle of the stone in every hypothesis, in the order of the JSON.
void write_hypotheses(const std::string& folder, const TracedTurn& turn, std::span<const Stone> stones) {
  std::vector<Eigen::Vector3f> middles;
  for (const auto& h : turn.hypotheses) {
    const Eigen::Vector3d p_O = bounds(at(stones, h.stone).mesh).center();
    middles.emplace_back((h.T_C_O * p_O).cast<float>());
  }
  write_points(folder + "/hypotheses.ply", std::move(middles));
}

json stages_json(const TracedTurn& turn, std::span<const Stone> stones) {
  const auto name = [&](StoneIndex stone) { return at(stones, stone).name; };
  json matches = json::array(), hypotheses = json::array(), candidates = json::array();
  for (const auto& m : turn.matches)
    matches.push_back({{"stone", name(m.stone)},
                       {"p_C", point_json(m.p_C)},
                       {"p_O", point_json(m.p_O)},
                       {"distance", m.distance}});
  for (const auto& h : turn.hypotheses)
    hypotheses.push_back({{"stone", name(h.stone)},
                          {"source", h.source},
                          {"support", h.support},
                          {"T_C_O", pose_json(h.T_C_O)}});
  for (const auto& c : turn.candidates)
    candidates.push_back({{"stone", name(c.detection.stone)},
                          {"T_C_O", pose_json(c.detection.T_C_O)},
                          {"score", c.detection.score},
                          {"inlier_ratio", c.detection.inlier_ratio},
                          {"visible", c.detection.visible},
                          {"wanted", c.wanted},
                          {"accepted", c.accepted}});
  return {{"schema", "stonestack.trace/1"},
          {"points", turn.surface_C.size()},
          {"keypoints", turn.keypoints_C.size()},
          {"matches", matches},
          {"hypotheses", hypotheses},
          {"candidates", candidates}};
}

}  // namespace

void write_trace(const std::string& folder, const DetectionTrace& trace, std::span<const Stone> stones) {
  for (std::size_t t = 0; t < trace.turns.size(); ++t) {
    const TracedTurn& turn = trace.turns[t];
    const std::string here = concat(folder, "/turn_", t + 1);
    write_file(here + "/stages.json", stages_json(turn, stones).dump(1) + "\n");
    write_points(here + "/surface.ply", turn.surface_C);
    write_points(here + "/keypoints.ply", turn.keypoints_C);
    write_clusters(here, turn);
    write_matches(here, turn);
    write_hypotheses(here, turn, stones);
    for (std::size_t k = 0; k < turn.candidates.size(); ++k) {
      const Detection& d = turn.candidates[k].detection;
      write_mesh(concat(here, "/candidate_", k, ".ply"), transformed(at(stones, d.stone).mesh, d.T_C_O));
    }
  }
}

}  // namespace stonestack::detection
