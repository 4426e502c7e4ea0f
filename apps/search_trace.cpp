#include "search_trace.hpp"

#include <nlohmann/json.hpp>

#include "geometry/pose_json.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::apps {
namespace {

nlohmann::json point_json(const Eigen::Vector3d& p) {
  return {p.x(), p.y(), p.z()};
}

nlohmann::json candidate_json(const Catalogue& catalogue, const CandidateTrace& candidate) {
  nlohmann::json path = nlohmann::json::array(), corners = nlohmann::json::array();
  for (const Pose& T_W_O : candidate.path_W_O) path.push_back(pose_json(T_W_O));
  for (const Eigen::Vector3d& corner : candidate.support.corners_W) corners.push_back(point_json(corner));
  return {{"stone", catalogue.stones[static_cast<std::size_t>(candidate.stone)].name},
          {"outcome", candidate.outcome},
          {"cost", candidate.cost},
          {"terms", candidate.terms},
          {"path_W_O", path},
          {"polygon_W",
           {{"corners", corners},
            {"centroid", point_json(candidate.support.p_W_centroid)},
            {"normal", point_json(candidate.support.n_W)},
            {"area_m2", candidate.support.area},
            {"margin_m", candidate.support.margin},
            {"contacts", candidate.support.contacts}}}};
}

}  // namespace

void write_trace(const std::string& folder, const Catalogue& catalogue, const SearchResult& result) {
  const std::string path = folder + "/candidates.json";
  nlohmann::json list = nlohmann::json::array();
  for (const CandidateTrace& candidate : result.trace) list.push_back(candidate_json(catalogue, candidate));
  write_file(path, nlohmann::json{{"schema", "stonestack.trace/1"}, {"candidates", list}}.dump(1) + "\n");
  log_info(concat("wrote ", path, ": ", list.size(), " candidates"));
}

}  // namespace stonestack::apps
