// Noise that recordings show, beside that of the sensors' files, which the simulated cameras have.
#include "sensors.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <numbers>
#include <optional>

#include "geometry/depth_render.hpp"
#include "geometry/depth_sequence.hpp"
#include "simulation/sensor_noise.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/stone/scene_file.hpp"

namespace stonestack::bench {
namespace {

constexpr int kWindow = 4;          // px to each side: 9 x 9 pixels
constexpr double kFlat = 0.006;     // m: a window in which a depth lies further from the plane shows an edge
constexpr double kBin = 0.1;        // m of depth
constexpr int kFewestWindows = 40;  // in a bin: fewer say nothing
constexpr double kSteepest = 0.5;   // cosine: noise of steeper surfaces reaches the limit of a flat window
constexpr double kWall = 3.0;       // m

/// The command line.
struct SensorBench {
  std::vector<std::string> recordings{"f200:../shared/real/apc_f200/test/000001",
                                      "xtion:../shared/real/ycb_xtion/test/000001",
                                      "kinect1:../shared/real/mosd_learn"};
  double farthest = 1.6;
  int seed = 1;
};

/// A window of an image whose depths lie about a plane.
struct FlatWindow {
  double depth = 0.0;        ///< at its middle [m]
  double rms = 0.0;          ///< of the depths about the plane, along its normal [m]
  double cosine = 1.0;       ///< between the line of sight and the normal
  double correlation = 0.0;  ///< of neighbours in a row
};

/// The window about a pixel; empty where a depth is missing or lies off the plane.
std::optional<FlatWindow> flat_window(const DepthImage& image, int u, int v) {
  constexpr int side = 2 * kWindow + 1;
  const double z0 = image.at(u, v);
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d g = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, side, side> off;
  for (int y = -kWindow; y <= kWindow; ++y)
    for (int x = -kWindow; x <= kWindow; ++x) {
      const double z = image.at(u + x, v + y);
      if (!(z > 0.0) || std::abs(z - z0) > 10.0 * kFlat) return {};
      const Eigen::Vector3d row(1.0, x, y);  // the inverse depth of a plane is affine in the pixels
      H += row * row.transpose();
      g += row / z;
      off(y + kWindow, x + kWindow) = z;
    }
  const Eigen::Vector3d w = H.ldlt().solve(g);
  const CameraIntrinsics& camera = image.camera;
  // n . p = 1 with p = z (x, y, 1): n from the gradient of 1 / z.
  const Eigen::Vector3d ray = deproject(camera, u, v);
  const Eigen::Vector3d n(w[1] * camera.fx, w[2] * camera.fy,
                          w[0] - w[1] * camera.fx * ray.x() - w[2] * camera.fy * ray.y());
  FlatWindow out{z0, 0.0, n.dot(ray) / (n.norm() * ray.norm()), 0.0};
  double sum = 0.0, beside = 0.0;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const double plane = 1.0 / (w[0] + w[1] * (x - kWindow) + w[2] * (y - kWindow));
      off(y, x) = (off(y, x) - plane) * out.cosine * ray.norm();
      if (std::abs(off(y, x)) > kFlat) return {};
      sum += off(y, x) * off(y, x);
      if (x > 0) beside += off(y, x) * off(y, x - 1);
    }
  out.rms = std::sqrt(sum / (side * side - 3));
  out.correlation = sum > 0.0 ? beside / (side * (side - 1)) / (sum / (side * side)) : 0.0;
  return out;
}

using Windows = std::map<int, std::vector<FlatWindow>>;  // by bin of depth

void add_windows(Windows& all, const DepthImage& image, double nearest, double farthest) {
  constexpr int side = 2 * kWindow + 1;
  for (int v = kWindow; v + kWindow < image.camera.height; v += side)
    for (int u = kWindow; u + kWindow < image.camera.width; u += side)
      if (const auto window = flat_window(image, u, v);
          window && window->cosine > kSteepest && window->depth > nearest && window->depth < farthest)
        all[static_cast<int>(std::floor(window->depth / kBin))].push_back(*window);
}

template <class Value>
double median(const std::vector<FlatWindow>& windows, Value&& value) {
  std::vector<double> all;
  for (const auto& w : windows) all.push_back(value(w));
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end());
  return *middle;
}

/// Windows of a wall as the sensor's model shows it at that depth, turned by that much.
std::vector<FlatWindow> modelled(const SensorModel& sensor, double depth, double cosine, Random& random) {
  RayScene wall;
  const Eigen::Quaterniond tilt(
      Eigen::AngleAxisd(std::acos(std::clamp(cosine, 0.0, 1.0)), Eigen::Vector3d(1, 1, 0).normalized()));
  wall.add(make_box({kWall, kWall, 0.01}), make_pose(Eigen::Vector3d(0, 0, depth), tilt));
  wall.commit();
  const RenderedView view = render(wall, sensor.camera, Pose::Identity());
  Windows windows;
  add_windows(windows, simulation::add_noise(view, Pose::Identity(), sensor, random), 0.0, kWall);
  std::vector<FlatWindow> all;
  for (auto& [bin, some] : windows)
    for (const auto& w : some)
      if (std::abs(w.depth - depth) < kBin) all.push_back(w);
  return all;
}

/// The images of a folder: organised clouds, or a recording.
std::vector<DepthImage> images_in(const std::string& folder) {
  std::vector<DepthImage> images;
  if (is_depth_sequence(folder)) {
    for (const auto& record : read_depth_sequence(folder).records) images.push_back(read_depth(record));
    return images;
  }
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error))
    if (entry.path().extension() == ".pcd") paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  for (const auto& path : paths) images.push_back(read_view(path, "").image);
  return images;
}

void measure_recording(const std::string& named, const SensorBench& settings, Results& results) {
  const auto colon = named.find(':');
  require(colon != std::string::npos, "a recording is SENSOR:FOLDER, got '", named, "'");
  const SensorModel sensor = read_sensor(named.substr(0, colon));
  const auto images = images_in(named.substr(colon + 1));
  if (images.empty()) {
    results.note("%s has no recording", named.substr(colon + 1).c_str());
    return;
  }
  Windows windows;
  for (const auto& image : images) add_windows(windows, image, sensor.nearest, settings.farthest);
  const auto rms = [](const FlatWindow& w) { return 1000.0 * w.rms; };
  const auto correlation = [](const FlatWindow& w) { return w.correlation; };
  const auto cosine = [](const FlatWindow& w) { return w.cosine; };
  for (const auto& [bin, seen] : windows) {
    throw_if_interrupted();
    if (static_cast<int>(seen.size()) < kFewestWindows) continue;
    const double depth = median(seen, [](const FlatWindow& w) { return w.depth; });
    Random random = Random::stream(static_cast<std::uint64_t>(settings.seed), "bench sensors");
    const auto model = modelled(sensor, depth, median(seen, cosine), random);
    const bool any = !model.empty();
    results.row({sensor.name, depth, seen.size(), std::acos(median(seen, cosine)) * 180.0 / std::numbers::pi,
                 median(seen, rms), any ? TableValue(median(model, rms)) : TableValue(),
                 any ? TableValue(median(model, rms) / median(seen, rms)) : TableValue(),
                 median(seen, correlation), any ? TableValue(median(model, correlation)) : TableValue()});
  }
}

}  // namespace

void add_sensors(CLI::App& app) {
  auto command = std::make_shared<SensorBench>();
  CLI::App* sub =
      app.add_subcommand("sensors", "Noise of recorded depth images beside that of the sensors' files");
  sub->add_option(
         "--recordings", command->recordings,
         "SENSOR:FOLDER, comma-separated: a recording or organised clouds (PCD), and the sensor that "
         "took them")
      ->delimiter(',');
  sub->add_option("--farthest", command->farthest, "m, depths beyond are left out")->capture_default_str();
  sub->add_option("--seed", command->seed, "Of the modelled images")->capture_default_str();
  sub->footer(
      "Windows of 9 x 9 pixels whose depths lie within 6 mm of a plane that is tilted by 60 deg at most, by "
      "depth. tilt: of their\n"
      "planes, median. rms: of the depths about the plane, median over the windows; modelled: the same of a "
      "wall as\nfar away and turned as much, seen by the simulated sensor. correlation: of neighbours in a "
      "row.");
  measure_by(*sub, [command](Results& results) {
    results.settings({{"farthest_m", command->farthest}, {"seed", command->seed}});
    results.table("noise", {{"sensor"},
                            {"depth_m"},
                            {"windows"},
                            {"tilt_deg", 0},
                            {"recorded_rms_mm"},
                            {"modelled_rms_mm"},
                            {"modelled_over_recorded"},
                            {"recorded_correlation"},
                            {"modelled_correlation"}});
    for (const auto& recording : command->recordings) measure_recording(recording, *command, results);
  });
}

}  // namespace stonestack::bench
