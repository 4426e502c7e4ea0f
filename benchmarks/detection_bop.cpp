#include "detection_bop.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>

#include "geometry/json_file.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/geometry/depth_sequence.hpp"
#include "stonestack/geometry/mesh_file.hpp"

namespace stonestack::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kRightAngle = 5 * 3.14159265358979323846 / 180.0;
constexpr double kRightShift = 0.005;  // m

/// The objects of a data set: their numbers, in the order of the models.
struct BopModels {
  std::vector<int> ids;
  std::vector<Stone> stones;
};

int number_in(const std::string& text, const std::string& path) {
  const auto first = text.find_first_of("0123456789");
  if (first == std::string::npos) throw FileError(path, "has no number in its name", "BOP numbers its files");
  return std::atoi(text.c_str() + first);
}

BopModels read_models(const std::string& folder) {
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder + "/models", error))
    if (entry.path().extension() == ".ply") paths.push_back(entry.path().string());
  if (paths.empty()) throw FileError(folder + "/models", "has no .ply", "give the root of a BOP data set");
  std::sort(paths.begin(), paths.end());
  BopModels models;
  for (const auto& path : paths) {
    Stone stone;
    stone.name = fs::path(path).stem().string();
    stone.mesh = scaled(read_mesh(path), 0.001);
    models.ids.push_back(number_in(stone.name, path));
    models.stones.push_back(std::move(stone));
  }
  return models;
}

/// Which objects to look for in an image, each named as often as it is there; empty: all, once.
using Target = std::vector<int>;

std::map<std::pair<int, int>, Target> read_targets(const std::string& folder, const BopModels& models) {
  const std::string path = folder + "/test_targets_bop19.json";
  std::map<std::pair<int, int>, Target> targets;
  if (!fs::exists(path)) return targets;
  for (const auto& entry : read_json(path)) {
    const int scene = static_cast<int>(number_of(entry, "scene_id", 0, 1e6, path));
    const int image = static_cast<int>(number_of(entry, "im_id", 0, 1e6, path));
    const int object = static_cast<int>(number_of(entry, "obj_id", 0, 1e6, path));
    const auto at = std::find(models.ids.begin(), models.ids.end(), object);
    if (at == models.ids.end())
      throw FileError(path, concat("names object ", object), "models/ has none such");
    Target& target = targets[{scene, image}];
    const auto count = static_cast<std::size_t>(number_of(entry, "inst_count", 1, 1000, path));
    target.insert(target.end(), count, static_cast<int>(at - models.ids.begin()));
  }
  return targets;
}

/// One line of the results.
std::string result_line(int scene, int image, int object, const Detection& d, double seconds) {
  std::ostringstream line;
  line.precision(9);
  line << scene << ',' << image << ',' << object << ',' << d.score << ',';
  for (int i = 0; i < 9; ++i) line << (i > 0 ? " " : "") << d.T_C_O.linear()(i / 3, i % 3);
  line << ',';
  for (int i = 0; i < 3; ++i) line << (i > 0 ? " " : "") << 1000.0 * d.T_C_O.translation()(i);
  line << ',' << seconds << '\n';
  return line.str();
}

/// True poses by image: object and T_C_O; empty without scene_gt.json.
std::map<int, std::vector<std::pair<int, Pose>>> read_truth(const std::string& scene) {
  const std::string path = scene + "/scene_gt.json";
  std::map<int, std::vector<std::pair<int, Pose>>> truth;
  if (!fs::exists(path)) return truth;
  const auto content = read_json(path);
  for (const auto& [key, list] : content.items())
    for (const auto& entry : list) {
      const auto R = numbers_of(entry, "cam_R_m2c", 9, path), t = numbers_of(entry, "cam_t_m2c", 3, path);
      Pose T_C_O = Pose::Identity();
      T_C_O.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data());
      T_C_O.translation() = 0.001 * Eigen::Vector3d(t[0], t[1], t[2]);
      truth[number_in(key, path)].emplace_back(static_cast<int>(number_of(entry, "obj_id", 0, 1e6, path)),
                                               orthonormal(T_C_O));
    }
  return truth;
}

/// How many true poses were found.
int count_right(std::vector<std::pair<int, Pose>> truth, const std::vector<Detection>& found,
                const BopModels& models) {
  int right = 0;
  for (const auto& d : found) {
    const auto at = std::find_if(truth.begin(), truth.end(), [&](const auto& t) {
      const auto off = difference(t.second, d.T_C_O);
      return t.first == models.ids[static_cast<std::size_t>(d.stone)] && off.angle < kRightAngle &&
             off.translation < kRightShift;
    });
    if (at == truth.end()) continue;
    ++right;
    truth.erase(at);
  }
  return right;
}

}  // namespace

void run_bop(const std::string& folder, const std::string& split, const std::string& csv,
             const DetectionOptions& options) {
  const BopModels bop = read_models(folder);
  const auto targets = read_targets(folder, bop);
  const DetectionModels models(bop.stones, options);
  std::vector<std::string> scenes;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder + "/" + split, error))
    if (entry.is_directory()) scenes.push_back(entry.path().string());
  if (scenes.empty())
    throw FileError(folder + "/" + split, "has no scene", "name the split with --bop-split");
  std::sort(scenes.begin(), scenes.end());
  std::string text = "scene_id,im_id,obj_id,score,R,t,time\n";
  int images = 0, detections = 0, present = 0, right = 0;
  for (const auto& path : scenes) {
    const int scene = number_in(fs::path(path).filename().string(), path);
    auto truth = read_truth(path);
    for (const auto& record : read_depth_sequence(path).records) {
      throw_if_interrupted();
      Target target;
      if (!targets.empty()) {
        const auto at = targets.find({scene, record.number});
        if (at == targets.end()) continue;
        target = at->second;
      }
      const DepthImage image = read_depth(record);
      const Stopwatch watch;
      const auto found = detect_stones(image, models, target, options).detections;
      const double seconds = watch.seconds();
      for (const auto& d : found)
        text += result_line(scene, record.number, bop.ids[static_cast<std::size_t>(d.stone)], d, seconds);
      ++images;
      detections += static_cast<int>(found.size());
      present += static_cast<int>(truth[record.number].size());
      right += count_right(truth[record.number], found, bop);
    }
  }
  write_file(csv, text);
  std::printf("%d images, %d detections written to %s\n", images, detections, csv.c_str());
  if (present > 0)
    std::printf("of %d true poses %d found within 5 deg and 5 mm (%.1f %%)\n", present, right,
                100.0 * right / present);
}

}  // namespace stonestack::bench
