#include "geometry/bop_folder.hpp"

#include <nlohmann/json.hpp>
#include <sstream>

#include "geometry/depth_unit.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::geometry {
namespace {

/// Entry of one image in scene_camera.json; lengths in mm.
nlohmann::json bop_entry(const DepthRecord& record) {
  const CameraIntrinsics& camera = record.camera;
  nlohmann::json entry = {{"cam_K", {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0}},
                          {"depth_scale", 1000.0 * record.unit},
                          {"time", record.time}};
  if (camera.distortion != CameraIntrinsics::Distortion::kNone) {
    entry["distortion"] = distortion_name(camera.distortion);
    entry["k"] = camera.k;
  }
  if (!record.T_W_C) return entry;
  const Pose T_C_W = record.T_W_C->inverse();
  for (int i = 0; i < 9; ++i) entry["cam_R_w2c"].push_back(T_C_W.linear()(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) entry["cam_t_w2c"].push_back(1000.0 * T_C_W.translation()(i));
  return entry;
}

/// A line an image, in order.
std::string scene_camera_text(const std::vector<DepthRecord>& records) {
  std::string text;
  for (const DepthRecord& record : records)
    text += concat(text.empty() ? "{\n" : ",\n", '"', record.number, "\": ", bop_entry(record).dump());
  return text + "\n}\n";
}

}  // namespace

std::string bop_depth_path(const std::string& folder, int number) {
  std::ostringstream name;
  name.width(6);
  name.fill('0');
  name << number;
  return folder + "/depth/" + name.str() + ".png";
}

std::string distortion_name(CameraIntrinsics::Distortion distortion) {
  using Distortion = CameraIntrinsics::Distortion;
  if (distortion == Distortion::kBrownConrady) return "brown_conrady";
  return distortion == Distortion::kInverseBrownConrady ? "inverse_brown_conrady" : "none";
}

const DepthRecord& BopFolder::add(const DepthImage& image, double time, const std::optional<Pose>& T_W_C) {
  DepthRecord record;
  record.number = static_cast<int>(records_.size());
  record.path = bop_depth_path(path_, record.number);
  record.time = time;
  record.camera = image.camera;
  record.T_W_C = T_W_C;
  if (!records_.empty() && is_depth_unit(image, records_.back().unit))
    record.unit = records_.back().unit;
  else
    record.unit = find_depth_unit(image).value_or(finest_depth_unit(image));
  write_depth_png(record.path, image, record.unit);
  records_.push_back(std::move(record));
  try {
    write_file(path_ + "/scene_camera.json", scene_camera_text(records_));
  } catch (...) {  // no image that the file does not name
    records_.pop_back();
    throw;
  }
  return records_.back();
}

}  // namespace stonestack::geometry
