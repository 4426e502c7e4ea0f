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
constexpr double kTurns[] = {0.0, 0.2, -0.2};           // rad of the near starts, about level axes
constexpr double kYaws[] = {0.0, 0.35, -0.35};          // about the vertical
constexpr int kDirections = 48;                         // of the many starts: which side is up
constexpr int kManyYaws = 8;                            // turns about the vertical of each
constexpr std::size_t kFollowed = 16;                   // of the many starts
constexpr double kSameStart = 0.002, kSameTurn = 0.03;  // m, rad: between starts of which one is followed

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
  FoundObject found;
  found.T_W_O = T_W_O;
  found.agreement = static_cast<double>(apart.size()) / static_cast<double>(points.size());
  if (!apart.empty()) found.apart = quantile(apart, 0.5);
  return found;
}

/// Evidence of views for a pose, over surface that faces them.
struct Evidence {
  std::size_t confirmed = 0;  ///< places where a view shows that surface
  std::size_t refuted = 0;    ///< where a view shows other surface near it, or sees through it
  std::size_t in_table = 0;   ///< places below the table

  void add(const Evidence& other) {
    confirmed += other.confirmed;
    refuted += other.refuted;
    in_table += other.in_table;
  }
  [[nodiscard]] double share() const {
    const auto all = static_cast<double>(confirmed + refuted + in_table);
    return all > 0 ? static_cast<double>(confirmed) / all : 0.0;
  }
};

/// A scene whose views confirm or refute surface, and how far each sees.
struct Witness {
  const AlignedScene* scene;
  std::vector<std::vector<float>> free_to;  ///< a view each
  std::vector<Pose> T_C_W;                  ///< a view each

  explicit Witness(const AlignedScene& seen) : scene(&seen) {
    for (const DepthView& view : seen.views) {
      free_to.push_back(seen_to(view.image));
      T_C_W.push_back(view.T_W_C.inverse());
    }
  }
  /// Adds what the views tell of one place, its normal outwards.
  void tell(const Eigen::Vector3d& p_W, const Eigen::Vector3d& n_W, double within, Evidence& evidence) const {
    if (p_W.z() < -kBelowTable) ++evidence.in_table;
    for (std::size_t k = 0; k < scene->views.size(); ++k) {
      const DepthView& view = scene->views[k];
      const Eigen::Vector3d p_C = T_C_W[k] * p_W;
      if (p_C.z() <= 0.05) continue;
      const Eigen::Vector2d pixel = project(view.image.camera, p_C);
      const auto u = std::lround(pixel.x()), v = std::lround(pixel.y());
      if (u < 0 || v < 0 || u >= view.image.camera.width || v >= view.image.camera.height) continue;
      if (p_C.z() < free_to[k][static_cast<std::size_t>(v * view.image.camera.width + u)] - kInFront) {
        ++evidence.refuted;
        continue;
      }
      const Eigen::Vector3d n_C = T_C_W[k].linear() * n_W;
      if (-n_C.dot(p_C.normalized()) < kFacing) continue;
      const double z = view.image.at(static_cast<int>(u), static_cast<int>(v));
      if (!(z > 0) || z < p_C.z() - kInFront) continue;  // nothing is known, or something stands before it
      if (std::abs(z - p_C.z()) < within)
        ++evidence.confirmed;
      else
        ++evidence.refuted;
    }
  }
};

/// Evidence of views for the seen part of a model in that pose.
Evidence evidence_for(const SeenSurface& surface, const Witness& witness, const Pose& T_W_O, double within,
                      std::size_t stride) {
  Evidence evidence;
  for (std::size_t i = 0; i < surface.vertices().size(); i += stride)
    witness.tell(T_W_O * surface.vertices()[i], T_W_O.linear() * surface.normals()[i], within, evidence);
  return evidence;
}

/// Evidence of the views of which a model was made for what is seen of the object now, if that pose is right.
Evidence evidence_before(const std::vector<SeenPoint>& points, const Witness& witness,
                         const Pose& T_W_O_before, const Pose& T_W_O) {
  const Pose T_before_now = T_W_O_before * T_W_O.inverse();
  Evidence evidence;
  for (const SeenPoint& seen : points)
    witness.tell(T_before_now * seen.p_W, T_before_now.linear() * seen.n_W, kAgrees, evidence);
  return evidence;
}

/// The best pose so far that nothing refutes.
class BestPose {
 public:
  BestPose(const SeenSurface& surface, std::span<const LyingObject> made_of, const AlignedScene& scene,
           std::vector<SeenPoint> points)
      : surface_(surface), now_(scene), points_(std::move(points)) {
    for (const LyingObject& lay : made_of) before_.push_back({Witness(*lay.scene), lay.T_W_O});
  }
  void try_from(Pose T_W_O) {
    if (!follow(surface_, points_, kFineSteps, kWidestTurnedGate, kNarrowestTurnedGate, T_W_O)) return;
    FoundObject found = agreement_of(surface_, points_, kAgrees, T_W_O);
    const Evidence evidence = evidence_for(surface_, now_, T_W_O, kAgrees, 1);
    if (found.agreement < kMinAgreement || evidence.share() < kMinConfirmed) return;
    Evidence back;
    for (const auto& [witness, T_W_O_before] : before_)
      back.add(evidence_before(points_, witness, T_W_O_before, T_W_O));
    const double share_before = before_.empty() ? 1.0 : back.share();
    found.confirmed = static_cast<double>(evidence.confirmed) * evidence.share() * share_before;
    if (share_before < kMinConfirmed || (best_ && found.confirmed <= best_->confirmed)) return;
    best_ = found;
  }
  [[nodiscard]] const std::optional<FoundObject>& best() const { return best_; }
  [[nodiscard]] const Witness& now() const { return now_; }

 private:
  struct Before {
    Witness witness;
    Pose T_W_O;  ///< of the model there
  };
  const SeenSurface& surface_;
  Witness now_;
  std::vector<SeenPoint> points_;
  std::vector<Before> before_;
  std::optional<FoundObject> best_;
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

/// Poses without those that are nearly one before them, seen at `p_W_middle`.
std::vector<Pose> distinct(const std::vector<Pose>& poses, const Eigen::Vector3d& p_W_middle) {
  std::vector<Pose> kept;
  for (const Pose& T_W_O : poses)
    if (std::none_of(kept.begin(), kept.end(), [&](const Pose& other) {
          const Pose apart = T_W_O * other.inverse();
          return (apart * p_W_middle - p_W_middle).norm() < kSameStart &&
                 Eigen::AngleAxisd(apart.linear()).angle() < kSameTurn;
        }))
      kept.push_back(T_W_O);
  return kept;
}

/// A pose, and where starts about it lead to.
std::vector<Pose> near_poses(const SeenSurface& surface, const std::vector<SeenPoint>& points,
                             const Pose& T_W_O, const Eigen::Vector3d& p_W_middle) {
  std::vector<Pose> reached{T_W_O};
  for (Pose start : near_starts(T_W_O, p_W_middle))
    if (follow(surface, points, kCoarseSteps, kWidestTurnedGate, kCoarseEnd, start)) reached.push_back(start);
  return distinct(reached, p_W_middle);
}

/// The most promising of many poses all around: a stone that toppled may lie on any side.
std::vector<Pose> far_starts(const SeenSurface& surface, const Witness& witness,
                             const std::vector<SeenPoint>& points, const Eigen::Vector3d& p_W_middle) {
  struct Start {
    Pose T_W_O;
    double share = 0.0;
  };
  std::vector<Start> starts(static_cast<std::size_t>(kDirections * kManyYaws));
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
        start.share = evidence_for(surface, witness, start.T_W_O, 2.0 * kAgrees, stride).share();
    }
  });
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.share > b.share; });
  std::vector<Pose> best;
  for (std::size_t k = 0; k < kFollowed; ++k)
    if (starts[k].share > 0) best.push_back(starts[k].T_W_O);
  return distinct(best, p_W_middle);
}

}  // namespace

std::optional<FoundObject> find_turned(const ObjectModel& model, std::span<const LyingObject> made_of,
                                       const LyingObject& as_meant) {
  require(as_meant.scene != nullptr, "a lying object needs its scene");
  const std::vector<SeenPoint> points = seen_points(as_meant, kFineSamples);
  if (points.size() < 100) return std::nullopt;
  const SeenSurface surface(model);
  const Eigen::Vector3d p_W_middle = middle_of(points);
  BestPose best(surface, made_of, *as_meant.scene, points);
  const std::vector<SeenPoint> coarse = seen_points(as_meant, kCoarseSamples);
  for (const Pose& start : near_poses(surface, coarse, as_meant.T_W_O, p_W_middle)) {
    throw_if_interrupted();
    best.try_from(start);
  }
  if (best.best()) return best.best();
  for (const Pose& start : far_starts(surface, best.now(), coarse, p_W_middle)) {
    throw_if_interrupted();
    best.try_from(start);
  }
  return best.best();
}

}  // namespace stonestack::modelling
