#include "detection/judge/alternatives.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "detection/hypotheses/candidates.hpp"
#include "detection/hypotheses/refine.hpp"
#include "detection/hypotheses/sweep.hpp"

namespace stonestack::detection {
namespace {

constexpr int kDirections = 60, kTurns = 12;  // 26 to 30 deg apart: within the basin of a registration
constexpr int kGlance = 60;                   // points of a first test of a turn
constexpr int kPoints = 400;                  // and of a second
constexpr std::size_t kRefined = 120;         // turns of the first test that get a second
constexpr double kFar = 0.008;                // m: distances count up to this
constexpr double kAlike = 0.0025;             // m, mean distance: nearly indistinguishable
constexpr double kApart = 0.3;                // rad
constexpr std::size_t kMaxTurns = 24;
constexpr double kAlternativeHiddenWeight = 0.1;  // as in the search

/// A turn about the model's centre, and how far it leaves the surface from itself.
struct Turned {
  Pose T_O_S;
  double off = 0.0;
};

std::vector<int> evenly(std::size_t count, std::size_t max) {
  std::vector<int> chosen;
  max = std::min(max, count);
  for (std::size_t k = 0; k < max; ++k) chosen.push_back(static_cast<int>(k * count / max));
  return chosen;
}

Pose about(const Eigen::Vector3d& centre, const Eigen::Matrix3d& R) {
  Pose T = Pose::Identity();
  T.linear() = R;
  T.translation() = centre - R * centre;
  return T;
}

/// Mean distance of some surface points from the surface of the model at T_O_S, capped.
double mean_off(const DetectionModel& model, const Pose& T_O_S, const std::vector<int>& points) {
  const Eigen::Isometry3f T_S_O = T_O_S.inverse().cast<float>();
  double sum = 0;
  for (const int i : points) {
    const Eigen::Vector3f q = T_S_O * model.surface.points[static_cast<std::size_t>(i)];
    const int k = model.field.nearest(q);
    const auto at = static_cast<std::size_t>(k);
    sum += k < 0 ? kFar
                 : std::min(kFar, static_cast<double>(
                                      std::abs(model.surface.normals[at].dot(q - model.surface.points[at]))));
  }
  return sum / static_cast<double>(std::max<std::size_t>(1, points.size()));
}

double angle_of(const Eigen::Matrix3d& R) {
  return Eigen::AngleAxisd(R).angle();
}

/// Rotations that cover all orientations evenly enough.
std::vector<Eigen::Matrix3d> all_orientations() {
  std::vector<Eigen::Matrix3d> all;
  for (const auto& d : even_directions(kDirections)) {
    const Eigen::Quaterniond tilt =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), d.cast<double>());
    for (int t = 0; t < kTurns; ++t)
      all.push_back((tilt * Eigen::AngleAxisd(2.0 * std::numbers::pi * t / kTurns, Eigen::Vector3d::UnitZ()))
                        .toRotationMatrix());
  }
  return all;
}

}  // namespace

std::vector<Pose> turns_onto_itself(const DetectionModel& model) {
  const auto glance = evenly(model.surface.points.size(), kGlance);
  const auto points = evenly(model.surface.points.size(), kPoints);
  std::vector<Turned> turns;
  for (const auto& R : all_orientations())
    if (angle_of(R) > kApart) {
      const Pose T = about(model.centre, R);
      turns.push_back({T, mean_off(model, T, glance)});
    }
  const auto nearer = [](const Turned& a, const Turned& b) { return a.off < b.off; };
  std::stable_sort(turns.begin(), turns.end(), nearer);
  turns.resize(std::min(turns.size(), kRefined));
  const RefineOptions refinement{10, 0.015, 0.006, 0.003, 0.5};
  for (auto& turn : turns) {
    turn.T_O_S = refine_pose(model, turn.T_O_S, model.surface, points, refinement).T_C_O;
    turn.off = is_valid(turn.T_O_S) ? mean_off(model, turn.T_O_S, points) : kFar;
  }
  std::stable_sort(turns.begin(), turns.end(), nearer);
  std::vector<Pose> kept;
  for (const auto& turn : turns) {
    if (turn.off > kAlike || kept.size() == kMaxTurns) break;
    if (angle_of(turn.T_O_S.linear()) > kApart && std::all_of(kept.begin(), kept.end(), [&](const Pose& T) {
          return difference(T, turn.T_O_S).angle > kApart;
        }))
      kept.push_back(turn.T_O_S);
  }
  return kept;
}

std::vector<Detection> judged_alternatives(const Detection& d, const DetectionModel& model,
                                           const DetectionScene& alone) {
  std::vector<Pose> poses{d.T_C_O};
  for (const auto& T_O_S : symmetries_of(model)) poses.push_back(d.T_C_O * T_O_S);
  std::vector<Detection> judged(poses.size());
  tbb::parallel_for(std::size_t{0}, poses.size(), [&](std::size_t k) {
    const auto candidate = judge_pose(model, d.stone, poses[k], alone, kAlternativeHiddenWeight);
    if (candidate) judged[k] = candidate->detection;
  });
  std::erase_if(judged, [](const Detection& one) { return one.stone == kNoStone; });
  std::stable_sort(judged.begin(), judged.end(),
                   [](const Detection& a, const Detection& b) { return a.score > b.score; });
  std::vector<Detection> alternatives;
  for (const auto& one : judged)
    if (std::all_of(alternatives.begin(), alternatives.end(),
                    [&](const Detection& l) { return difference(l.T_C_O, one.T_C_O).angle > 0.5 * kApart; }))
      alternatives.push_back(one);
  return alternatives;
}

void widen_by_alternatives(Detection& d) {
  Eigen::Matrix<double, 6, 6> spread = Eigen::Matrix<double, 6, 6>::Zero();
  double own = d.certainty;
  for (const auto& alternative : d.alternatives) {
    if (alternative.stone != d.stone) continue;
    own += alternative.weight;
    const Eigen::AngleAxisd turn(alternative.T_C_O.linear() * d.T_C_O.linear().transpose());
    Eigen::Matrix<double, 6, 1> off;
    off << alternative.T_C_O.translation() - d.T_C_O.translation(), turn.angle() * turn.axis();
    spread += alternative.weight * off * off.transpose();
  }
  d.covariance += spread / own;
}

}  // namespace stonestack::detection
