#include "modelling/distance_volume.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "modelling/constants.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::modelling {
namespace {

constexpr double kUsualDepth = 0.5;    // m: weight 1
constexpr double kFreeMargin = 0.002;  // m in front of another surface, from which on a place is free
constexpr float kFreeWeight = 0.25F;   // of a view that sees through a place, against one that shows it
// Distance given to what was seen through but not near a surface, as a share of the truncation. It decides
// how far completed surface stays behind what was seen through; 0.2 keeps the volume of limestones right
// (bench modelling).
constexpr double kFreeShare = 0.2;
constexpr float kTrusted = 0.02F;  // weight from which on a distance is measured
constexpr double kMaxNodes = 64e6;
constexpr double kFewestTerms = 200.0;  // for a spread that is known within 5 % (1 / sqrt(2 n))

/// Statement of one view about a place.
struct Say {
  float weight = 0.0F;
  float distance = 0.0F;
};

/// Depth at a position between pixels, from the four around it where all show the object's one surface.
struct SeenDepth {
  double z = 0.0;
  Eigen::Vector3d n_C = Eigen::Vector3d::Zero();
};

SeenDepth seen_depth(const FusedView& view, const Eigen::Vector2d& pixel) {
  const CameraIntrinsics& camera = view.depth->camera;
  const int u = static_cast<int>(std::floor(pixel.x())), v = static_cast<int>(std::floor(pixel.y()));
  if (u < 0 || v < 0 || u + 1 >= camera.width || v + 1 >= camera.height) return {};
  const double s = pixel.x() - u, t = pixel.y() - v;
  SeenDepth seen;
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const auto& [du, dv, share] : {std::tuple(0, 0, (1 - s) * (1 - t)), std::tuple(1, 0, s * (1 - t)),
                                      std::tuple(0, 1, (1 - s) * t), std::tuple(1, 1, s * t)}) {
    const auto i = static_cast<std::size_t>((v + dv) * camera.width + u + du);
    const double z = view.depth->z[i];
    if (!(z > 0) || view.shows[i] == 0) return {};
    least = std::min(least, z);
    most = std::max(most, z);
    seen.z += share * z;
    seen.n_C += share * (*view.normal_C)[i].cast<double>();
  }
  if (most - least > kMaxDepthStep || seen.n_C.norm() < 0.5) return {};
  seen.n_C.normalize();
  return seen;
}

Say say_of(const FusedView& view, const Eigen::Vector3d& p_C, double truncation) {
  if (p_C.z() <= 0.05) return {};
  const CameraIntrinsics& camera = view.depth->camera;
  const Eigen::Vector2d pixel = project(camera, p_C);
  const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
  if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) return {};
  const auto i = static_cast<std::size_t>(v * camera.width + u);
  if (const SeenDepth seen = seen_depth(view, pixel); seen.z > 0) {
    const Eigen::Vector3d ray = p_C / p_C.z();
    const double cosine = -seen.n_C.dot(ray) / ray.norm();
    if (cosine > kMinCosine) {
      const double distance = (seen.z - p_C.z()) * ray.norm() * cosine;
      if (distance >= -truncation) {
        const double near = kUsualDepth / seen.z;
        return {static_cast<float>(cosine * cosine * near * near),
                static_cast<float>(std::min(distance, truncation))};
      }
      return {};
    }
  }
  if (view.seen_to[i] - p_C.z() > kFreeMargin) return {kFreeWeight, static_cast<float>(truncation)};
  return {};
}

/// Statements of the views near the surface about one node.
class NearVotes {
 public:
  explicit NearVotes(std::size_t views) { votes_.reserve(views); }
  void clear() { votes_.clear(); }
  void add(const Say& say) { votes_.push_back(say); }
  /// Sums of the weights, of their squares, and of the weighted distances.
  [[nodiscard]] std::array<double, 3> sums() const {
    std::array<double, 3> sums{};
    for (const Say& say : votes_) {
      const double w = say.weight;
      sums[0] += w, sums[1] += w * w, sums[2] += w * say.distance;
    }
    return sums;
  }
  [[nodiscard]] double squares_about(double mean) const {
    double sum = 0.0;
    for (const Say& say : votes_) sum += std::pow(say.distance - mean, 2);
    return sum;
  }
  [[nodiscard]] double count() const { return static_cast<double>(votes_.size()); }

 private:
  std::vector<Say> votes_;
};

Eigen::Vector3i nodes_of(const Eigen::AlignedBox3d& box, double cell) {
  return (box.sizes() / cell).array().ceil().cast<int>() + 1;
}

}  // namespace

bool DistanceVolume::fits(const Eigen::AlignedBox3d& box_O, double cell) {
  return (box_O.sizes() / cell).maxCoeff() < kMaxNodes &&
         nodes_of(box_O, cell).cast<double>().prod() <= kMaxNodes;
}

DistanceVolume::DistanceVolume(const Eigen::AlignedBox3d& box_O, double cell, double truncation)
    : box_(box_O), cell_(cell), truncation_(truncation) {
  require(fits(box_O, cell), "an object of ", box_.sizes().transpose(), " m does not fit into ", kMaxNodes,
          " cells of ", cell, " m: give larger cells");
  size_ = nodes_of(box_, cell);
  box_.max() = box_.min() + cell * (size_.array() - 1).matrix().cast<double>();
  const auto count = static_cast<std::size_t>(size_.cast<double>().prod());
  distance_.assign(count, static_cast<float>(truncation));
  weight_.assign(count, 0.0F);
  effective_views_.assign(count, 0.0F);
  fixed_.assign(count, 0);
}

void DistanceVolume::fuse(const std::vector<FusedView>& views, const std::vector<Pose>& T_W_O) {
  const auto limit = static_cast<float>(truncation_);
  // A layer each, added in order afterwards: threads do not matter.
  std::vector<double> squares(static_cast<std::size_t>(size_.z()), 0.0), terms(squares);
  tbb::parallel_for(0, size_.z(), [&](int k) {
    NearVotes votes(views.size());
    for (int j = 0; j < size_.y(); ++j)
      for (int i = 0; i < size_.x(); ++i) {
        const Eigen::Vector3d p_O = node(i, j, k);
        const std::size_t at = index(i, j, k);
        float sum = 0.0F, weight = 0.0F, near = 0.0F;
        votes.clear();
        for (const FusedView& view : views) {
          const Say say = say_of(view, view.T_C_O * p_O, truncation_);
          sum += say.weight * say.distance;
          weight += say.weight;
          if (say.weight > 0 && say.distance < limit) {
            near += say.weight;
            votes.add(say);
          }
        }
        double below = -std::numeric_limits<double>::infinity();  // the deepest of all tables
        for (const Pose& T : T_W_O) below = std::max(below, -(T * p_O).z());
        if (weight > kTrusted) {
          distance_[at] = sum / weight;
          fixed_[at] = 1;
          weight_[at] = near;
        }
        if (near > 0) {
          const auto [w, w2, wd] = votes.sums();
          effective_views_[at] = static_cast<float>(w * w / w2);
          // Expected squares about a weighted mean: n - 2 + n sum w^2 / (sum w)^2 variances, n - 1 of equal
          // weights.
          if (const double mean = wd / w; votes.count() >= 2.0 && std::abs(mean) < cell_) {
            squares[static_cast<std::size_t>(k)] += votes.squares_about(mean);
            terms[static_cast<std::size_t>(k)] += votes.count() - 2.0 + votes.count() * w2 / (w * w);
          }
        }
        if (below >= 0.0) {
          distance_[at] = std::max(fixed_[at] != 0 ? distance_[at] : -limit,
                                   static_cast<float>(std::min(below, truncation_)));
          fixed_[at] = 1;
        }
        const bool border =
            i == 0 || j == 0 || k == 0 || i + 1 == size_.x() || j + 1 == size_.y() || k + 1 == size_.z();
        if (border) {
          distance_[at] = limit;
          fixed_[at] = 1;
        }
      }
  });
  squares_ += std::accumulate(squares.begin(), squares.end(), 0.0);
  terms_ += std::accumulate(terms.begin(), terms.end(), 0.0);
}

void DistanceVolume::solve(int stride, int rounds) {
  // Red and black nodes in turn (Gauss-Seidel), so that threads do not matter.
  for (int round = 0; round < 2 * rounds; ++round)
    tbb::parallel_for(1, (size_.z() - 1 + stride - 1) / stride, [&](int layer) {
      const int k = layer * stride;
      if (k + stride >= size_.z()) return;
      for (int j = stride; j + stride < size_.y(); j += stride)
        for (int i = stride; i + stride < size_.x(); i += stride) {
          const std::size_t at = index(i, j, k);
          if (fixed_[at] != 0 || (i / stride + j / stride + layer) % 2 != round % 2) continue;
          distance_[at] = (distance_[index(i - stride, j, k)] + distance_[index(i + stride, j, k)] +
                           distance_[index(i, j - stride, k)] + distance_[index(i, j + stride, k)] +
                           distance_[index(i, j, k - stride)] + distance_[index(i, j, k + stride)]) /
                          6.0F;
        }
    });
}

void DistanceVolume::complete() {
  const auto free = static_cast<float>(kFreeShare * truncation_);
  for (std::size_t at = 0; at < distance_.size(); ++at) {
    if (fixed_[at] == 0)
      distance_[at] = 0.0F;
    else if (weight_[at] == 0.0F)
      distance_[at] = std::min(distance_[at], free);
  }
  constexpr int kCoarsest = 8;
  constexpr int kRounds = 60;
  for (int stride = kCoarsest; stride >= 1; stride /= 2) {
    solve(stride, kRounds);
    if (stride == 1) break;
    const int half = stride / 2;  // the next finer nodes begin with what the coarser ones say
    tbb::parallel_for(0, size_.z(), [&](int k) {
      if (k % half != 0) return;
      for (int j = 0; j < size_.y(); j += half)
        for (int i = 0; i < size_.x(); i += half) {
          if (i % stride == 0 && j % stride == 0 && k % stride == 0) continue;
          const std::size_t at = index(i, j, k);
          if (fixed_[at] != 0) continue;
          const int a = i - i % stride, b = j - j % stride, c = k - k % stride;
          float sum = 0.0F;
          int count = 0;
          for (const int di : {0, i % stride})
            for (const int dj : {0, j % stride})
              for (const int dk : {0, k % stride}) {
                const int x = di == 0 ? a : std::min(a + stride, size_.x() - 1);
                const int y = dj == 0 ? b : std::min(b + stride, size_.y() - 1);
                const int z = dk == 0 ? c : std::min(c + stride, size_.z() - 1);
                sum += distance_[index(x, y, z)];
                ++count;
              }
          distance_[at] = sum / static_cast<float>(count);
        }
    });
  }
}

void DistanceVolume::keep_largest_part() {
  std::vector<int> part(distance_.size(), 0);
  int parts = 0, largest = 0;
  std::size_t most = 0;
  std::vector<Eigen::Vector3i> open;
  for (int k = 0; k < size_.z(); ++k)
    for (int j = 0; j < size_.y(); ++j)
      for (int i = 0; i < size_.x(); ++i) {
        if (distance_[index(i, j, k)] >= 0 || part[index(i, j, k)] != 0) continue;
        ++parts;
        std::size_t count = 0;
        open.assign(1, {i, j, k});
        part[index(i, j, k)] = parts;
        while (!open.empty()) {
          const Eigen::Vector3i at = open.back();
          open.pop_back();
          ++count;
          for (int axis = 0; axis < 3; ++axis)
            for (const int step : {-1, 1}) {
              Eigen::Vector3i next = at;
              next[axis] += step;
              if ((next.array() < 0).any() || (next.array() >= size_.array()).any()) continue;
              const std::size_t to = index(next.x(), next.y(), next.z());
              if (distance_[to] >= 0 || part[to] != 0) continue;
              part[to] = parts;
              open.push_back(next);
            }
        }
        if (count > most) most = count, largest = parts;
      }
  for (std::size_t at = 0; at < distance_.size(); ++at)
    if (distance_[at] < 0 && part[at] != largest) distance_[at] = -distance_[at];
}

double DistanceVolume::distance(const Eigen::Vector3d& p_O) const {
  const Eigen::Vector3d local = (p_O - box_.min()) / cell_;
  const Eigen::Vector3i low = local.array().floor().cast<int>();
  if ((low.array() < 0).any() || (low.array() + 1 >= size_.array()).any()) return truncation_;
  const Eigen::Vector3d s = local - low.cast<double>();
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3i step(corner & 1, (corner >> 1) & 1, corner >> 2);
    double share = 1.0;
    for (int axis = 0; axis < 3; ++axis) share *= step[axis] != 0 ? s[axis] : 1.0 - s[axis];
    sum += share * distance_[index(low.x() + step.x(), low.y() + step.y(), low.z() + step.z())];
  }
  return sum;
}

std::optional<std::size_t> DistanceVolume::nearest_node(const Eigen::Vector3d& p_O) const {
  const Eigen::Vector3i at = ((p_O - box_.min()) / cell_).array().round().cast<int>();
  if ((at.array() < 0).any() || (at.array() >= size_.array()).any()) return std::nullopt;
  return index(at.x(), at.y(), at.z());
}

double DistanceVolume::weight(const Eigen::Vector3d& p_O) const {
  const auto at = nearest_node(p_O);
  return at ? weight_[*at] : 0.0;
}

double DistanceVolume::effective_views(const Eigen::Vector3d& p_O) const {
  const auto at = nearest_node(p_O);
  return at ? effective_views_[*at] : 0.0;
}

std::optional<double> DistanceVolume::spread() const {
  return terms_ < kFewestTerms ? std::nullopt : std::optional(std::sqrt(squares_ / terms_));
}

Eigen::Vector3d DistanceVolume::deepest() const {
  // Middle of what is inside, then the deepest node: the truncation makes plateaus.
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (int k = 0; k < size_.z(); ++k)
    for (int j = 0; j < size_.y(); ++j)
      for (int i = 0; i < size_.x(); ++i)
        if (distance_[index(i, j, k)] < 0) sum += node(i, j, k), count += 1.0;
  if (count == 0.0) return box_.center();
  const Eigen::Vector3d middle = sum / count;
  Eigen::Vector3d best = middle;
  double lowest = 1e9;
  for (int k = 0; k < size_.z(); ++k)
    for (int j = 0; j < size_.y(); ++j)
      for (int i = 0; i < size_.x(); ++i) {
        const double value =
            distance_[index(i, j, k)] + 0.05 * (node(i, j, k) - middle).norm();  // nearest the middle first
        if (distance_[index(i, j, k)] < 0 && value < lowest) lowest = value, best = node(i, j, k);
      }
  return best;
}

}  // namespace stonestack::modelling
