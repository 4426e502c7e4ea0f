#include "detection/features/models.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "detection/constants.hpp"
#include "detection/features/describe.hpp"
#include "detection/hypotheses/sweep.hpp"
#include "detection/judge/alternatives.hpp"
#include "detection/judge/identity.hpp"
#include "stone/reduce_mesh.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::detection {
namespace {

constexpr float kFieldCell = 0.003F;  // m
constexpr float kFieldBand = 0.020F;  // m: the widest gate of a registration
constexpr int kDrawnFaces = 1500;     // finer meshes cost more time to draw than their details tell
constexpr int kSides = 180;           // about 15 deg apart

SurfacePoints sampled(const Mesh& mesh, double spacing) {
  SurfacePoints out;
  for (const auto& s : sample_surface(mesh, spacing)) {
    if (!(s.normal.squaredNorm() > 0.5)) continue;
    out.points.emplace_back(s.point.cast<float>());
    out.normals.emplace_back(s.normal.cast<float>());
    out.areas.push_back(static_cast<float>(s.area));
  }
  return out;
}

std::vector<ModelSide> make_sides(const SurfacePoints& surface) {
  std::vector<ModelSide> sides;
  for (const auto& d : even_directions(kSides)) {
    ModelSide side{d, Eigen::Vector3f::Zero()};
    for (std::size_t i = 0; i < surface.points.size(); ++i) {
      const float area = surface.areas[i] * std::max(0.0F, surface.normals[i].dot(d));
      side.centre += area * surface.points[i];
      side.area += area;
    }
    side.centre /= std::max(side.area, 1e-9F);
    sides.push_back(side);
  }
  return sides;
}

/// The surface as a camera's voxels would have it: evenly spaced points with normals of local planes.
SurfacePoints as_seen(const SurfacePoints& dense, const SurfaceField& field) {
  SurfacePoints out = surface_points(dense.points, dense.areas, static_cast<float>(kVoxel),
                                     static_cast<float>(kNormalRadius));
  for (std::size_t i = 0; i < out.points.size(); ++i) {
    const int k = field.nearest(out.points[i]);
    if (k >= 0 && dense.normals[static_cast<std::size_t>(k)].dot(out.normals[i]) < 0) out.normals[i] *= -1.0F;
  }
  return out;
}

/// Sums of the flags above and left of each pixel, one row and one column more than the flags (Crow 1984).
std::vector<int> integral(const std::vector<char>& flags, int width, int height) {
  std::vector<int> sums(static_cast<std::size_t>((width + 1) * (height + 1)), 0);
  for (int v = 0; v < height; ++v) {
    int row = 0;
    for (int u = 0; u < width; ++u) {
      row += flags[static_cast<std::size_t>(v * width + u)];
      sums[static_cast<std::size_t>((v + 1) * (width + 1) + u + 1)] =
          sums[static_cast<std::size_t>(v * (width + 1) + u + 1)] + row;
    }
  }
  return sums;
}

}  // namespace

DetectionModel make_detection_model(const Stone& stone) {
  require(!stone.mesh.faces.empty(), "stone ", stone.name, " has no mesh to detect");
  const Eigen::AlignedBox3d box = bounds(stone.mesh);
  const double size = box.diagonal().norm();
  require(size > 0.01 && size < 1.0, "stone ", stone.name, " is ", size,
          " m across; detection takes 1 cm to 1 m");
  SurfacePoints surface = sampled(stone.mesh, kVoxel);
  SurfaceField field(surface.points, kFieldCell, kFieldBand);
  DetectionModel model{stone.name,
                       stone.mesh,
                       {},
                       {},
                       surface_area(stone.mesh),
                       box.center(),
                       0.0,
                       std::move(surface),
                       std::move(field),
                       SurfaceTree(stone.mesh),
                       {},
                       {},
                       {},
                       {},
                       {},
                       0.0};
  model.drawn = reduce_mesh(stone.mesh, kDrawnFaces);
  if (model.drawn.faces.empty()) model.drawn = stone.mesh;  // cannot be reduced
  model.drawn_normals = face_normals(model.drawn);
  model.sigma = surface_sigma(stone, model.surface, model.mesh, model.drawn);
  for (std::size_t k = 0; k < model.surface.points.size(); ++k)
    model.samples.push_back({model.surface.points[k], model.sigma.samples[k], model.surface.normals[k]});
  for (const auto& p : model.drawn.vertices)
    model.drawn_radius = std::max(model.drawn_radius, (p - model.centre).norm());
  for (const auto& p : stone.mesh.vertices) model.radius = std::max(model.radius, (p - model.centre).norm());
  model.sides = make_sides(model.surface);
  return model;
}

const Features& features_of(const DetectionModel& model, const DetectionOptions& options) {
  return model.features.get(
      [&] { return describe_model(model.mesh, as_seen(model.surface, model.field), options); });
}

const std::vector<Pose>& symmetries_of(const DetectionModel& model) {
  return model.symmetries.get([&] { return turns_onto_itself(model); });
}

namespace {

/// True if a point of O is within `margin` of the surface of the model, or of where that may be, or inside.
bool covers(const DetectionModel& model, const Eigen::Vector3d& p_O, double margin) {
  if ((p_O - model.centre).norm() > model.radius + margin) return false;
  const Eigen::Vector3f q = p_O.cast<float>();
  const int k = model.field.nearest(q);
  if (k < 0) return false;
  const ModelSample& near = model.samples[static_cast<std::size_t>(k)];
  const Eigen::Vector3f d = q - near.p;
  return near.n.dot(d) < 0 || d.norm() < std::max(static_cast<float>(margin), 2.0F * near.sigma);
}

/// A stone that is taken out of a scene, and the ball about its centre that holds all its points.
class TakenStone {
 public:
  TakenStone(const DetectionModel& model, const Pose& T_C_O)
      : model_(model),
        T_O_C_(T_C_O.inverse()),
        ball_{T_C_O * model.centre, model.radius + kExplainedMargin},
        reach2_((ball_.radius + kRounding) * (ball_.radius + kRounding)) {}

  [[nodiscard]] const TakenBall& ball() const { return ball_; }

  [[nodiscard]] bool explains(const Eigen::Vector3f& p_C) const {
    const Eigen::Vector3d p = p_C.cast<double>();
    return (p - ball_.centre_C).squaredNorm() <= reach2_ && covers(model_, T_O_C_ * p, kExplainedMargin);
  }

 private:
  static constexpr double kRounding = 1e-6;  // m
  const DetectionModel& model_;
  Pose T_O_C_;
  TakenBall ball_;
  double reach2_;
};

/// Rows and columns of a view that may show a ball: all, where lens distortion bends its outline or the
/// camera is near it.
struct PixelBounds {
  int u0, v0, u1, v1;  ///< from low to below high
};

PixelBounds pixels_of(const TakenBall& ball, const SeenView& view) {
  const CameraIntrinsics& camera = view.depth.camera;
  const PixelBounds all{0, 0, camera.width, camera.height};
  const Eigen::Vector3d centre = view.T_C_V.inverse() * ball.centre_C;
  if (camera.distortion != CameraIntrinsics::Distortion::kNone || !(centre.z() > 1.05 * ball.radius))
    return all;
  Eigen::AlignedBox2d box;
  for (int corner = 0; corner < 8; ++corner) {
    const auto sign = [&](int bit) { return (corner >> bit & 1) != 0 ? ball.radius : -ball.radius; };
    box.extend(project(camera, centre + Eigen::Vector3d(sign(0), sign(1), sign(2))));
  }
  if (!box.min().allFinite() || !box.max().allFinite()) return all;
  const auto within = [](double x, int size) { return static_cast<int>(std::clamp(x, 0.0, 1.0 * size)); };
  return {within(box.min().x() - 1, camera.width), within(box.min().y() - 1, camera.height),
          within(box.max().x() + 2, camera.width), within(box.max().y() + 2, camera.height)};
}

/// Flags the pixels of a view that show a stone.
void flag_explained(SeenView& view, const TakenStone& stone) {
  const CameraIntrinsics& camera = view.depth.camera;
  const PixelBounds bounds = pixels_of(stone.ball(), view);
  tbb::parallel_for(bounds.v0, std::max(bounds.v0, bounds.v1), [&](int v) {
    for (int u = bounds.u0; u < bounds.u1; ++u) {
      const float z = view.depth.at(u, v);
      char& flag = view.explained[static_cast<std::size_t>(v * camera.width + u)];
      if (flag == 0 && z > 0 && stone.explains((view.T_C_V * (z * deproject(camera, u, v))).cast<float>()))
        flag = 1;
    }
  });
}

}  // namespace

bool explains(const DetectionModel& model, const Pose& T_C_O, const Eigen::Vector3f& p_C, double margin) {
  return covers(model, T_C_O.inverse() * p_C.cast<double>(), margin);
}

DetectionScene without_stones(DetectionScene scene, const DetectionModels::Data& data,
                              std::span<const KnownStone> stones) {
  if (stones.empty()) return scene;
  std::vector<TakenStone> taken;
  for (const KnownStone& k : stones) taken.emplace_back(at(data.models, k.stone), k.T_C_O);
  for (auto& view : scene.views) {
    view.explained.resize(view.depth.z.size(), 0);
    for (const TakenStone& stone : taken) flag_explained(view, stone);
    view.explained_before = integral(view.explained, view.depth.camera.width, view.depth.camera.height);
  }
  for (const TakenStone& stone : taken) scene.taken.push_back(stone.ball());
  keep_surface(scene, [&](std::size_t i) {
    return std::none_of(taken.begin(), taken.end(),
                        [&](const TakenStone& stone) { return stone.explains(scene.surface.points[i]); });
  });
  find_clusters(scene, kClusterGap);
  return scene;
}

DetectionModels::DetectionModels(std::span<const Stone> stones, const DetectionOptions& options)
    : data_(std::make_unique<Data>()) {
  require_usable(options);
  data_->options = options;
  std::vector<std::unique_ptr<DetectionModel>> made(stones.size());
  tbb::parallel_for(std::size_t{0}, stones.size(), [&](std::size_t i) {
    throw_if_interrupted();
    made[i] = std::make_unique<DetectionModel>(make_detection_model(stones[i]));
  });
  for (auto& m : made) data_->models.push_back(std::move(*m));
  data_->rivals = models_of_similar_shape(data_->models);
}
DetectionModels::~DetectionModels() = default;
DetectionModels::DetectionModels(DetectionModels&&) noexcept = default;
DetectionModels& DetectionModels::operator=(DetectionModels&&) noexcept = default;

}  // namespace stonestack::detection
