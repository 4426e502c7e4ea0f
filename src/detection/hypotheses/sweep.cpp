#include "detection/hypotheses/sweep.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace stonestack::detection {
namespace {

constexpr float kWorstMisfit = 1.2F;  // of the squared reach: nothing that costs more is a hypothesis

/// A point of a patch and its normal.
struct PatchPoint {
  Eigen::Vector3f p, n;
};

/// Patch of a cluster as the camera sees it.
struct SeenPatch {
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();
  Eigen::Vector3f towards = Eigen::Vector3f::Zero();  ///< unit, to the camera
  float area = 0.0F;
  std::vector<PatchPoint> points;  ///< evenly thinned, the furthest from the centre first
};

/// Sorts the points that leave a wrong model soonest to the front.
void sort_outermost_first(SeenPatch& patch) {
  std::stable_sort(patch.points.begin(), patch.points.end(), [&](const PatchPoint& a, const PatchPoint& b) {
    return (a.p - patch.centre).squaredNorm() > (b.p - patch.centre).squaredNorm();
  });
}

SeenPatch look_at(const SurfacePoints& seen, std::span<const int> cluster, const Eigen::Vector3f& eye,
                  int max) {
  SeenPatch patch;
  for (const int i : cluster) {
    const float area = seen.areas[static_cast<std::size_t>(i)];
    patch.centre += area * seen.points[static_cast<std::size_t>(i)];
    patch.area += area;
  }
  patch.centre /= patch.area;
  patch.towards = (eye - patch.centre).normalized();
  const auto count = std::min(static_cast<std::size_t>(max), cluster.size());
  for (std::size_t k = 0; k < count; ++k) {
    const auto i = static_cast<std::size_t>(cluster[k * cluster.size() / count]);
    patch.points.push_back({seen.points[i], seen.normals[i]});
  }
  return patch;
}

/// Every third of the patch's points.
SeenPatch thinned(const SeenPatch& patch) {
  SeenPatch out = patch;
  out.points.clear();
  for (std::size_t k = 0; k < patch.points.size(); k += 3) out.points.push_back(patch.points[k]);
  return out;
}

/// A rotation with `axis` as its third column, turned about it by `angle`.
Eigen::Matrix3f frame_about(const Eigen::Vector3f& axis, float angle) {
  Eigen::Matrix3f frame;
  frame.col(0) = axis.unitOrthogonal();
  frame.col(1) = axis.cross(frame.col(0));
  frame.col(2) = axis;
  return frame * Eigen::AngleAxisf(angle, Eigen::Vector3f::UnitZ()).toRotationMatrix();
}

/// The centre itself, and four places beside it across the line of sight.
std::vector<Eigen::Vector3f> starts_beside(const Eigen::Vector3f& towards, float aside) {
  std::vector<Eigen::Vector3f> starts{Eigen::Vector3f::Zero()};
  if (aside <= 0) return starts;
  const Eigen::Matrix3f frame = frame_about(towards, 0.0F);
  for (const float sign : {-1.0F, 1.0F})
    for (int axis = 0; axis < 2; ++axis) starts.emplace_back(sign * aside * frame.col(axis));
  return starts;
}

/// Points of a patch turned into O, without the translation.
void turned_to(const SeenPatch& patch, const Eigen::Matrix3f& R_O_C, std::vector<PatchPoint>& turned) {
  turned.clear();
  for (const PatchPoint& point : patch.points) turned.push_back({R_O_C * point.p, R_O_C * point.n});
}

/// Mean cost of a patch's turned points with a translation: squared distance plus what the normals disagree,
/// both capped. Infinite as soon as it is sure to be above `limit`.
float misfit(const DetectionModel& model, const std::vector<PatchPoint>& turned, const Eigen::Vector3f& t_O_C,
             float reach, float limit) {
  const float cap = reach * reach, most = limit * static_cast<float>(turned.size());
  float sum = 0;
  for (const PatchPoint& point : turned) {
    if (sum > most) return std::numeric_limits<float>::infinity();
    const Eigen::Vector3f q = point.p + t_O_C;
    const int k = model.field.nearest(q);
    if (k < 0) {
      sum += 2.0F * cap;
      continue;
    }
    const ModelSample& near = model.samples[static_cast<std::size_t>(k)];
    const float d2 = (q - near.p).squaredNorm();
    const float cosine = near.n.dot(point.n);
    sum += std::min(d2, cap) + cap * std::min(1.0F, 1.0F - cosine);
  }
  return sum / static_cast<float>(turned.size());
}

/// The step of translation that carries the patch towards the model, point to plane. Slightly damped, so that
/// it stays where a direction is free.
Eigen::Vector3f slide(const DetectionModel& model, const std::vector<PatchPoint>& turned,
                      const Eigen::Vector3f& t_O_C) {
  float xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  Eigen::Vector3f g = Eigen::Vector3f::Zero();
  int count = 0, left = static_cast<int>(turned.size());
  const int enough = (left + 1) / 2;
  for (const PatchPoint& point : turned) {
    if (count + left-- < enough) return Eigen::Vector3f::Zero();
    const Eigen::Vector3f q = point.p + t_O_C;
    const int k = model.field.nearest(q);
    if (k < 0) continue;
    const ModelSample& near = model.samples[static_cast<std::size_t>(k)];
    const Eigen::Vector3f& n = near.n;
    if (n.dot(point.n) < 0) continue;
    xx += n.x() * n.x(), xy += n.x() * n.y(), xz += n.x() * n.z();
    yy += n.y() * n.y(), yz += n.y() * n.z(), zz += n.z() * n.z();
    g += n.dot(near.p - q) * n;
    ++count;
  }
  if (count < enough) return Eigen::Vector3f::Zero();
  const float damping = 0.05F * static_cast<float>(count);
  Eigen::Matrix3f H;
  H << xx + damping, xy, xz, xy, yy + damping, yz, xz, yz, zz + damping;
  return H.inverse() * g;  // damped: its condition is 21 at most
}

/// A tried orientation, best first.
struct Trial {
  float cost;
  int side, turn;
  Eigen::Vector3f t_O_C;
  bool operator<(const Trial& o) const {
    if (cost != o.cost) return cost < o.cost;
    return side != o.side ? side < o.side : turn < o.turn;
  }
};

/// The best of many trials.
class BestTrials {
 public:
  explicit BestTrials(std::size_t max) : max_(max) { trials_.reserve(max); }

  /// Cost above which a trial is not among them.
  [[nodiscard]] float limit() const {
    return trials_.size() < max_ || trials_.empty() ? std::numeric_limits<float>::infinity()
                                                    : trials_.front().cost;
  }

  void add(const Trial& trial) {
    if (trial.cost == std::numeric_limits<float>::infinity() || max_ == 0) return;
    if (trials_.size() == max_) {
      if (!(trial < trials_.front())) return;
      std::pop_heap(trials_.begin(), trials_.end());
      trials_.back() = trial;
    } else {
      trials_.push_back(trial);
    }
    std::push_heap(trials_.begin(), trials_.end());
  }

  /// All of them, in no order.
  [[nodiscard]] std::vector<Trial> take() { return std::move(trials_); }

 private:
  std::size_t max_;
  std::vector<Trial> trials_;  ///< a heap, the worst in front
};

}  // namespace

std::vector<Hypothesis> sweep_orientations(const DetectionModel& model, const SurfacePoints& seen,
                                           std::span<const int> cluster, const Eigen::Vector3f& eye,
                                           const SweepOptions& options) {
  std::vector<Hypothesis> found;
  if (cluster.empty()) return found;
  SeenPatch patch = look_at(seen, cluster, eye, options.points);
  if (!(patch.area > 0)) return found;
  const float step = 2.0F * std::numbers::pi_v<float> / static_cast<float>(options.turns);
  const auto reach = static_cast<float>(options.reach);
  const auto rotation = [&](int side, int turn) -> Eigen::Matrix3f {  // R_C_O
    return frame_about(patch.towards, step * static_cast<float>(turn)) *
           frame_about(model.sides[static_cast<std::size_t>(side)].towards, 0.0F).transpose();
  };
  std::vector<PatchPoint> turned;
  const auto tried = [&](int side, int turn, const SeenPatch& points, std::span<const Eigen::Vector3f> starts,
                         float limit) {
    const Eigen::Matrix3f R_O_C = rotation(side, turn).transpose();
    turned_to(points, R_O_C, turned);
    Trial best{std::numeric_limits<float>::infinity(), side, turn, {}};
    for (const auto& start : starts) {
      Eigen::Vector3f t = model.sides[static_cast<std::size_t>(side)].centre - R_O_C * (patch.centre + start);
      for (int k = 0; k < options.shifts; ++k) {
        const Eigen::Vector3f step_O = slide(model, turned, t);
        if (step_O.isZero()) break;
        t += step_O;
      }
      const float cost = misfit(model, turned, t, reach, std::min(limit, best.cost));
      if (cost < best.cost) best.cost = cost, best.t_O_C = t;
    }
    return best;
  };
  const auto starts = starts_beside(patch.towards, static_cast<float>(options.aside));
  const bool in_two_steps = options.glance < 1.0;
  SeenPatch first_points = in_two_steps ? thinned(patch) : patch;
  sort_outermost_first(first_points);
  sort_outermost_first(patch);
  const auto first_starts = in_two_steps ? std::span(starts).first(1) : std::span(starts);
  const float worst = kWorstMisfit * reach * reach;
  std::vector<int> sides;
  for (int side = 0; side < static_cast<int>(model.sides.size()); ++side) {
    const double share = patch.area / model.sides[static_cast<std::size_t>(side)].area;
    if (share >= options.area_low && share <= options.area_high) sides.push_back(side);
  }
  const std::size_t count = sides.size() * static_cast<std::size_t>(options.turns);
  BestTrials first(in_two_steps ? static_cast<std::size_t>(options.glance * static_cast<double>(count))
                                : count);
  for (const int side : sides)
    for (int turn = 0; turn < options.turns; ++turn)
      first.add(tried(side, turn, first_points, first_starts, in_two_steps ? first.limit() : worst));
  std::vector<Trial> trials = first.take();
  if (in_two_steps)
    for (Trial& trial : trials) trial = tried(trial.side, trial.turn, patch, starts, worst);
  std::sort(trials.begin(), trials.end());
  for (const Trial& trial : trials) {
    if (static_cast<int>(found.size()) >= options.best || trial.cost > worst) break;
    const Eigen::Matrix3f R = rotation(trial.side, trial.turn);
    Pose T_C_O = Pose::Identity();
    T_C_O.linear() = R.cast<double>();
    T_C_O.translation() = (-R * trial.t_O_C).cast<double>();
    const bool near = std::any_of(found.begin(), found.end(), [&](const Hypothesis& h) {
      return difference(h.T_C_O, T_C_O).angle < options.apart;
    });
    if (!near) found.push_back({orthonormal(T_C_O), 1.0 / (1e-9 + trial.cost)});
  }
  return found;
}

std::vector<Eigen::Vector3f> even_directions(int count) {
  std::vector<Eigen::Vector3f> directions;
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, r = std::sqrt(1.0 - z * z);
    directions.emplace_back(
        Eigen::Vector3d(r * std::cos(golden * i), r * std::sin(golden * i), z).cast<float>());
  }
  return directions;
}

}  // namespace stonestack::detection
