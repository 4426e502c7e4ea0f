#include "search/wall/span_state.hpp"

#include <algorithm>
#include <limits>

namespace stonestack::search {
namespace {

constexpr double kOverlap = 0.002;           // m by which stones along the axis must overlap to leave no gap
constexpr double kHighEnough = 0.001;        // m that the top of a pier may be lower than what is kept clear
constexpr double kBesideCarry = 0.030;       // m from the place of the carried stone
constexpr double kUpon = 0.001;              // m between stones that counts as resting on each other
constexpr double kUpwards = 0.3;             // z of the normal of a contact that bears
constexpr double kBeside = 1e-6;             // m from an end of a span: blocks end there
constexpr double kMeasuredInTheWay = 0.005;  // m that a stone may seem to reach into what is kept clear

/// The crossings seen from the other side.
Crossings mirrored(const Crossings& crossings) {
  Crossings result(crossings.size());
  for (std::size_t k = 0; k < crossings.size(); ++k)
    if (crossings[k])
      result[k] = AxisCrossing{-crossings[k]->to, -crossings[k]->from, crossings[k]->top,
                               -crossings[k]->ground_to, -crossings[k]->ground_from};
  return result;
}

/// How far stones reach that begin before `span.from`, one after another.
SpanEnd left_end(const Span& span, const Crossings& crossings, double reach) {
  SpanEnd end;
  end.x = span.from - reach;
  const auto is_high = [&](const AxisCrossing& one) { return one.top >= span.clear - kHighEnough; };
  for (bool further = true; further;) {
    further = false;
    for (std::size_t k = 0; k < crossings.size(); ++k) {
      if (!crossings[k] || !is_high(*crossings[k])) continue;
      const AxisCrossing& one = *crossings[k];
      const double begins = end.stone < 0 ? span.from : std::max(span.from, end.x - kOverlap);
      if (one.from > begins || one.to <= end.x) continue;
      end.x = one.to;
      end.top = one.top;
      end.stone = static_cast<int>(k);
      further = true;
    }
  }
  return end;
}

/// Can anything stand before `x`?
bool may_stand_before(const SpanTask& task, double x, bool mirrored) {
  if (task.on_table) return true;
  return std::any_of(task.supports.begin(), task.supports.end(), [&](const TargetSupport& support) {
    return (mirrored ? -support.to : support.from) < x;
  });
}

Eigen::Vector3d corner_of(const BodyPose& body, int vertex) {
  return body.R_W_O * body.stone->vertices_M[static_cast<std::size_t>(vertex)] + body.p_W_M;
}

/// Lowest point of an edge where it runs between two x; infinite if it does not.
double lowest_between(const Eigen::Vector3d& p, const Eigen::Vector3d& q, double from, double to) {
  const double low = std::max(std::min(p.x(), q.x()), from), high = std::min(std::max(p.x(), q.x()), to);
  if (low > high || std::max(p.x(), q.x()) <= from || std::min(p.x(), q.x()) >= to)
    return std::numeric_limits<double>::infinity();
  if (p.x() == q.x()) return std::min(p.z(), q.z());
  const auto height = [&](double x) { return p.z() + (x - p.x()) / (q.x() - p.x()) * (q.z() - p.z()); };
  return std::min(height(low), height(high));
}

std::optional<AxisCrossing> crossing_of(const BodyPose& body) {
  AxisCrossing crossing{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                        -std::numeric_limits<double>::infinity(), 0.0, 0.0};
  for (const Eigen::Vector3i& face : body.stone->faces)
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d p = corner_of(body, face[k]), q = corner_of(body, face[(k + 1) % 3]);
      if ((p.y() < 0.0) == (q.y() < 0.0)) continue;
      const Eigen::Vector3d at = p + (q - p) * (p.y() / (p.y() - q.y()));
      crossing.from = std::min(crossing.from, at.x());
      crossing.to = std::max(crossing.to, at.x());
      crossing.top = std::max(crossing.top, at.z());
    }
  if (crossing.from > crossing.to) return std::nullopt;
  return crossing;
}

/// From where to where along x a stone stands on the table [m].
struct Ground {
  double from = std::numeric_limits<double>::infinity(), to = -std::numeric_limits<double>::infinity();
  bool widen(double low, double high) {
    const bool wider = low < from || high > to;
    from = std::min(from, low);
    to = std::max(to, high);
    return wider;
  }
};

std::vector<Ground> grounds(std::size_t stones, std::span<const Contact> contacts) {
  std::vector<Ground> ground(stones);
  for (bool wider = true; wider;) {
    wider = false;
    for (const Contact& contact : contacts) {
      Ground& above = ground[static_cast<std::size_t>(contact.above)];
      if (contact.below == kTable) {
        wider = above.widen(contact.p_W.x(), contact.p_W.x()) || wider;
        continue;
      }
      Ground& below = ground[static_cast<std::size_t>(contact.below)];
      if (contact.n_W.z() > kUpwards) wider = above.widen(below.from, below.to) || wider;
      if (contact.n_W.z() < -kUpwards) wider = below.widen(above.from, above.to) || wider;
    }
  }
  return ground;
}

/// Do stones over a span stand before it?
bool stands_before(const Span& span, const Crossings& crossings) {
  return std::any_of(crossings.begin(), crossings.end(), [&](const auto& one) {
    return one && one->from < span.to && one->to > span.from && one->ground_from < span.from;
  });
}

bool all_closed(const SpanTask& task, const Crossings& crossings) {
  return std::all_of(task.spans.begin(), task.spans.end(),
                     [&](const Span& span) { return open_span(task, span, crossings, 0.1).closed; });
}

}  // namespace

Crossings axis_crossings(const SearchContext& context, const WallState& state,
                         std::span<const Contact> contacts) {
  Crossings crossings;
  for (const WallStonePlaced& placed : state.stones)
    crossings.push_back(crossing_of(body_pose(at(context.geometry, placed.stone), placed.T_W_O)));
  const std::vector<Ground> ground = grounds(state.stones.size(), contacts);
  for (std::size_t k = 0; k < crossings.size(); ++k) {
    if (!crossings[k]) continue;
    crossings[k]->ground_from = ground[k].from;
    crossings[k]->ground_to = ground[k].to;
  }
  return crossings;
}

Crossings axis_crossings(const SearchContext& context, const WallState& state) {
  const StackStatics statics = stack_statics(context.shapes(), state.stack(), context.options->friction);
  return axis_crossings(context, state, statics.contacts);
}

OpenSpan open_span(const SpanTask& task, const Span& span, const Crossings& crossings, double reach) {
  OpenSpan open;
  open.left = left_end(span, crossings, reach);
  const Span other{-span.to, -span.from, span.clear};
  open.right = left_end(other, mirrored(crossings), reach);
  open.right.x = -open.right.x;
  open.left.wanted = may_stand_before(task, span.from, false);
  open.right.wanted = may_stand_before(task, -span.to, true);
  const bool over_all =
      open.left.x >= std::min(span.to, open.right.x + kOverlap) || open.right.x <= span.from;
  if (over_all) {
    const bool left = !open.left.wanted || stands_before(span, crossings);
    const bool right = !open.right.wanted || stands_before(other, mirrored(crossings));
    open.closed = left && right;
    if (!left) open.left = {true, -1, span.from - reach, 0.0};
    if (!right) open.right = {true, -1, span.to + reach, 0.0};
  }
  if (!open.left.wanted) open.left.x = std::max(open.left.x, span.from);
  if (!open.right.wanted) open.right.x = std::min(open.right.x, span.to);
  return open;
}

double in_the_way(const SearchContext& context, std::span<const Span> spans, const WallStonePlaced& placed) {
  const BodyPose body = body_pose(at(context.geometry, placed.stone), placed.T_W_O);
  double most = 0.0;
  for (const Eigen::Vector3i& face : body.stone->faces)
    for (int k = 0; k < 3; ++k)
      for (const Span& span : spans)
        most = std::max(
            most, span.clear - lowest_between(corner_of(body, face[k]), corner_of(body, face[(k + 1) % 3]),
                                              span.from + kBeside, span.to - kBeside));
  return most;
}

namespace {

bool is_clear(const SearchContext& context, std::span<const Span> spans, const WallState& state) {
  return std::all_of(state.stones.begin(), state.stones.end(), [&](const WallStonePlaced& placed) {
    return in_the_way(context, spans, placed) < kMeasuredInTheWay;
  });
}

}  // namespace

bool carries(const SearchContext& context, const SpanTask& task, const WallState& state) {
  if (!task.carry) return true;
  const Crossings crossings = axis_crossings(context, state);
  std::vector<bool> borne(state.stones.size(), false);  // that bear others
  for (const Contact& contact : geometric_contacts(context.shapes(), state.stack(), kUpon))
    if (contact.below != kTable && contact.n_W.z() > kUpwards)
      borne[static_cast<std::size_t>(contact.below)] = true;
  for (std::size_t k = 0; k < state.stones.size(); ++k) {
    const WallStonePlaced& placed = state.stones[k];
    const BodyPose body = body_pose(at(context.geometry, placed.stone), placed.T_W_O);
    if (borne[k] || std::abs(body.p_W_M.x() - *task.carry) > kBesideCarry) continue;
    Crossings others = crossings;
    others[k].reset();
    if (all_closed(task, others)) return true;
  }
  return false;
}

bool is_done(const SearchContext& context, const SpanTask& task, const WallState& state) {
  return is_clear(context, task.spans, state) && all_closed(task, axis_crossings(context, state)) &&
         carries(context, task, state);
}

WallMetrics span_metrics(const SearchContext& context, const SpanTask& task, const WallState& state,
                         std::size_t supports) {
  WallMetrics metrics;
  metrics.placed = static_cast<int>(state.stones.size() - supports);
  const Crossings crossings = axis_crossings(context, state);
  for (const Span& span : task.spans) {
    const OpenSpan open = open_span(task, span, crossings, 0.0);
    const double left = std::clamp(open.left.x, span.from, span.to);
    const double right = std::clamp(open.right.x, span.from, span.to);
    metrics.to_span += span.to - span.from;
    if (!is_clear(context, {&span, 1}, state)) continue;
    metrics.spanned += (span.to - span.from) - (open.closed ? 0.0 : right - left);
  }
  if (metrics.placed == 0) return metrics;
  double left = std::numeric_limits<double>::infinity(), right = -left;
  for (std::size_t k = supports; k < state.stones.size(); ++k) {
    const Extents& reach = state.stones[k].reach;
    left = std::min(left, reach.min.x());
    right = std::max(right, reach.max.x());
    metrics.width += (reach.max - reach.min).y() / metrics.placed;
    metrics.height = std::max(metrics.height, state.stones[k].top);
  }
  metrics.length = right - left;
  metrics.margin = margin_of_all(context, state);
  return metrics;
}

}  // namespace stonestack::search
