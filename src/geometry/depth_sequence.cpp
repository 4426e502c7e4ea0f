#include "geometry/depth_sequence.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "geometry/bop_folder.hpp"
#include "geometry/json_file.hpp"

namespace stonestack::geometry {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxText = 64U << 20U;
constexpr double kFinest = 1e-6, kCoarsest = 0.1;  // m a count
constexpr double kSameTime = 0.020;                // s, between a depth image and a pose (TUM's tool)

[[noreturn]] void need_unit(const std::string& path) {
  throw FileError(path, "does not say how many metres a count is",
                  "give --depth-unit (TUM: 0.0002, Open3D and RealSense: usually 0.001)");
}

/// The unit of the file (0: it has none) or of the caller; both must agree.
double agreed_unit(double in_file, double given, const std::string& path) {
  if (in_file == 0.0 && given == 0.0) need_unit(path);
  if (in_file == 0.0 || given == 0.0) return in_file + given;
  if (std::abs(in_file - given) > 1e-3 * given)
    throw FileError(path, concat("says ", in_file, " m a count, but ", given, " was given"),
                    "leave one of them out");
  return in_file;
}

CameraIntrinsics pinhole(double fx, double fy, double cx, double cy, const std::string& path) {
  if (!(fx > 1 && fy > 1 && fx < 1e5 && fy < 1e5 && std::abs(cx) < 1e5 && std::abs(cy) < 1e5))
    throw FileError(path, concat("has a camera with fx ", fx, ", fy ", fy, ", cx ", cx, ", cy ", cy),
                    "correct the intrinsics; they are in pixels");
  CameraIntrinsics camera;
  camera.fx = fx, camera.fy = fy, camera.cx = cx, camera.cy = cy;
  return camera;
}

std::vector<std::string> pictures(const std::string& folder) {
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".png") paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  return paths;
}

/// T_W_C from rotation (rows) and translation (mm) of the world in the camera.
std::optional<Pose> bop_camera_pose(const nlohmann::json& entry, const std::string& path) {
  if (!entry.contains("cam_R_w2c") || !entry.contains("cam_t_w2c")) return {};
  const auto R = numbers_of(entry, "cam_R_w2c", 9, path), t = numbers_of(entry, "cam_t_w2c", 3, path);
  Pose T_C_W = Pose::Identity();
  T_C_W.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data());
  T_C_W.translation() = 0.001 * Eigen::Vector3d(t[0], t[1], t[2]);
  const Eigen::Matrix3d rest = T_C_W.linear() * T_C_W.linear().transpose() - Eigen::Matrix3d::Identity();
  if (!(rest.cwiseAbs().maxCoeff() < 0.01) || T_C_W.linear().determinant() < 0)
    throw FileError(path, "cam_R_w2c is not a rotation", "correct it");
  return orthonormal(T_C_W).inverse();
}

/// The camera with the lens distortion of an image that `BopFolder` has written; BOP has none.
CameraIntrinsics with_lens(CameraIntrinsics camera, const nlohmann::json& entry, const std::string& path) {
  using Distortion = CameraIntrinsics::Distortion;
  if (!entry.contains("distortion")) return camera;
  const auto& name = entry["distortion"];
  for (const Distortion kind : {Distortion::kBrownConrady, Distortion::kInverseBrownConrady})
    if (name == distortion_name(kind)) camera.distortion = kind;
  if (camera.distortion == Distortion::kNone && name != distortion_name(Distortion::kNone))
    throw FileError(path, concat("distortion is ", name.dump()),
                    "it must be none, brown_conrady or inverse_brown_conrady");
  if (camera.distortion == Distortion::kNone) return camera;
  const auto k = numbers_of(entry, "k", 5, path);
  std::copy(k.begin(), k.end(), camera.k);
  return camera;
}

DepthSequence read_bop(const std::string& folder, const DepthSequenceInput& input) {
  const std::string path = folder + "/scene_camera.json";
  DepthSequence out{"bop", {}};
  const auto content = read_json(path);
  if (!content.is_object()) throw FileError(path, "is not a map of images", "download it again");
  for (const auto& [key, entry] : content.items()) {
    DepthRecord record;
    if (key.empty() || key.size() > 9 || key.find_first_not_of("0123456789") != std::string::npos)
      throw FileError(path, "has an image named '" + key + "'", "images are numbered");
    record.number = std::stoi(key);
    record.path = bop_depth_path(folder, record.number);
    record.unit = agreed_unit(0.001 * number_of(entry, "depth_scale", 1e-3, 1e2, path), input.unit, path);
    const auto K = numbers_of(entry, "cam_K", 9, path);
    record.camera = input.camera.value_or(with_lens(pinhole(K[0], K[4], K[2], K[5], path), entry, path));
    record.T_W_C = bop_camera_pose(entry, path);
    if (entry.contains("time") && entry["time"].is_number()) record.time = entry["time"].get<double>();
    out.records.push_back(record);
  }
  std::sort(out.records.begin(), out.records.end(),
            [](const DepthRecord& a, const DepthRecord& b) { return a.number < b.number; });
  return out;
}

/// Open3D writes a matrix column by column: by rows, the principal point stands where zeros belong.
void check_columns(const std::vector<double>& K, const std::string& path) {
  if (K[2] == 0.0 && K[5] == 0.0 && (K[6] != 0.0 || K[7] != 0.0)) return;
  throw FileError(path,
                  concat("intrinsic_matrix is [", K[0], ", ", K[1], ", ", K[2], ", ", K[3], ", ", K[4], ", ",
                         K[5], ", ", K[6], ", ", K[7], ", ", K[8], "]"),
                  "write it by columns: [fx, 0, 0, 0, fy, 0, cx, cy, 1]");
}

/// `width` and `height` of the intrinsics, where they are given, are those of the pictures.
void check_size(const nlohmann::json& content, const DepthRecord& record, const std::string& path) {
  if (!content.contains("width") || !content.contains("height")) return;
  const Eigen::Vector2d stated(number_of(content, "width", 1, 1e5, path),
                               number_of(content, "height", 1, 1e5, path));
  const Eigen::Vector2i size = png_size(record.path);
  if (stated == size.cast<double>()) return;
  throw FileError(path,
                  concat("is of images of ", stated.x(), " x ", stated.y(), " pixels, but ", record.path,
                         " has ", size.x(), " x ", size.y()),
                  "give the intrinsics of this stream, or --camera fx,fy,cx,cy");
}

DepthSequence read_open3d(const std::string& folder, const DepthSequenceInput& input) {
  const std::string path = folder + "/camera_intrinsic.json";
  const auto content = read_json(path);
  const auto K = numbers_of(content, "intrinsic_matrix", 9, path);  // column by column
  if (!input.camera) check_columns(K, path);
  DepthRecord record;
  record.camera = input.camera.value_or(pinhole(K[0], K[4], K[6], K[7], path));
  const double in_file =
      content.contains("depth_scale") ? 1.0 / number_of(content, "depth_scale", 10, 1e6, path) : 0.0;
  record.unit = agreed_unit(in_file, input.unit, path);
  DepthSequence out{"open3d", {}};
  for (const auto& picture : pictures(folder + "/depth")) {
    record.path = picture;
    record.number = static_cast<int>(out.records.size());
    if (!input.camera) check_size(content, record, path);
    out.records.push_back(record);
  }
  return out;
}

/// Lines of numbers and words; comments start with '#'.
std::vector<std::vector<std::string>> table(const std::string& path, std::size_t columns) {
  std::istringstream lines(read_file(path, kMaxText));
  std::vector<std::vector<std::string>> rows;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::vector<std::string> row;
    for (std::string word; words >> word;) row.push_back(word);
    if (row.empty()) continue;
    if (row.size() < columns)
      throw FileError(path, concat("line ", number, " has ", row.size(), " columns of ", columns),
                      "correct that line");
    rows.push_back(std::move(row));
  }
  return rows;
}

double to_number(const std::string& word, const std::string& path) {
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  if (end == word.c_str() || *end != '\0' || !std::isfinite(value))
    throw FileError(path, "'" + word + "' is not a number", "correct it");
  return value;
}

std::vector<std::pair<double, Pose>> tum_poses(const std::string& path) {
  std::vector<std::pair<double, Pose>> poses;
  if (!fs::exists(path)) return poses;
  for (const auto& row : table(path, 8)) {
    double v[8];
    for (std::size_t i = 0; i < 8; ++i) v[i] = to_number(row[i], path);
    const Eigen::Quaterniond q(v[7], v[4], v[5], v[6]);
    if (std::abs(q.norm() - 1.0) > 0.01)
      throw FileError(path, concat("the rotation at ", row[0], " has length ", q.norm()), "it must be 1");
    poses.emplace_back(v[0], make_pose({v[1], v[2], v[3]}, q));
  }
  return poses;
}

DepthSequence read_tum(const std::string& folder, const DepthSequenceInput& input) {
  const std::string path = folder + "/depth.txt";
  if (!input.camera)
    throw FileError(path, "comes without the camera's intrinsics",
                    "give --camera fx,fy,cx,cy (TUM's freiburg1: 517.3,516.5,318.6,255.3)");
  const auto poses = tum_poses(folder + "/groundtruth.txt");
  DepthSequence out{"tum", {}};
  for (const auto& row : table(path, 2)) {
    const fs::path file(row[1]);
    if (file.is_absolute() || row[1].find("..") != std::string::npos)
      throw FileError(path, "names '" + row[1] + "'", "files must be inside the folder");
    DepthRecord record;
    record.path = folder + "/" + row[1];
    record.number = static_cast<int>(out.records.size());
    record.time = to_number(row[0], path);
    record.unit = agreed_unit(0.0, input.unit, path);
    record.camera = *input.camera;
    double nearest = kSameTime;
    for (const auto& [time, pose] : poses)
      if (std::abs(time - record.time) <= nearest)
        nearest = std::abs(time - record.time), record.T_W_C = pose;
    out.records.push_back(record);
  }
  return out;
}

}  // namespace

bool is_depth_sequence(const std::string& folder) {
  return fs::is_directory(folder) &&
         (fs::exists(folder + "/scene_camera.json") || fs::exists(folder + "/camera_intrinsic.json") ||
          fs::exists(folder + "/depth.txt"));
}

DepthSequence read_depth_sequence(const std::string& folder, const DepthSequenceInput& input) {
  if (input.unit != 0.0)
    require(input.unit >= kFinest && input.unit <= kCoarsest, "a depth unit is ", kFinest, " to ", kCoarsest,
            " m a count, got ", input.unit);
  if (!is_depth_sequence(folder))
    throw FileError(
        folder, "is no folder of depth images in a known layout",
        "it must contain scene_camera.json (BOP), camera_intrinsic.json (Open3D) or depth.txt (TUM)");
  DepthSequence out = fs::exists(folder + "/scene_camera.json")       ? read_bop(folder, input)
                      : fs::exists(folder + "/camera_intrinsic.json") ? read_open3d(folder, input)
                                                                      : read_tum(folder, input);
  if (out.records.empty()) throw FileError(folder, "has no depth image", "record it again");
  for (auto& record : out.records) {
    const Eigen::Vector2i size = png_size(record.path);
    record.camera.width = size.x();
    record.camera.height = size.y();
    if (!input.camera) check_principal_point(record.camera, folder);
  }
  return out;
}

void check_principal_point(const CameraIntrinsics& camera, const std::string& path) {
  const Eigen::Array2d size(camera.width, camera.height), at(camera.cx, camera.cy);
  if ((at > -0.5 * size).all() && (at < 1.5 * size).all()) return;
  throw FileError(path,
                  concat("has its principal point at ", camera.cx, ", ", camera.cy, " in an image of ",
                         camera.width, " x ", camera.height, " pixels"),
                  "give fx,fy,cx,cy of this image, in pixels and in this order");
}

Eigen::Vector2i png_size(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  unsigned char head[24] = {};
  file.read(reinterpret_cast<char*>(head), sizeof head);
  constexpr unsigned char kSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  if (!file || !std::equal(std::begin(kSignature), std::end(kSignature), head))
    throw FileError(path, "is missing or not a PNG", "check the recording");
  const auto number = [&](int at) {
    return (head[at] << 24) | (head[at + 1] << 16) | (head[at + 2] << 8) | head[at + 3];
  };
  const Eigen::Vector2i size(number(16), number(20));
  if (size.minCoeff() < 1 || size.maxCoeff() > 16384)
    throw FileError(path, concat("is ", size.x(), " x ", size.y(), " pixels"), "1 to 16384 a side are taken");
  return size;
}

DepthImage read_depth(const DepthRecord& record) {
  return read_depth_png(record.path, record.camera, record.unit);
}

}  // namespace stonestack::geometry
