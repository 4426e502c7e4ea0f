#include "detection_json.hpp"

#include "geometry/pose_json.hpp"

namespace stonestack::apps {
namespace {

nlohmann::json covariance_json(const Eigen::Matrix<double, 6, 6>& covariance) {
  nlohmann::json rows = nlohmann::json::array();
  for (int i = 0; i < 6; ++i) {
    nlohmann::json row = nlohmann::json::array();
    for (int k = 0; k < 6; ++k) row.push_back(covariance(i, k));
    rows.push_back(row);
  }
  return rows;
}

}  // namespace

nlohmann::json detection_json(const Catalogue& catalogue, const Detection& found,
                              const std::optional<Pose>& T_W_C) {
  nlohmann::json entry = {{"stone", catalogue.stones[static_cast<std::size_t>(found.stone)].name},
                          {"T_C_O", pose_json(found.T_C_O)},
                          {"score", found.score},
                          {"inlier_ratio", found.inlier_ratio},
                          {"visible", found.visible},
                          {"covariance_C", covariance_json(found.covariance)}};
  entry["certainty"] = found.certainty;
  for (const auto& alternative : found.alternatives)
    entry["likes"].push_back({{"stone", catalogue.stones[static_cast<std::size_t>(alternative.stone)].name},
                              {"T_C_O", pose_json(alternative.T_C_O)},
                              {"weight", alternative.weight}});
  if (T_W_C) entry["T_W_O"] = pose_json(*T_W_C * found.T_C_O);
  return entry;
}

}  // namespace stonestack::apps
