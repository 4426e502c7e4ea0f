#include "detection_bop.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include "detection/features/models.hpp"
#include "geometry/depth_sequence.hpp"
#include "geometry/json_file.hpp"
#include "pose_error.hpp"
#include "stone/symmetry.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kRightAngle = 5 * 3.14159265358979323846 / 180.0;
constexpr double kRightShift = 0.005;  // m

/// Thresholds of a correct pose (BOP Challenge 2020, section 2.2).
constexpr double kMssdStep = 0.05;  // of the diameter; ten steps
constexpr double kMspdStep = 5.0;   // pixels of an image 640 wide; ten steps
constexpr int kSteps = 10;
constexpr double kAddShare = 0.1;    // of the diameter (Hinterstoisser et al. 2012)
constexpr double kAddClose = 0.005;  // m: a gripper can use the pose
constexpr double kMinVisible = 0.1;  // of a stone's surface: BOP looks for no other

/// The objects of a data set: their numbers, in the order of the models.
struct BopModels {
  std::vector<int> ids;
  std::vector<Stone> stones;
  std::vector<ScoredObject> scored;
  bool from_meshes = false;  ///< symmetries, which models_info.json does not know
};

StoneIndex index_of(const BopModels& models, int object, const std::string& path) {
  const auto at = std::find(models.ids.begin(), models.ids.end(), object);
  if (at == models.ids.end()) throw FileError(path, concat("names object ", object), "models/ has none such");
  return StoneIndex(at - models.ids.begin());
}

int number_in(const std::string& text, const std::string& path) {
  const auto first = text.find_first_of("0123456789");
  if (first == std::string::npos) throw FileError(path, "has no number in its name", "BOP numbers its files");
  return std::atoi(text.c_str() + first);
}

Pose read_symmetry(const nlohmann::json& list, const std::string& path) {
  const auto m = numbers_of(nlohmann::json{{"symmetries_discrete", list}}, "symmetries_discrete", 16, path);
  Pose T = Pose::Identity();
  T.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(m.data());
  T.translation() *= 0.001;
  if ((T.linear() * T.linear().transpose() - Eigen::Matrix3d::Identity()).norm() > 1e-2 ||
      T.linear().determinant() < 0.0)
    throw FileError(path, "symmetries_discrete has a matrix that is no rotation", "correct it");
  return orthonormal(T);
}

AxisOfSymmetry read_axis(const nlohmann::json& entry, const std::string& path) {
  const auto n = numbers_of(entry, "axis", 3, path), p = numbers_of(entry, "offset", 3, path);
  const Eigen::Vector3d axis(n[0], n[1], n[2]);
  if (axis.norm() < 1e-6)
    throw FileError(path, "symmetries_continuous has an axis without direction", "correct it");
  return {axis.normalized(), 0.001 * Eigen::Vector3d(p[0], p[1], p[2])};
}

/// An object with the symmetries that its mesh shows.
ScoredObject scored_by_shape(const Mesh& mesh, const nlohmann::json& info, const std::string& path) {
  const Symmetries found = find_symmetries(mesh);
  std::vector<AxisOfSymmetry> axes;
  for (const auto& axis : found.axes)
    if (axis.order == 0) axes.push_back({axis.n_O, found.p_O});
  std::optional<double> diameter;
  if (!info.is_null() && info.contains("diameter"))
    diameter = 0.001 * number_of(info, "diameter", 1e-3, 1e6, path);
  return make_scored_object(mesh, symmetries(discrete_turns(found), axes), diameter);
}

/// True if some object of models_info.json has a symmetry: those without are known to have none then.
bool names_symmetries(const nlohmann::json& info) {
  return std::any_of(info.begin(), info.end(), [](const nlohmann::json& entry) {
    return entry.contains("symmetries_discrete") || entry.contains("symmetries_continuous");
  });
}

/// An entry of models_info.json; `info` is null where there is none.
ScoredObject scored_object(const Mesh& mesh, const nlohmann::json& info, const std::string& path) {
  if (info.is_null()) return make_scored_object(mesh, std::nullopt, std::nullopt);
  std::vector<Pose> discrete;
  std::vector<AxisOfSymmetry> axes;
  if (info.contains("symmetries_discrete"))
    for (const auto& list : info["symmetries_discrete"]) discrete.push_back(read_symmetry(list, path));
  if (info.contains("symmetries_continuous"))
    for (const auto& entry : info["symmetries_continuous"]) axes.push_back(read_axis(entry, path));
  std::optional<double> diameter;
  if (info.contains("diameter")) diameter = 0.001 * number_of(info, "diameter", 1e-3, 1e6, path);
  return make_scored_object(mesh, symmetries(discrete, axes), diameter);
}

BopModels read_models(const std::string& folder) {
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder + "/models", error))
    if (entry.path().extension() == ".ply") paths.push_back(entry.path().string());
  if (paths.empty()) throw FileError(folder + "/models", "has no .ply", "give the root of a BOP data set");
  std::sort(paths.begin(), paths.end());
  const std::string info_path = folder + "/models/models_info.json";
  const nlohmann::json info = fs::exists(info_path) ? read_json(info_path) : nlohmann::json::object();
  BopModels models;
  models.from_meshes = !names_symmetries(info);
  for (const auto& path : paths) {
    Stone stone;
    stone.name = fs::path(path).stem().string();
    stone.mesh = scaled(read_mesh(path), 0.001);
    models.ids.push_back(number_in(stone.name, path));
    const std::string id = std::to_string(models.ids.back());
    const nlohmann::json entry = info.contains(id) ? info[id] : nlohmann::json();
    models.scored.push_back(models.from_meshes ? scored_by_shape(stone.mesh, entry, info_path)
                                               : scored_object(stone.mesh, entry, info_path));
    models.stones.push_back(std::move(stone));
  }
  return models;
}

/// Which objects to look for in an image, each named as often as it is there; empty: all, once.
using Target = std::vector<StoneIndex>;

std::map<std::pair<int, int>, Target> read_targets(const std::string& folder, const BopModels& models) {
  const std::string path = folder + "/test_targets_bop19.json";
  std::map<std::pair<int, int>, Target> targets;
  if (!fs::exists(path)) return targets;
  for (const auto& entry : read_json(path)) {
    const int scene = static_cast<int>(number_of(entry, "scene_id", 0, 1e6, path));
    const int image = static_cast<int>(number_of(entry, "im_id", 0, 1e6, path));
    const int object = static_cast<int>(number_of(entry, "obj_id", 0, 1e6, path));
    const StoneIndex model = index_of(models, object, path);
    Target& target = targets[{scene, image}];
    const auto count = static_cast<std::size_t>(number_of(entry, "inst_count", 1, 1000, path));
    target.insert(target.end(), count, model);
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

/// A true pose.
struct BopTruth {
  StoneIndex model = kNoStone;
  Pose T_C_O = Pose::Identity();
  double visible = 1.0;  ///< share of what faces the camera
};

/// By image; empty without scene_gt.json. How much is visible stands in scene_gt_info.json, if there is one.
std::map<int, std::vector<BopTruth>> read_truth(const std::string& scene, const BopModels& models) {
  const std::string path = scene + "/scene_gt.json", info_path = scene + "/scene_gt_info.json";
  std::map<int, std::vector<BopTruth>> truth;
  if (!fs::exists(path)) return truth;
  const auto content = read_json(path);
  const auto info = fs::exists(info_path) ? read_json(info_path) : nlohmann::json::object();
  for (const auto& [key, list] : content.items()) {
    auto& of_image = truth[number_in(key, path)];
    for (const auto& entry : list) {
      const auto R = numbers_of(entry, "cam_R_m2c", 9, path), t = numbers_of(entry, "cam_t_m2c", 3, path);
      BopTruth one;
      one.T_C_O.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data());
      one.T_C_O.translation() = 0.001 * Eigen::Vector3d(t[0], t[1], t[2]);
      one.T_C_O = orthonormal(one.T_C_O);
      one.model = index_of(models, static_cast<int>(number_of(entry, "obj_id", 0, 1e6, path)), path);
      if (info.contains(key) && info[key].is_array() && info[key].size() > of_image.size())
        one.visible = number_of(info[key][of_image.size()], "visib_fract", -1, 1, info_path);
      of_image.push_back(one);
    }
  }
  return truth;
}

/// The true poses that are to be found: of each object as many as the target names, the most visible ones;
/// without a target those of which enough is visible.
std::vector<BopTruth> wanted(std::vector<BopTruth> truth, const Target& target) {
  std::stable_sort(truth.begin(), truth.end(),
                   [](const BopTruth& a, const BopTruth& b) { return a.visible > b.visible; });
  std::map<StoneIndex, std::ptrdiff_t> taken;
  std::erase_if(truth, [&](const BopTruth& t) {
    if (target.empty()) return t.visible < kMinVisible;
    return ++taken[t.model] > std::count(target.begin(), target.end(), t.model);
  });
  return truth;
}

/// Objects that an image shows although its truth has no pose of them: they count neither for nor against.
/// {image: [object, ...]} in present_without_pose.json of the scene, if there is one.
std::map<int, std::set<int>> read_unposed(const std::string& scene) {
  const std::string path = scene + "/present_without_pose.json";
  std::map<int, std::set<int>> unposed;
  if (!fs::exists(path)) return unposed;
  const nlohmann::json content = read_json(path);
  for (const auto& [key, list] : content.items()) {
    if (!list.is_array()) throw FileError(path, concat("has no list for image ", key), "list object numbers");
    for (const auto& entry : list) {
      if (!entry.is_number_integer())
        throw FileError(path, concat("has something else than an object's number for image ", key),
                        "list object numbers");
      unposed[number_in(key, path)].insert(entry.get<int>());
    }
  }
  return unposed;
}

/// Detections of one model where the image's truth names no pose of it, however little is visible.
int count_absent(std::size_t found, StoneIndex model, int object, const std::vector<BopTruth>& truth,
                 const std::set<int>& unposed) {
  const bool there =
      unposed.count(object) > 0 ||
      std::any_of(truth.begin(), truth.end(), [&](const BopTruth& t) { return t.model == model; });
  return there ? 0 : static_cast<int>(found);
}

/// How many true poses (columns) are met by estimates (rows, best score first) with an error below `max`:
/// each estimate takes the nearest that is left, as in the BOP toolkit's pose_matching.py.
int count_matched(const Eigen::MatrixXd& errors, double max) {
  std::set<Eigen::Index> taken;
  for (Eigen::Index e = 0; e < errors.rows(); ++e) {
    Eigen::Index best = -1;
    for (Eigen::Index t = 0; t < errors.cols(); ++t)
      if (taken.count(t) == 0 && errors(e, t) < max && (best < 0 || errors(e, t) < errors(e, best))) best = t;
    if (best >= 0) taken.insert(best);
  }
  return static_cast<int>(taken.size());
}

/// Counts of one object.
struct BopScore {
  int present = 0;
  int right = 0;           ///< within 5 deg and 5 mm of a pose that looks the same
  int mssd = 0, mspd = 0;  ///< correct poses, summed over the thresholds
  int add_s = 0, add_s_close = 0;
  int absent = 0;  ///< reported in images that do not show it

  void add(const BopScore& other) {
    present += other.present;
    right += other.right;
    mssd += other.mssd;
    mspd += other.mspd;
    add_s += other.add_s;
    add_s_close += other.add_s_close;
    absent += other.absent;
  }
};

/// The estimates of one object in one image.
BopScore score(const ScoredObject& object, std::vector<Detection> found, const std::vector<BopTruth>& truth,
               const CameraIntrinsics& camera) {
  std::stable_sort(found.begin(), found.end(),
                   [](const Detection& a, const Detection& b) { return a.score > b.score; });
  const auto errors = [&](const auto& error) {
    Eigen::MatrixXd table(found.size(), truth.size());
    for (std::size_t e = 0; e < found.size(); ++e)
      for (std::size_t t = 0; t < truth.size(); ++t)
        table(static_cast<Eigen::Index>(e), static_cast<Eigen::Index>(t)) =
            error(found[e].T_C_O, truth[t].T_C_O);
    return table;
  };
  BopScore score;
  score.present = static_cast<int>(truth.size());
  const auto to_surface = errors([&](const Pose& a, const Pose& b) { return add_s(object, a, b); });
  score.add_s = count_matched(to_surface, kAddShare * object.diameter);
  score.add_s_close = count_matched(to_surface, kAddClose);
  if (object.symmetries.empty()) return score;
  score.right = count_matched(errors([&](const Pose& a, const Pose& b) {
                                const PoseDifference off = symmetric_difference(object, a, b);
                                return std::max(off.angle / kRightAngle, off.translation / kRightShift);
                              }),
                              1.0);
  const auto in_space = errors([&](const Pose& a, const Pose& b) { return mssd(object, a, b); });
  const auto in_image = errors([&](const Pose& a, const Pose& b) { return mspd(object, a, b, camera); });
  for (int k = 1; k <= kSteps; ++k) {
    score.mssd += count_matched(in_space, k * kMssdStep * object.diameter);
    score.mspd += count_matched(in_image, k * kMspdStep * camera.width / 640.0);
  }
  return score;
}

std::string symmetry_text(const ScoredObject& object) {
  if (object.symmetries.empty()) return "unknown";
  return object.symmetries.size() == 1 ? "none" : concat(object.symmetries.size(), " poses");
}

/// A row an object that is there, then all of them.
void report(const std::string& method, const BopModels& models, const std::vector<BopScore>& scores,
            Results& results) {
  results.table("true poses found by " + method, {{"object"},
                                                  {"symmetries"},
                                                  {"present"},
                                                  {"within_5_deg_5_mm"},
                                                  {"mssd_recall_percent", 1},
                                                  {"mspd_recall_percent", 1},
                                                  {"add_s_recall_percent", 1},
                                                  {"add_s_below_5_mm"},
                                                  {"reported_where_absent"}});
  BopScore all;
  bool known = true;
  const auto row = [&](const std::string& name, const std::string& symmetry, const BopScore& s,
                       bool with_symmetries) {
    const auto share = [&](int found, int tries) { return 100.0 * found / (tries * s.present); };
    const auto if_present = [&](double value) { return s.present > 0 ? TableValue(value) : TableValue(); };
    const auto if_known = [&](TableValue value) { return with_symmetries ? std::move(value) : TableValue(); };
    results.row({name, symmetry, s.present, if_known(s.right), if_known(if_present(share(s.mssd, kSteps))),
                 if_known(if_present(share(s.mspd, kSteps))), if_present(share(s.add_s, 1)), s.add_s_close,
                 s.absent});
  };
  for (std::size_t i = 0; i < scores.size(); ++i) {
    if (scores[i].present + scores[i].absent == 0) continue;
    row(models.stones[i].name, symmetry_text(models.scored[i]), scores[i],
        !models.scored[i].symmetries.empty());
    known = known && !models.scored[i].symmetries.empty();
    all.add(scores[i]);
  }
  if (all.present + all.absent > 0) row("all", "", all, known);
  if (models.from_meshes)
    results.note("models/models_info.json names no symmetry: those that the meshes show are counted");
  if (!known)
    results.note(
        "models/models_info.json does not have all objects: their symmetries are unknown, and only ADD-S is "
        "scored, "
        "which does not need them");
}

/// Makes what models make when a scene first needs it, and returns the processor time [s] that this takes.
double prepare(const DetectionModels& models) {
  const double start = processor_seconds();
  for (const auto& model : models.data().models) {
    (void)features_of(model, models.data().options);
    (void)symmetries_of(model);
  }
  return processor_seconds() - start;
}

}  // namespace

void run_bop(const std::string& folder, const std::string& split, const std::string& csv,
             const DetectionOptions& options, Results& results) {
  const BopModels bop = read_models(folder);
  const auto targets = read_targets(folder, bop);
  const DetectionModels models(bop.stones, options);
  const double preparation = prepare(models);
  std::vector<std::string> scenes;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder + "/" + split, error))
    if (entry.is_directory()) scenes.push_back(entry.path().string());
  if (scenes.empty())
    throw FileError(folder + "/" + split, "has no scene", "name the split with --bop-split");
  std::sort(scenes.begin(), scenes.end());
  std::string text = "scene_id,im_id,obj_id,score,R,t,time\n";
  int images = 0, detections = 0;
  double processor = 0.0;  // s
  std::vector<BopScore> scores(bop.ids.size());
  for (const auto& path : scenes) {
    const int scene = number_in(fs::path(path).filename().string(), path);
    auto truth = read_truth(path, bop);
    auto unposed = read_unposed(path);
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
      const double start = processor_seconds();
      const auto found = detect_stones(image, models, target, options).detections;
      const double seconds = watch.seconds();
      processor += processor_seconds() - start;
      for (const auto& d : found) text += result_line(scene, record.number, at(bop.ids, d.stone), d, seconds);
      ++images;
      detections += static_cast<int>(found.size());
      const auto present =
          truth.count(record.number) > 0 ? wanted(truth[record.number], target) : std::vector<BopTruth>{};
      for (std::size_t i = 0; i < scores.size(); ++i) {
        auto of_model = found;
        std::erase_if(of_model, [&](const Detection& d) { return d.stone != StoneIndex(i); });
        auto there = present;
        std::erase_if(there, [&](const BopTruth& t) { return t.model != StoneIndex(i); });
        if (truth.count(record.number) > 0)
          scores[i].absent += count_absent(of_model.size(), StoneIndex(i), bop.ids[i], truth[record.number],
                                           unposed[record.number]);
        if (!there.empty()) scores[i].add(score(bop.scored[i], of_model, there, image.camera));
      }
    }
  }
  write_file(csv, text);
  results.figures(options.method, {{"images", images},
                                   {"detections", detections},
                                   {"cpu_seconds_per_image", processor / std::max(1, images)},
                                   {"cpu_seconds_models_prepared", preparation},
                                   {"written_to", csv}});
  report(options.method, bop, scores, results);
}

}  // namespace stonestack::bench
