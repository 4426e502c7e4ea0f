#include <cmath>

#include "geometry/json_file.hpp"
#include "report/text.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

constexpr double kCertain = 0.9;

json covariance_json(const Eigen::Matrix<double, 6, 6>& covariance) {
  json rows = json::array();
  for (int i = 0; i < 6; ++i) {
    json row = json::array();
    for (int k = 0; k < 6; ++k) row.push_back(covariance(i, k));
    rows.push_back(row);
  }
  return rows;
}

/// Of one stone; covariance_C has six rows of translation (m) and rotation (rad).
json entry_of(const Catalogue& catalogue, const Detection& found, const std::optional<Pose>& T_W_C) {
  json entry = {{"stone", name_of(catalogue, found.stone)},
                {"T_C_O", pose_json(found.T_C_O)},
                {"score", found.score},
                {"inlier_ratio", found.inlier_ratio},
                {"visible", found.visible},
                {"covariance_C", covariance_json(found.covariance)},
                {"certainty", found.certainty}};
  for (const auto& alternative : found.alternatives)
    entry["likes"].push_back({{"stone", name_of(catalogue, alternative.stone)},
                              {"T_C_O", pose_json(alternative.T_C_O)},
                              {"weight", alternative.weight}});
  if (T_W_C) entry["T_W_O"] = pose_json(*T_W_C * found.T_C_O);
  return entry;
}

json entry_of(const Catalogue& catalogue, const TrackedStone& tracked, const Pose& T_W_C) {
  json entry = {{"stone", name_of(catalogue, tracked.stone)}};
  if (tracked.detection) {
    entry = entry_of(catalogue, *tracked.detection, std::optional<Pose>(T_W_C));
    entry["moved_m"] = tracked.moved.translation;
    entry["turned_rad"] = tracked.moved.angle;
  }
  entry["status"] = to_text(tracked.status);
  return entry;
}

json entry_of(const Catalogue& catalogue, const Explanation& explanation, const std::optional<Pose>& T_W_C) {
  json entry = {{"stone", name_of(catalogue, explanation.stone)},
                {"stage", explanation.stage},
                {"text", explanation.text}};
  if (!explanation.best) return entry;
  const ScoreLosses& lost = explanation.lost;
  entry["best"] = entry_of(catalogue, *explanation.best, T_W_C);
  entry["wanted"] = explanation.wanted;
  entry["lost"] = {{"misfit", lost.misfit},
                   {"seen_through", lost.seen_through},
                   {"in_front", lost.in_front},
                   {"hidden", lost.hidden},
                   {"beside", lost.beside},
                   {"outline", lost.outline},
                   {"below", lost.below},
                   {"bend", lost.bend},
                   {"without_depth", lost.without_depth},
                   {"loose", lost.loose}};
  return entry;
}

/// Names what else a detection may be: the other stones by name, and in how many other poses.
std::string in_words(const Detection& found, const Catalogue& catalogue) {
  std::string others;
  int turned = 0;
  for (const auto& alternative : found.alternatives) {
    const std::string& name = name_of(catalogue, alternative.stone);
    if (alternative.stone == found.stone)
      ++turned;
    else if (others.find("'" + name + "'") == std::string::npos)
      others += concat(others.empty() ? "" : ", ", "'", name, "'");
  }
  std::string words;
  if (!others.empty()) words = "may be " + others + " as well";
  if (turned > 0)
    words += concat(words.empty() ? "" : " and ", "is nearly symmetric: ", turned,
                    " other poses fit as well or nearly");
  return words;
}

Pose pose_in(const json& entry, const std::string& key, const std::string& path) {
  const auto& pose = entry.at(key);
  const auto number = [&](const char* name) { return number_of(pose, name, -1e3, 1e3, path); };
  const Eigen::Quaterniond q(number("qw"), number("qx"), number("qy"), number("qz"));
  if (std::abs(q.norm() - 1.0) > 0.01)
    throw FileError(path, concat("the rotation of ", key, " has length ", q.norm()), "it must be 1");
  return make_pose({number("x"), number("y"), number("z")}, q);
}

}  // namespace

std::string detection_json(const DetectionResult& result, const Catalogue& catalogue,
                           const std::optional<Pose>& T_W_C, const std::vector<Explanation>& explanations) {
  json list = json::array();
  for (const auto& found : result.detections) list.push_back(entry_of(catalogue, found, T_W_C));
  json out = {{"schema", "stonestack.detect/1"}, {"detections", list}, {"note", result.note}};
  if (result.depth_scale_sigma > 0)
    out["depth_scale"] = {{"factor", result.depth_scale}, {"sigma", result.depth_scale_sigma}};
  for (const auto& explanation : explanations)
    out["explanations"].push_back(entry_of(catalogue, explanation, T_W_C));
  return document(out);
}

std::string detection_table(const DetectionResult& result, const Catalogue& catalogue,
                            const SceneView& view) {
  std::string text = format("%-20s %6s %8s %8s   position in the %s frame (m)\n", "stone", "score", "inliers",
                            "visible", view.world ? "world" : "camera");
  for (const auto& found : result.detections) {
    const Eigen::Vector3d p_C = found.T_C_O.translation();
    const Eigen::Vector3d p = view.world ? Eigen::Vector3d(*view.T_W_C * p_C) : p_C;
    text += format("%-20s %6.3f %8.3f %8.3f   %7.4f %7.4f %7.4f\n", name_of(catalogue, found.stone).c_str(),
                   found.score, found.inlier_ratio, found.visible, p.x(), p.y(), p.z());
  }
  return text;
}

std::vector<std::string> detection_warnings(const DetectionResult& result, const Catalogue& catalogue,
                                            const DetectionOptions& options) {
  std::vector<std::string> warnings;
  for (const auto& found : result.detections) {
    const std::string& name = name_of(catalogue, found.stone);
    if (found.certainty < kCertain)
      warnings.push_back(concat(name, " ", in_words(found, catalogue),
                                " (--json lists them); it has a certainty of ", found.certainty));
    if (found.score < options.accept_score)
      warnings.push_back(concat(name, " is here by its inlier ratio; its score of ", found.score,
                                " says that the pose is wrong (detection.accept_score ", options.accept_score,
                                ")"));
  }
  return warnings;
}

std::string tracking_json(const TrackResult& result, const Catalogue& catalogue, const Pose& T_W_C) {
  json list = json::array();
  for (const auto& tracked : result.stones) list.push_back(entry_of(catalogue, tracked, T_W_C));
  return document({{"schema", "stonestack.track/1"}, {"tracked", list}, {"note", result.note}});
}

std::string tracking_table(const TrackResult& result, const Catalogue& catalogue) {
  std::string text = format("%-20s %-9s %9s %8s %6s\n", "stone", "status", "moved mm", "deg", "score");
  for (const auto& tracked : result.stones) {
    text += format("%-20s %-9s", name_of(catalogue, tracked.stone).c_str(), to_text(tracked.status).c_str());
    if (tracked.detection)
      text += format(" %9.1f %8.1f %6.3f", 1000.0 * tracked.moved.translation,
                     tracked.moved.angle * 180.0 / M_PI, tracked.detection->score);
    text += "\n";
  }
  return text;
}

std::vector<NamedPose> read_seen_poses(const std::string& path) {
  std::vector<NamedPose> poses;
  if (is_scene_file(path)) {
    const SceneFile scene = read_scene_file(path);
    poses = scene.stack;
    poses.insert(poses.end(), scene.stones.begin(), scene.stones.end());
    return poses;
  }
  const auto content = read_json(path);
  const char* key = content.is_object() && content.contains("tracked") ? "tracked" : "detections";
  if (!content.is_object() || !content.contains(key) || !content.at(key).is_array())
    throw FileError(path, "holds no detections", "give a scene file, or what detect --json printed");
  for (const auto& entry : content.at(key)) {
    if (!entry.is_object() || !entry.contains("stone") || !entry.at("stone").is_string())
      throw FileError(path, "has an entry without a stone", "give what detect --json printed");
    if (entry.contains("T_W_O"))
      poses.push_back({entry.at("stone").get<std::string>(), pose_in(entry, "T_W_O", path)});
    else if (key == std::string("detections"))
      throw FileError(path, "has no T_W_O: the camera's pose was not known",
                      "detect again with --camera-pose, so that the camera may move");
  }
  return poses;
}

}  // namespace stonestack::report
