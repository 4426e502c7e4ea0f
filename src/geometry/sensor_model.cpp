#include "geometry/sensor_model.hpp"

#include <algorithm>

#include "core/field_file.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/options.hpp"

namespace stonestack::geometry {
namespace {

constexpr const char* kSensorSchema = "stonestack.sensor/1";
constexpr const char* kSensorRemedy = "see docs/formats.md, Sensors, and data/sensors/d435.yaml";
constexpr const char* kSensorFolder = "sensors";
constexpr const char* kIdeal = "ideal";

FieldList sensor_fields(SensorModel& s, std::string& schema) {
  const FieldRange pixels{1.0, 10000.0}, metres{0.0, 0.1}, share{0.0, 1.0};
  return {
      field("schema", schema, kSensorSchema),
      field("name", s.name, "of the sensor"),
      field("camera.width", s.camera.width, {16, 4096}, "px", "columns"),
      field("camera.height", s.camera.height, {16, 4096}, "px", "rows"),
      field("camera.fx", s.camera.fx, pixels, "px", "focal length along the rows"),
      field("camera.fy", s.camera.fy, pixels, "px", "focal length along the columns"),
      field("camera.cx", s.camera.cx, pixels, "px", "principal point"),
      field("camera.cy", s.camera.cy, pixels, "px", "principal point"),
      field("unit", s.unit, {1e-6, 0.01}, "m", "of a count of the depth image"),
      field("range.nearest", s.nearest, {0.01, 10.0}, "m", "depth"),
      field("range.farthest", s.farthest, {0.05, 30.0}, "m", "depth"),
      field("noise.constant", s.sigma, metres, "m", "standard deviation at depth 0"),
      field("noise.square", s.sigma_square, metres, "1/m", "added to it, times the square of the depth"),
      field("noise.disparity", s.stereo_subpixel, {0.0, 5.0}, "px", "of a stereo pair, RMS"),
      field("noise.baseline", s.stereo_baseline, {0.001, 1.0}, "m", "of a stereo pair"),
      field("noise.correlation", s.correlation, {0.0, 20.0}, "px", "of neighbours"),
      field("noise.grazing", s.grazing, {0.0, 10.0}, "", "growth at steep surfaces"),
      field("disparity_step", s.disparity_step, {0.0, 2.0}, "px", "0: as fine as the counts"),
      field("min_cosine", s.min_cosine, share, "", "of a surface that gives a return"),
      field("bias.deviation", s.bias, metres, "m", "of a smooth error that stays"),
      field("bias.pixels", s.bias_pixels, {1.0, 4096.0}, "px", "its wave length"),
      field("edge.step", s.edge_step, {0.001, 1.0}, "m", "of depth, from which on it is an edge"),
      field("edge.reach", s.edge_reach, {1, 20}, "px", "of an edge"),
      field("edge.jitter", s.edge_jitter, {0.0, 20.0}, "px", "sideways"),
      field("edge.flying", s.edge_flying, share, "", "pixels between front and back"),
      field("edge.holes", s.edge_holes, share, "", "pixels without a return"),
      field("shadow_baseline", s.shadow_baseline, {0.0, 1.0}, "m", "to the projector or second eye"),
      field("holes.share", s.hole_share, share, "", "of all pixels"),
      field("holes.blobs", s.blobs, {0, 1000}, "", "patches without a return, a frame"),
      field("holes.radius", s.blob_radius, {0.5, 500.0}, "px", "of a patch"),
  };
}

[[noreturn]] void refuse_sensor(const std::string& path, const std::string& problem) {
  throw FileError(path, problem, kSensorRemedy);
}

}  // namespace

SensorModel read_sensor(const std::string& name_or_path) {
  SensorModel sensor;
  if (name_or_path == kIdeal) return sensor;
  const std::string path = core::data_file("sensor", kSensorFolder, name_or_path);
  std::string schema;
  core::read_fields(path, sensor_fields(sensor, schema), kSensorRemedy);
  if (schema != kSensorSchema) refuse_sensor(path, concat("schema is '", schema, "', not ", kSensorSchema));
  if (sensor.nearest >= sensor.farthest)
    refuse_sensor(path, concat("range.nearest ", sensor.nearest, " m is not below range.farthest ",
                               sensor.farthest, " m"));
  if (sensor.camera.cx >= sensor.camera.width || sensor.camera.cy >= sensor.camera.height)
    refuse_sensor(path, "the principal point does not lie in the image");
  if (sensor.edge_flying + sensor.edge_holes > 1.0)
    refuse_sensor(path, "edge.flying and edge.holes are more than all pixels");
  sensor.lens = sensor.camera;
  return sensor;
}

std::vector<std::string> sensor_names() {
  std::vector<std::string> names = core::data_names(kSensorFolder);
  names.insert(std::lower_bound(names.begin(), names.end(), kIdeal), kIdeal);
  return names;
}

CameraIntrinsics nominal_lens(const SensorModel& sensor, int width, int height) {
  CameraIntrinsics lens = sensor.camera;
  const double scale = static_cast<double>(width) / lens.width;
  lens.fx *= scale;
  lens.fy *= scale;
  lens.cx = (lens.cx + 0.5) * scale - 0.5;
  lens.cy = (lens.cy + 0.5) * scale - 0.5 + 0.5 * (height - scale * lens.height);
  lens.width = width;
  lens.height = height;
  return lens;
}

}  // namespace stonestack::geometry
