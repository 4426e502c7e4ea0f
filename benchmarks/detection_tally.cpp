#include "detection_tally.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "core/quantile.hpp"

namespace stonestack::bench {
namespace {

constexpr double kChi2Of95 = 12.592;  // six degrees of freedom
constexpr double kTallyRightAngle = 5 * kDegree;
constexpr double kTallyRightShift = 0.005;  // m

double mahalanobis2(const Detection& d, const Pose& truth) {
  Eigen::Matrix<double, 6, 1> e;
  const Eigen::AngleAxisd turn(truth.linear() * d.T_C_O.linear().transpose());
  e << truth.translation() - d.T_C_O.translation(), turn.angle() * turn.axis();
  return e.dot(d.covariance.ldlt().solve(e));
}

/// The stone of `left` that is nearest to a detection of its model; end if none is left.
std::vector<const TrueStone*>::iterator nearest(std::vector<const TrueStone*>& left, const Detection& d) {
  const auto distance = [&](const TrueStone* t) {
    return t->stone == d.stone ? difference(t->T_C_O, d.T_C_O).translation : 1e9;
  };
  const auto at = std::min_element(left.begin(), left.end(), [&](const TrueStone* a, const TrueStone* b) {
    return distance(a) < distance(b);
  });
  return at != left.end() && (*at)->stone == d.stone ? at : left.end();
}

void judge_found(const Detection& d, const TrueStone& truth, const SceneKind& kind, Results* list,
                 DetectionTally& tally) {
  const PoseDifference off = difference(d.T_C_O, truth.T_C_O);
  const bool right = off.angle < kTallyRightAngle && off.translation < kTallyRightShift;
  if (truth.unhidden >= kind.min_unhidden) tally.right += right ? 1 : 0;
  (right ? tally.right_scores : tally.bad_scores).push_back(d.score);
  if (list != nullptr)
    list->note(
        "    %s: stone %d unhidden %.2f score %.3f certain %.2f visible %.3f off %.1f deg %.1f mm, stated "
        "%.1f deg %.1f mm",
        right ? "right" : "wrong", d.stone.value(), truth.unhidden, d.score, d.certainty, d.visible,
        off.angle / kDegree, off.translation * 1000,
        std::sqrt(d.covariance.bottomRightCorner<3, 3>().trace()) / kDegree,
        1000 * std::sqrt(d.covariance.topLeftCorner<3, 3>().trace()));
  if (!right) {
    ++tally.wrong;
    return;
  }
  tally.degrees.push_back(off.angle / kDegree);
  tally.millimetres.push_back(off.translation * 1000);
  if (!(d.covariance.trace() > 0)) return;  // states nothing, which is not right either
  tally.chi2.push_back(mahalanobis2(d, truth.T_C_O));
  tally.calibrated += tally.chi2.back() < kChi2Of95 ? 1 : 0;
}

}  // namespace

void judge(const DetectionResult& result, const BenchScene& scene, const SceneKind& kind, std::size_t models,
           Results* list, DetectionTally& tally) {
  ++tally.scenes;
  std::vector<const TrueStone*> left;
  for (const auto& t : scene.truth) {
    left.push_back(&t);
    tally.present += t.unhidden >= kind.min_unhidden ? 1 : 0;
  }
  for (const StoneIndex stone : first_stones(models))
    tally.absent += std::none_of(scene.truth.begin(), scene.truth.end(),
                                 [&](const TrueStone& t) { return t.stone == stone; })
                        ? 1
                        : 0;
  for (const auto& d : result.detections) {
    const auto at = nearest(left, d);
    if (at == left.end()) {
      ++tally.false_accepts;
      tally.bad_scores.push_back(d.score);
      if (list != nullptr)
        list->note("    false accept: stone %d score %.3f certain %.2f visible %.2f", d.stone.value(),
                   d.score, d.certainty, d.visible);
      continue;
    }
    judge_found(d, **at, kind, list, tally);
    left.erase(at);
  }
  if (list != nullptr && result.depth_scale_sigma > 0)
    list->note("    depth scale %.4f +- %.4f", result.depth_scale, result.depth_scale_sigma);
  for (const auto* t : left)
    if (list != nullptr && t->unhidden >= kind.min_unhidden)
      list->note("    missed: stone %d unhidden %.2f", t->stone.value(), t->unhidden);
}

void add(DetectionTally& sum, const DetectionTally& more) {
  for (const auto count :
       {&DetectionTally::scenes, &DetectionTally::present, &DetectionTally::right, &DetectionTally::wrong,
        &DetectionTally::absent, &DetectionTally::false_accepts, &DetectionTally::calibrated})
    sum.*count += more.*count;
  for (const auto samples : {&DetectionTally::degrees, &DetectionTally::millimetres, &DetectionTally::chi2,
                             &DetectionTally::right_scores, &DetectionTally::bad_scores})
    (sum.*samples).insert((sum.*samples).end(), (more.*samples).begin(), (more.*samples).end());
  sum.wall += more.wall;
  sum.cpu += more.cpu;
}

std::vector<Column> detection_columns() {
  return {{"method"},
          {"kind"},
          {"recall_percent", 1},
          {"right"},
          {"present"},
          {"wrong"},
          {"false"},
          {"absent"},
          {"deg_median"},
          {"deg_p95"},
          {"mm_median"},
          {"mm_p95"},
          {"in_95_percent", 1},
          {"chi2"},
          {"score_p5", 3},
          {"wall_s", 3},
          {"cpu_s", 3}};
}

std::vector<TableValue> detection_cells(const std::string& method, const std::string& kind,
                                        const DetectionTally& t) {
  const auto share = [](int part, double all) {
    return all > 0 ? TableValue(100.0 * part / all) : TableValue();
  };
  return {method,
          kind,
          share(t.right, t.present),
          t.right,
          t.present,
          t.wrong,
          t.false_accepts,
          t.absent,
          quantile(t.degrees, 0.5),
          quantile(t.degrees, 0.95),
          quantile(t.millimetres, 0.5),
          quantile(t.millimetres, 0.95),
          share(t.calibrated, static_cast<double>(t.degrees.size())),
          quantile(t.chi2, 0.95) / kChi2Of95,
          quantile(t.right_scores, 0.05),
          t.wall / t.scenes,
          t.cpu / t.scenes};
}

}  // namespace stonestack::bench
