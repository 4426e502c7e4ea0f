#include "search/wall/span_search.hpp"

#include <algorithm>
#include <cmath>

#include "physics/shape.hpp"
#include "search/constants.hpp"
#include "search/parallel.hpp"
#include "search/wall/span_state.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::search {
namespace {

constexpr double kSupportDensity = 2600.0;  // kg/m^3
constexpr std::size_t kBeams[] = {5, 12};   // structures that get their next stone; the second if need be
constexpr std::size_t kSettledAtPlace = 8;  // proposals of a place that are let down in simulation
constexpr std::size_t kJudgedForEach = 3;   // stones that are judged for each of a beam, at most
constexpr std::size_t kOfOneParent = 2;     // structures of a beam that go on from the same one, at first
constexpr double kLooksAlike = 0.004;       // m by which the stones of two structures of a beam differ
constexpr std::size_t kMaxStones = 12;      // of a structure
constexpr double kBesideSpan = 0.008;       // m that a pier on the table keeps from the span
constexpr double kClearAside = 0.004;       // m beside a span that is kept clear, too
constexpr double kSags = 0.001;             // m that a stone may reach into what is kept clear
constexpr double kBesideStone = 0.010;      // m between stones on the table
constexpr double kBehindEnd = 0.03;         // m from an end to where the stone that goes on lies
constexpr double kSteps[] = {0.025, 0.05, 1.0};  // m further that stones are to reach
constexpr double kLoadSteps[] = {0.09, 0.15};    // m behind an end where stones weigh it down
constexpr double kLoads[] = {0.25, 0.5, 0.75};   // shares of a stone's mass that an end is tried with
constexpr double kFirm = 0.15;                   // g: more is worth nothing more

// Worth of what a state has come to, in lengths of a usual stone that are still open.
constexpr double kWorthOfEnd = 0.4;     // of an end that bears what is laid upon it
constexpr double kWorthOfLevel = 0.3;   // of ends that are equally high
constexpr double kUnlevel = 0.05;       // m between the tops of two ends that cost all of it
constexpr double kWorthOfPier = 0.5;    // of a pier that is as high as it must be
constexpr double kWorthOfMargin = 0.2;  // of the margin of the whole
constexpr double kCostOfStone = 0.03;
constexpr double kCarried = 1.0;  // of the stone that is carried

// Worth of a stone in a place.
constexpr double kOffAxisCost = 0.06;  // m beside the axis that cost as much as half of its firmness
constexpr double kTiltCost = 0.35;     // rad, likewise
constexpr double kNoGain = 0.005;      // m further that count as nothing
constexpr double kUseless = -10.0;

double common_worth(const WallStonePlaced& placed, double firmness) {
  const double middle = 0.5 * (placed.reach.min + placed.reach.max).y();
  return 2.0 * std::min(firmness / kFirm, 1.0) - std::abs(middle) / kOffAxisCost -
         0.5 * std::acos(std::clamp(placed.level, -1.0, 1.0)) / kTiltCost;
}

/// The surface of all that stands; in the spans up to what is kept clear, and on the table, nothing may be
/// touched.
StackField field_of(const SearchContext& context, const SpanTask& task, const WallState& state,
                    const SurfaceGrid& grid) {
  std::vector<BodyPose> bodies;
  for (const WallStonePlaced& placed : state.stones)
    bodies.push_back(body_pose(at(context.geometry, placed.stone), placed.T_W_O));
  StackField field{top_surface(bodies, {}, grid, kCleanHeight), {}, context.options->friction};
  HeightRaster& heights = field.surface.heights;
  for (std::size_t k = 0; k < heights.z.size(); ++k) {
    const double x = heights.node(static_cast<int>(k)).x();
    for (const Span& span : task.spans) {
      if (x <= span.from - kClearAside || x >= span.to + kClearAside ||
          static_cast<double>(heights.z[k]) >= span.clear - kSags)
        continue;
      heights.z[k] = static_cast<float>(span.clear - kSags);
      field.surface.may_touch[k] = 0;
    }
  }
  return field;
}

/// From where to where along x a stone on the table goes below a height, from its centre of mass [m].
std::pair<double, double> reach_below(const StoneGeometry& stone, const WallSide& side, double height) {
  std::pair<double, double> reach{0.0, 0.0};
  for (const Eigen::Vector3d& p_M : stone.vertices_M) {
    const Eigen::Vector3d p = side.R_W_O * p_M;
    if (p.z() + side.on_table.height > height) continue;
    reach.first = std::min(reach.first, p.x());
    reach.second = std::max(reach.second, p.x());
  }
  return reach;
}

/// Is there something on the table where a stone is proposed?
bool stands_in_the_way(const WallState& state, const WallProposal& proposal) {
  const Extents reach = extents_of(*proposal.stone->geometry, proposal.proposal.body.R_W_O);
  const Eigen::Vector2d p = proposal.proposal.body.p_W_M.head<2>();
  return std::any_of(state.stones.begin(), state.stones.end(), [&](const WallStonePlaced& other) {
    return ((p + reach.max - other.reach.min).array() > -kBesideStone).all() &&
           ((other.reach.max - p - reach.min).array() > -kBesideStone).all();
  });
}

/// Do two structures look the same, whichever stones they are made of?
bool look_alike(const WallState& p, const WallState& q) {
  const auto near = [](const WallStonePlaced& a, const WallStonePlaced& b) {
    return (a.reach.min - b.reach.min).cwiseAbs().maxCoeff() < kLooksAlike &&
           (a.reach.max - b.reach.max).cwiseAbs().maxCoeff() < kLooksAlike &&
           std::abs(a.top - b.top) < kLooksAlike;
  };
  return p.stones.size() == q.stones.size() &&
         std::all_of(p.stones.begin(), p.stones.end(), [&](const WallStonePlaced& a) {
           return std::any_of(q.stones.begin(), q.stones.end(), [&](const auto& b) { return near(a, b); });
         });
}

/// Of a finished structure: chance that each stone stays where it is put, then the margin.
double sureness(const WallState& state) {
  double all = 1.0;
  for (const Trial& trial : state.trials)
    if (trial.stone != kNoStone) all *= trial.placement.predicted_success;
  return all + 0.1 * std::min(1.0, state.trials.back().margin / kFirm);
}

}  // namespace

TaskSupports make_supports(const SpanTask& task) {
  TaskSupports supports;
  for (const TargetSupport& block : task.supports) {
    const Mesh mesh = make_box({block.to - block.from, block.depth, block.height});
    supports.shapes.push_back(make_contact_shape(mesh, mass_properties(mesh, kSupportDensity),
                                                 concat("support_", supports.shapes.size() + 1)));
    supports.T_V_O.push_back(
        make_pose(Eigen::Vector3d(0.5 * (block.from + block.to), 0.0, 0.5 * block.height)));
  }
  return supports;
}

/// A part of the structure, and the worth of stones there.
struct SpanSearch::Place {
  bool on_table = false;
  WallPlace place;
};

SpanSearch::SpanSearch(const SearchContext& context, const SpanTask& task, WallState start, Placing& placing)
    : context_(context),
      task_(task),
      placing_(placing),
      stones_(wall_stones(context, 2 * raster_half(context, context.options->grid) + 1)),
      start_(std::move(start)) {
  if (stones_.empty()) return;
  length_ = mass_ = 0.0;
  for (const WallStone& stone : stones_) {
    double longest = 0.0;
    for (const WallSide& side : stone.sides)
      longest = std::max(longest, (side.extents.max - side.extents.min).x());
    length_ += longest / static_cast<double>(stones_.size());
    mass_ += stone.geometry->mass / static_cast<double>(stones_.size());
  }
}

bool SpanSearch::is_support(int stone) const {
  return stone >= 0 && static_cast<std::size_t>(stone) < task_.supports.size();
}

double SpanSearch::load_borne(const StackStatics& statics, const SpanEnd& end) const {
  if (!end.wanted || is_support(end.stone)) return 1.0;
  if (end.stone < 0) return 0.0;
  EquilibriumOptions options;
  options.friction = context_.options->friction;
  options.directions = 1;
  options.min_friction = false;
  double borne = 0.0;
  for (const double share : kLoads) {
    std::vector<StaticBody> bodies = statics.bodies;
    StaticBody& body = bodies[static_cast<std::size_t>(end.stone)];
    const double load = share * mass_;
    const Eigen::Vector3d p_end(end.x, 0.0, end.top);
    body.p_W_com = (body.mass * body.p_W_com + load * p_end) / (body.mass + load);
    body.mass += load;
    if (!solve_equilibrium(bodies, statics.contacts, options).stands) break;
    borne += 1.0 / static_cast<double>(std::size(kLoads));
  }
  return borne;
}

double SpanSearch::value_of(const WallState& state) const {
  const StackStatics statics = stack_statics(context_.shapes(), state.stack(), context_.options->friction);
  const Crossings crossings = axis_crossings(context_, state, statics.contacts);
  double value = 0.0;
  for (const Span& span : task_.spans) {
    const OpenSpan open = open_span(task_, span, crossings, length_);
    if (open.closed) continue;
    value -= open.length() / length_;
    for (const SpanEnd& end : {open.left, open.right})
      value -= kWorthOfEnd * (1.0 - load_borne(statics, end));
    if (open.left.stone >= 0 && open.right.stone >= 0)
      value -= kWorthOfLevel * std::min(1.0, std::abs(open.left.top - open.right.top) / kUnlevel);
    // Piers that are not high enough yet.
    for (const bool left : {true, false}) {
      const SpanEnd& end = left ? open.left : open.right;
      if (!end.wanted || end.stone >= 0) continue;
      double top = 0.0;
      for (const auto& one : crossings)
        if (one && (left ? one->to <= span.from && one->to > span.from - length_
                         : one->from >= span.to && one->from < span.to + length_))
          top = std::max(top, one->top);
      value -= kWorthOfPier * (1.0 - std::min(1.0, top / span.clear));
    }
  }
  const double margin = state.trials.empty() ? 0.0 : state.trials.back().margin;
  value += kWorthOfMargin * std::min(margin / kFirm, 1.0);
  value -= kCostOfStone * static_cast<double>(state.stones.size());
  if (task_.carry && carries(context_, task_, state)) value += kCarried;
  return value;
}

std::vector<SpanSearch::Place> SpanSearch::places(const WallState& state) const {
  std::vector<Place> list;
  const Crossings crossings = axis_crossings(context_, state);
  const auto field = [this, &state](const SurfaceGrid& grid) {
    return field_of(context_, task_, state, grid);
  };
  const auto add = [&](double x, std::function<double(const WallStonePlaced&, double)> worth) {
    Place made;
    made.place.course = 1;
    made.place.centre = {x, 0.0};
    made.place.field = field;
    made.place.wanted = [x](const WallStone&, const WallSide& side) {
      return Eigen::Vector2d(x, -0.5 * (side.extents.min + side.extents.max).y());
    };
    made.place.worth = std::move(worth);
    list.push_back(std::move(made));
  };
  bool all_closed = true;
  for (const Span& span : task_.spans) {
    const OpenSpan open = open_span(task_, span, crossings, length_);
    if (open.closed) continue;
    all_closed = false;
    // A stone that reaches further from either side, at best to the other, or by `step` alone.
    const auto further = [open, this](double step) {
      return [open, step, this](const WallStonePlaced& placed, double firmness) {
        const double from = placed.reach.min.x(), to = placed.reach.max.x();
        double gain = 0.0;
        if (from < open.left.x) gain = std::max(gain, std::min(to, open.right.x) - open.left.x);
        if (to > open.right.x) gain = std::max(gain, open.right.x - std::max(from, open.left.x));
        if (gain < kNoGain) return kUseless;
        return common_worth(placed, firmness) + 3.0 * (gain - 2.0 * std::max(0.0, gain - step)) / length_;
      };
    };
    const auto load = [this](const WallStonePlaced& placed, double firmness) {
      return common_worth(placed, firmness) + at(context_.geometry, placed.stone).mass / mass_;
    };
    for (const bool left : {true, false}) {
      const SpanEnd& end = left ? open.left : open.right;
      const double out = left ? 1.0 : -1.0;  // along x, into the span
      if (!end.wanted) continue;
      if (end.stone >= 0) {
        for (const double step : kSteps) add(end.x - out * kBehindEnd, further(step));
        if (!is_support(end.stone))
          for (const double step : kLoadSteps) add(end.x - out * step, load);
        continue;
      }
      // A pier is begun on the table, or raised.
      const double edge = left ? span.from : span.to;
      const AxisCrossing* low = nullptr;
      for (const auto& one : crossings) {
        if (!one || (left ? one->to > edge || one->to < edge - length_
                          : one->from < edge || one->from > edge + length_))
          continue;
        if (low == nullptr || one->top > low->top) low = &*one;
      }
      const double other = left ? open.right.top : open.left.top;
      const bool level = (left ? open.right : open.left).stone >= 0;
      const auto pier = [this, span, other, level](const WallStonePlaced& placed, double firmness) {
        const double top = placed.top;
        double worth = common_worth(placed, firmness) + std::min(placed.breadth, 0.03) / 0.03 +
                       std::min(1.0, top / span.clear);
        if (level) worth -= std::min(1.0, std::abs(top - other) / kUnlevel);
        return worth;
      };
      if (low != nullptr) {
        add(0.5 * (low->from + low->to), pier);
        continue;
      }
      if (!task_.on_table) continue;
      Place made;
      made.on_table = true;
      made.place.wanted = [edge, left, span](const WallStone& stone, const WallSide& side) {
        const auto [from, to] = reach_below(*stone.geometry, side, span.clear + kSags);
        const double x = left ? edge - kBesideSpan - to : edge + kBesideSpan - from;
        return Eigen::Vector2d(x, -0.5 * (side.extents.min + side.extents.max).y());
      };
      made.place.worth = pier;
      list.push_back(std::move(made));
    }
    if (open.left.stone >= 0 && open.right.stone >= 0)
      add(0.5 * (open.left.x + open.right.x), further(open.length()));
  }
  if (all_closed && task_.carry) {
    const double x = *task_.carry;
    add(x, [x, this](const WallStonePlaced& placed, double firmness) {
      const Eigen::Vector3d p_W_M = body_pose(at(context_.geometry, placed.stone), placed.T_W_O).p_W_M;
      return common_worth(placed, firmness) - std::abs(p_W_M.x() - x) / 0.02;
    });
  }
  return list;
}

std::vector<SpanSearch::Child> SpanSearch::children(const Node& node) {
  std::vector<Child> list;
  const Stack below = node.state.stack();
  const std::vector<const WallStone*> left = stones_left(stones_, node.state);
  for (const Place& one : places(node.state)) {
    if (context_.out_of_time()) break;
    WallProposals made =
        one.on_table ? table_proposals(context_, one.place, left) : proposals_at(context_, one.place, left);
    candidates_ += made.evaluated;
    std::erase_if(made.list, [&](const WallProposal& p) { return p.worth <= 0.5 * kUseless; });
    if (one.on_table)
      std::erase_if(made.list, [&](const WallProposal& p) { return stands_in_the_way(node.state, p); });
    const bool fits = !made.list.empty();
    const std::vector<WallProposal> kept = placing_.reachable(std::move(made.list), below, kSettledAtPlace);
    if (fits && kept.empty()) placing_.reason = "the arm brings none of the stones that fit to its place";
    for (Settled& next : placing_.settled(below, kept, 0)) {
      if (in_the_way(context_, task_.spans, next.placed) < kSags)
        list.push_back({&node, std::move(next), 0.0});
      else
        placing_.reason = "a stone reaches into what is kept clear";
    }
  }
  run_tasks(context_.options->threads, list.size(),
            [&](std::size_t k) { list[k].value = value_of(with(node.state, list[k].next)); });
  for (Child& child : list) child.next.trial.placement.terms["worth"] = child.value;
  return list;
}

std::vector<Alternative> SpanSearch::compared_with(const std::vector<Child>& children, std::size_t chosen) {
  std::vector<Alternative> others;
  for (std::size_t k = 0; k < children.size() && others.size() < kMaxAlternatives; ++k) {
    if (k == chosen || children[k].parent != children[chosen].parent) continue;
    others.push_back(alternative_of(children[k].next.trial));
  }
  return others;
}

std::vector<SpanSearch::Node> SpanSearch::next_beam(std::vector<Child> children, std::size_t width) {
  std::stable_sort(children.begin(), children.end(),
                   [](const Child& p, const Child& q) { return p.value > q.value; });
  std::vector<Node> beam;
  std::vector<bool> used(children.size(), false);
  std::vector<std::size_t> taken;  // of each of the beam
  std::size_t judged = 0;
  const auto with_compared = [&] {
    for (std::size_t k = 0; k < beam.size(); ++k)
      beam[k].state = with(beam[k].parent->state, children[taken[k]].next, compared_with(children, taken[k]));
    return std::move(beam);
  };
  // First few of each parent, then any.
  for (const std::size_t of_parent : {kOfOneParent, width})
    for (std::size_t k = 0; k < children.size(); ++k) {
      if (beam.size() == width || judged == kJudgedForEach * width || context_.out_of_time())
        return with_compared();
      Child& child = children[k];
      const auto same = std::count_if(beam.begin(), beam.end(),
                                      [&](const Node& node) { return node.parent == child.parent; });
      if (used[k] || static_cast<std::size_t>(same) >= of_parent) continue;
      used[k] = true;
      const WallState made = with(child.parent->state, child.next);
      if (std::any_of(beam.begin(), beam.end(),
                      [&](const Node& node) { return look_alike(node.state, made); }))
        continue;
      ++judged;
      if (!placing_.holds(child.parent->state, child.next)) continue;
      beam.push_back({with(child.parent->state, child.next), child.value, child.parent});
      taken.push_back(k);
    }
  return with_compared();
}

void SpanSearch::keep(const Node& node) {
  if (!best_.state.stones.empty() && node.value <= best_.value) return;
  best_ = node;
  const std::size_t stones = node.state.stones.size() - task_.supports.size();
  context_.log(concat(stones, stones == 1 ? " stone stands" : " stones stand"));
}

void SpanSearch::search(std::size_t width) {
  std::vector<Node> beam{{start_, value_of(start_), nullptr}};
  const std::size_t most = start_.stones.size() + std::min(kMaxStones, stones_.size());
  while (!done_ && !beam.empty() && beam.front().state.stones.size() < most && !context_.out_of_time()) {
    std::vector<Child> all;
    for (const Node& from : beam) {
      std::vector<Child> of_node = children(from);
      std::move(of_node.begin(), of_node.end(), std::back_inserter(all));
    }
    if (all.empty() && placing_.reason.empty()) placing_.reason = "no stone that is left fits";
    std::vector<Node> next = next_beam(std::move(all), width);
    const Node* finished = nullptr;
    for (const Node& one : next) {
      keep(one);
      if (!is_done(context_, task_, one.state)) continue;
      if (finished == nullptr || sureness(one.state) > sureness(finished->state)) finished = &one;
    }
    if (finished != nullptr) {
      best_ = *finished;
      done_ = true;
    }
    beam = std::move(next);
  }
}

void SpanSearch::run(const std::vector<WallPlacement>& rest, bool rest_only) {
  try {
    Node node{start_, value_of(start_), nullptr};
    best_ = node;
    done_ = is_done(context_, task_, node.state);
    for (const WallPlacement& planned : rest) {
      if (done_ || context_.out_of_time()) break;
      const auto next =
          placing_.as_planned(node.state, planned, node.state.stones.size() == start_.stones.size());
      if (!next) break;
      node.state = with(node.state, *next, placing_.compared_with(planned));
      node.value = value_of(node.state);
      done_ = is_done(context_, task_, node.state);
      best_ = node;
    }
    if (done_ || rest_only) return;
    for (const std::size_t width : kBeams)
      if (!done_ && !context_.out_of_time()) search(width);
    if (!done_ && context_.out_of_time()) placing_.reason = kTimeOver;
  } catch (const Interrupted&) {
    placing_.reason = why_interrupted();
  }
}

}  // namespace stonestack::search
