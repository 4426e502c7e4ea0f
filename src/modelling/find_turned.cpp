#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/constants.hpp"
#include "core/quantile.hpp"
#include "geometry/small_motion.hpp"
#include "geometry/surface_tree.hpp"
#include "modelling/view_normals.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/modelling/model_objects.hpp"

namespace stonestack::modelling {
namespace {

constexpr std::size_t kFineSamples = 2500;      // of the seen surface
constexpr std::size_t kCoarseSamples = 300;     // for the many starts
constexpr int kFineSteps = 40;                  // of a start that is followed to its end
constexpr int kCoarseSteps = 12;                // of one of the many
constexpr double kWidestTurnedGate = 0.015;     // m between surfaces that may be one, at first ...
constexpr double kNarrowestTurnedGate = 0.003;  // ... and at the end
constexpr double kCoarseGate = 0.025;           // m, of the many starts: at first, ...
constexpr double kCoarseEnd = 0.008;            // ... and at their end
constexpr double kSameTurnedNormal = 0.6;       // cosine
constexpr double kAgrees = 0.002;               // m
constexpr double kMinAgreement =
    0.08;  // of the surface that is seen: a stone on its side shows little that was seen
constexpr double kMinConfirmed = 0.65;  // of the model's seen surface that faces a view
constexpr double kFacing = 0.4;         // cosine
constexpr double kInFront = 0.005;      // m: a view sees through what would lie so much before what it shows
constexpr double kBelowTable = 0.004;   // m
constexpr double kTurns[] = {0.0, 0.2, -0.2};   // rad of the near starts, about level axes
constexpr double kYaws[] = {0.0, 0.35, -0.35};  // about the vertical
constexpr int kDirections = 48;                 // of the many starts: which side is up
constexpr int kManyYaws = 8;                    // turns about the vertical of each
constexpr std::size_t kFollowed = 16;           // of the many starts

struct SeenPoint {
  Eigen::Vector3d p_W, n_W;
};

std::vector<SeenPoint> seen_points(const LyingObject& lying, std::size_t count) {
  const AlignedScene& scene = *lying.scene;
  const Cloud& cloud = scene.segmentation.objects[static_cast<std::size_t>(lying.object)].cloud_C;
  const Pose& T_W_C = scene.views.front().T_W_C;
  std::vector<SeenPoint> points;
  const std::size_t stride = std::max<std::size_t>(1, cloud.points.size() / count);
  for (std::size_t i = 0; i < cloud.points.size(); i += stride)
    points.push_back(
        {T_W_C * cloud.points[i].cast<double>(), T_W_C.linear() * cloud.normals[i].cast<double>()});
  return points;
}

/// The seen part of a model, to find what lies nearest.
class SeenSurface {
 public:
  explicit SeenSurface(const ObjectModel& model) : model_(model), tree_(model.mesh) {
    const std::vector<Eigen::Vector3d> normals = vertex_normals(model.mesh);
    for (std::size_t v = 0; v < model.seen.size(); ++v)
      if (model.seen[v] != 0) {
        seen_.push_back(model.mesh.vertices[v]);
        normals_.push_back(normals[v]);
      }
  }

  /// Nearest point within `gate`; empty where the model was not seen.
  [[nodiscard]] std::optional<SurfacePoint> nearest(const Eigen::Vector3d& p_O, double gate) const {
    const SurfacePoint found = tree_.nearest(p_O, gate);
    if (found.face < 0) return std::nullopt;
    const Eigen::Vector3i& face = model_.mesh.faces[static_cast<std::size_t>(found.face)];
    for (int k = 0; k < 3; ++k)
      if (model_.seen[static_cast<std::size_t>(face[k])] == 0) return std::nullopt;
    return found;
  }
  [[nodiscard]] const std::vector<Eigen::Vector3d>& vertices() const { return seen_; }
  [[nodiscard]] const std::vector<Eigen::Vector3d>& normals() const { return normals_; }
  [[nodiscard]] Eigen::Vector3d middle() const {
    const Eigen::AlignedBox3d box = bounds(model_.mesh);
    return box.center();
  }

 private:
  const ObjectModel& model_;
  SurfaceTree tree_;
  std::vector<Eigen::Vector3d> seen_, normals_;
};

/// One step of iterated closest points towards `T_W_O`; false where too little is shared.
bool step_towards(const SeenSurface& surface, const std::vector<SeenPoint>& points, double gate,
                  Pose& T_W_O) {
  const Pose T_O_W = T_W_O.inverse();
  Eigen::Matrix<double, 6, 6> H = 1e-3 * Eigen::Matrix<double, 6, 6>::Identity();
  Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
  std::size_t shared = 0;
  for (const SeenPoint& seen : points) {
    const Eigen::Vector3d p_O = T_O_W * seen.p_W;
    const auto near = surface.nearest(p_O, gate);
    if (!near || near->normal.dot(T_O_W.linear() * seen.n_W) < kSameTurnedNormal) continue;
    const double off = near->normal.dot(p_O - near->point);
    const double rest = 1.0 - std::pow(off / gate, 2);
    if (rest <= 0) continue;
    Eigen::Matrix<double, 6, 1> J;
    J << near->normal, p_O.cross(near->normal);
    H += rest * rest * J * J.transpose();
    g += rest * rest * off * J;
    ++shared;
  }
  if (20 * shared < points.size()) return false;
  const Eigen::Matrix<double, 6, 1> x = -H.ldlt().solve(g);
  T_W_O = orthonormal(T_W_O * small_motion(x).inverse());
  return true;
}

bool follow(const SeenSurface& surface, const std::vector<SeenPoint>& points, int steps, double widest,
            double narrowest, Pose& T_W_O) {
  for (int step = 0; step < steps; ++step)
    if (!step_towards(surface, points,
                      widest * std::pow(narrowest / widest, static_cast<double>(step) / (steps - 1)), T_W_O))
      return false;
  return true;
}

/// Share of the seen points that lie within `within` m of the seen part of the model, and how far.
FoundObject agreement_of(const SeenSurface& surface, const std::vector<SeenPoint>& points, double within,
                         const Pose& T_W_O) {
  const Pose T_O_W = T_W_O.inverse();
  std::vector<double> apart;
  for (const SeenPoint& seen : points)
    if (const auto near = surface.nearest(T_O_W * seen.p_W, within);
        near && near->normal.dot(T_O_W.linear() * seen.n_W) > kSameTurnedNormal)
      apart.push_back(std::abs(near->distance));
  FoundObject found{T_W_O, static_cast<double>(apart.size()) / static_cast<double>(points.size()), 0.0};
  if (!apart.empty()) found.apart = quantile(apart, 0.5);
  return found;
}

/// Evidence of the views for a pose, over the model's seen surface that faces them.
struct Evidence {
  std::size_t confirmed = 0;  ///< places where a view shows that surface
  std::size_t refuted = 0;    ///< where a view shows other surface near it, or sees through it
  std::size_t in_table = 0;   ///< places below the table

  [[nodiscard]] double share() const {
    const auto all = static_cast<double>(confirmed + refuted + in_table);
    return all > 0 ? static_cast<double>(confirmed) / all : 0.0;
  }
};

Evidence evidence_for(const SeenSurface& surface, const AlignedScene& scene,
                      const std::vector<std::vector<float>>& free_to, const Pose& T_W_O, double within,
                      std::size_t stride) {
  Evidence evidence;
  for (std::size_t i = 0; i < surface.vertices().size(); i += stride) {
    const Eigen::Vector3d p_W = T_W_O * surface.vertices()[i];
    if (p_W.z() < -kBelowTable) ++evidence.in_table;
    for (std::size_t k = 0; k < scene.views.size(); ++k) {
      const DepthView& view = scene.views[k];
      const Eigen::Vector3d p_C = view.T_W_C.inverse() * p_W;
      if (p_C.z() <= 0.05) continue;
      const Eigen::Vector2d pixel = project(view.image.camera, p_C);
      const auto u = std::lround(pixel.x()), v = std::lround(pixel.y());
      if (u < 0 || v < 0 || u >= view.image.camera.width || v >= view.image.camera.height) continue;
      if (p_C.z() < free_to[k][static_cast<std::size_t>(v * view.image.camera.width + u)] - kInFront) {
        ++evidence.refuted;
        continue;
      }
      const Eigen::Vector3d n_C = view.T_W_C.linear().transpose() * (T_W_O.linear() * surface.normals()[i]);
      if (-n_C.dot(p_C.normalized()) < kFacing) continue;
      const double z = view.image.at(static_cast<int>(u), static_cast<int>(v));
      if (!(z > 0) || z < p_C.z() - kInFront) continue;  // nothing is known, or something stands before it
      if (std::abs(z - p_C.z()) < within)
        ++evidence.confirmed;
      else
        ++evidence.refuted;
    }
  }
  return evidence;
}

/// The best pose so far that nothing refutes.
class BestPose {
 public:
  BestPose(const SeenSurface& surface, const AlignedScene& scene, std::vector<SeenPoint> points)
      : surface_(surface), scene_(scene), points_(std::move(points)) {
    for (const DepthView& view : scene.views) free_to_.push_back(seen_to(view.image));
  }
  void try_from(Pose T_W_O) {
    if (!follow(surface_, points_, kFineSteps, kWidestTurnedGate, kNarrowestTurnedGate, T_W_O)) return;
    const FoundObject found = agreement_of(surface_, points_, kAgrees, T_W_O);
    const Evidence evidence = evidence_for(surface_, scene_, free_to_, T_W_O, kAgrees, 1);
    if (found.agreement < kMinAgreement || evidence.share() < kMinConfirmed) return;
    if (best_ && evidence.share() * found.agreement <= quality_) return;
    quality_ = evidence.share() * found.agreement;
    best_ = found;
  }
  [[nodiscard]] const std::optional<FoundObject>& best() const { return best_; }

 private:
  const SeenSurface& surface_;
  const AlignedScene& scene_;
  std::vector<SeenPoint> points_;
  std::vector<std::vector<float>> free_to_;  ///< a view each
  std::optional<FoundObject> best_;
  double quality_ = 0.0;
};

Eigen::Vector3d middle_of(const std::vector<SeenPoint>& points) {
  Eigen::AlignedBox3d box;
  for (const SeenPoint& seen : points) box.extend(seen.p_W);
  return {box.center().x(), box.center().y(), 0.5 * box.max().z()};
}

std::vector<Pose> near_starts(const Pose& T_W_O, const Eigen::Vector3d& p_W_middle) {
  std::vector<Pose> starts;
  for (const double about_x : kTurns)
    for (const double about_y : kTurns)
      for (const double about_z : kYaws) {
        const Eigen::Quaterniond turn = Eigen::AngleAxisd(about_x, Eigen::Vector3d::UnitX()) *
                                        Eigen::AngleAxisd(about_y, Eigen::Vector3d::UnitY()) *
                                        Eigen::AngleAxisd(about_z, Eigen::Vector3d::UnitZ());
        starts.push_back(Eigen::Translation3d(p_W_middle) * turn * Eigen::Translation3d(-p_W_middle) * T_W_O);
      }
  return starts;
}

/// The most promising of many poses all around: a stone that toppled may lie on any side.
std::vector<Pose> far_starts(const SeenSurface& surface, const AlignedScene& scene,
                             const std::vector<SeenPoint>& points, const Eigen::Vector3d& p_W_middle) {
  struct Start {
    Pose T_W_O;
    double share = 0.0;
  };
  std::vector<Start> starts(static_cast<std::size_t>(kDirections * kManyYaws));
  std::vector<std::vector<float>> free_to;
  for (const DepthView& view : scene.views) free_to.push_back(seen_to(view.image));
  const std::size_t stride = std::max<std::size_t>(1, surface.vertices().size() / kCoarseSamples);
  const double golden = M_PI * (3.0 - std::sqrt(5.0));
  tbb::parallel_for(0, kDirections, [&](int d) {
    const double z = 1.0 - 2.0 * (d + 0.5) / kDirections, level = std::sqrt(1.0 - z * z);
    const Eigen::Vector3d n_O_up(level * std::cos(golden * d), level * std::sin(golden * d), z);
    const auto upright = Eigen::Quaterniond::FromTwoVectors(n_O_up, Eigen::Vector3d::UnitZ());
    for (int yaw = 0; yaw < kManyYaws; ++yaw) {
      Start& start = starts[static_cast<std::size_t>(d * kManyYaws + yaw)];
      const Eigen::AngleAxisd turn(kTwoPi * yaw / kManyYaws, Eigen::Vector3d::UnitZ());
      start.T_W_O =
          Eigen::Translation3d(p_W_middle) * turn * upright * Eigen::Translation3d(-surface.middle());
      if (follow(surface, points, kCoarseSteps, kCoarseGate, kCoarseEnd, start.T_W_O))
        start.share = evidence_for(surface, scene, free_to, start.T_W_O, 2.0 * kAgrees, stride).share();
    }
  });
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.share > b.share; });
  std::vector<Pose> best;
  for (std::size_t k = 0; k < kFollowed; ++k)
    if (starts[k].share > 0) best.push_back(starts[k].T_W_O);
  return best;
}

}  // namespace

std::optional<FoundObject> find_turned(const ObjectModel& model, const LyingObject& as_meant) {
  require(as_meant.scene != nullptr, "a lying object needs its scene");
  const std::vector<SeenPoint> points = seen_points(as_meant, kFineSamples);
  if (points.size() < 100) return std::nullopt;
  const SeenSurface surface(model);
  const Eigen::Vector3d p_W_middle = middle_of(points);
  BestPose best(surface, *as_meant.scene, points);
  for (const Pose& start : near_starts(as_meant.T_W_O, p_W_middle)) {
    throw_if_interrupted();
    best.try_from(start);
  }
  if (best.best()) return best.best();
  for (const Pose& start :
       far_starts(surface, *as_meant.scene, seen_points(as_meant, kCoarseSamples), p_W_middle)) {
    throw_if_interrupted();
    best.try_from(start);
  }
  return best.best();
}

}  // namespace stonestack::modelling
