#include "search/descent.hpp"

#include <algorithm>
#include <limits>

#include "search/constants.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::search {
namespace {

/// x, y and a rotation vector times descent_step / descent_turn, all in metres.
using Step = Eigen::Matrix<double, 5, 1>;

ContactSearch from(const SearchContext& context, const Target& target, StoneIndex stone,
                   const ContactSearch& at, const Step& step) {
  const Eigen::Vector3d turn = step.tail<3>() * (kDescentTurn / kDescentStep);
  Eigen::Matrix3d R = at.T_W_O.linear();
  if (turn.norm() > 1e-12) R = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * R;
  Eigen::Vector3d aside = at.pose.p_W_com - target.p_W_centroid;
  aside -= aside.dot(target.n_W) * target.n_W;
  aside.head<2>() += step.head<2>();
  return search_contact(context, target, stone, placed_along_normal(context, target, stone, R, aside));
}

}  // namespace

Descent descend(const SearchContext& context, const Target& target, StoneIndex stone, ContactSearch start) {
  const SearchOptions& o = *context.options;
  Descent done{std::move(start), {}};
  ContactSearch& best = done.best;
  const auto try_step = [&](const ContactSearch& at, const Step& step, const char* what) {
    ContactSearch there = from(context, target, stone, at, step);
    done.tried.push_back(there);
    if (there.valid) done.tried.back().outcome = what;
    return there;
  };
  double length = 2.0 * kDescentStep;
  for (int round = 0; round < o.descent_rounds && !context.out_of_time(); ++round) {
    throw_if_interrupted();
    Step gradient;
    for (int axis = 0; axis < 5; ++axis) {
      Step step = Step::Zero();
      step[axis] = kDescentStep;
      const ContactSearch beside = try_step(best, step, "perturbed for the gradient");
      const double rise =
          beside.valid ? beside.cost.total - best.cost.total : kMissingContactRise * best.cost.total;
      gradient[axis] = rise / kDescentStep;
    }
    if (gradient.norm() < 1e-12) break;
    const ContactSearch next = try_step(best, -length * gradient.normalized(), "a step of the descent");
    if (!next.valid || next.cost.total >= best.cost.total) {
      length *= 0.5;
      if (length < 0.25 * kDescentStep) break;
      continue;
    }
    const double gain = (best.cost.total - next.cost.total) / std::max(best.cost.total, 1e-12);
    best = next;
    if (gain < o.descent_tolerance) break;
  }
  return done;
}

}  // namespace stonestack::search
