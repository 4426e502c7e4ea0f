#include <algorithm>
#include <cmath>

#include "physics/shape.hpp"
#include "search/constants.hpp"
#include "search/parallel.hpp"
#include "search/wall/wall_state.hpp"

namespace stonestack::search {
namespace {

constexpr double kRasterGap = 0.004;        // m between neighbours that a raster keeps by itself
constexpr int kSlotOffsets = 4;             // OffsetGrid::n
constexpr double kSlotPitch = 0.008;        // m
constexpr int kLevellings = 4;              // rounds of turning a stone level and landing it anew
constexpr double kLevelTilt = 0.02;         // rise over run that needs no further turning
constexpr std::size_t kRefinedInSlot = 40;  // proposals that are refined
constexpr std::size_t kPerStone = 6;        // of these, of one stone at most

/// Surface that a slot's stone is laid over.
StackField wall_field(const SearchContext& context, const WallState& state, const WallSlot& slot,
                      const SurfaceGrid& grid) {
  std::vector<BodyPose> below, beside;
  const double reach = grid.half * grid.cell;
  for (const WallStonePlaced& placed : state.stones) {
    const StoneGeometry& geometry = at(context.geometry, placed.stone);
    const BodyPose body = body_pose(geometry, placed.T_W_O);
    if ((body.p_W_M.head<2>() - grid.centre).lpNorm<Eigen::Infinity>() > reach + geometry.radius) continue;
    if (placed.course != slot.course) {
      below.push_back(body);
      continue;
    }
    beside.push_back(body);
    const double wider = slot.joint_gap - kRasterGap;
    if (wider <= 0.0) continue;
    for (const Eigen::Vector3d& n : {Eigen::Vector3d::UnitX().eval(), Eigen::Vector3d::UnitY().eval()})
      for (const double aside : {-wider, wider}) {
        beside.push_back(body);
        beside.back().p_W_M += aside * n;
      }
  }
  return {top_surface(below, beside, grid, kCleanHeight), {}, context.options->friction};
}

/// Where the centre of mass of a side goes before it is moved about.
Eigen::Vector2d wanted_place(const WallSlot& slot, const WallSide& side) {
  const double gap = slot.course > 0 ? std::max(0.0, slot.joint_gap - kRasterGap) : slot.joint_gap;
  const double left = std::isfinite(slot.from) ? slot.from + gap : 0.0;
  const double x = slot.centre ? *slot.centre - 0.5 * (side.extents.min + side.extents.max).x()
                               : left - side.extents.min.x();
  return {x, -0.5 * (side.extents.min + side.extents.max).y()};
}

WallProposal proposal_of(const WallStone& stone, const WallSide& side, const WallPlace& place,
                         const Eigen::Matrix3d& R_W_O, const Eigen::Vector3d& p_W_com, const Landing& landing,
                         double firmness) {
  WallProposal made{&stone, &side, {}, 0.0};
  made.proposal.stone = stone.stone;
  made.proposal.body = {stone.geometry, R_W_O, p_W_com};
  made.proposal.landing = landing;
  made.proposal.robust = firmness;
  made.worth = place.worth(placed_in_wall(stone, side, R_W_O, p_W_com, place.course), firmness);
  return made;
}

/// The best landing of a side about the place where it is wanted.
std::optional<WallProposal> best_landing(const StackField& field, const WallStone& stone,
                                         const WallSide& side, const WallPlace& place, GapField* buffer,
                                         long* evaluated) {
  const HeightRaster& heights = field.surface.heights;
  const Eigen::Vector2d from = (place.wanted(stone, side) - heights.centre) / heights.cell;
  OffsetGrid offsets;
  offsets.n = kSlotOffsets;
  offsets.step = std::max(1, static_cast<int>(std::lround(kSlotPitch / heights.cell)));
  const double radius = std::ceil(stone.geometry->radius / heights.cell) + kRun;
  const int limit = heights.half - static_cast<int>(radius) - offsets.n * offsets.step;
  if (limit < 0) return std::nullopt;
  offsets.i = std::clamp(static_cast<int>(std::lround(from.x())), -limit, limit);
  offsets.j = std::clamp(static_cast<int>(std::lround(from.y())), -limit, limit);
  const LandingGrid grid = land(field, side.underside, stone.geometry->mass, offsets, buffer);
  *evaluated += static_cast<long>(grid.landings.size());
  std::optional<WallProposal> best;
  for (int v = 1 - offsets.n; v < offsets.n; ++v)
    for (int u = 1 - offsets.n; u < offsets.n; ++u) {
      const Landing& landing = grid.at(u, v);
      if (!landing.holds) continue;
      Eigen::Vector3d p_W;
      p_W << heights.node(heights.index(offsets.i + u * offsets.step, offsets.j + v * offsets.step)),
          landing.height;
      WallProposal made =
          proposal_of(stone, side, place, levelled(side.R_W_O, landing), p_W, landing, landing.estimate);
      if (!best || made.worth > best->worth) best = std::move(made);
    }
  return best;
}

/// Turns a proposal level and moves it to the best place nearby, on a finer raster.
std::optional<WallProposal> refined_landing(const StackField& fine, const WallProposal& start,
                                            const WallPlace& place, long* evaluated) {
  GapField buffer;
  const HeightRaster& heights = fine.surface.heights;
  const StoneGeometry& stone = *start.stone->geometry;
  Eigen::Matrix3d R = start.proposal.body.R_W_O;
  const Eigen::Vector2d from = (start.proposal.body.p_W_M.head<2>() - heights.centre) / heights.cell;
  OffsetGrid offsets;
  offsets.n = kSlotOffsets;
  offsets.step = 1;
  const int radius = static_cast<int>(std::ceil(stone.radius / heights.cell)) + kRun;
  const int limit = heights.half - radius - offsets.n;
  if (limit < 0) return std::nullopt;
  offsets.i = std::clamp(static_cast<int>(std::lround(from.x())), -limit, limit);
  offsets.j = std::clamp(static_cast<int>(std::lround(from.y())), -limit, limit);
  std::optional<WallProposal> best;
  for (int round = 0; round < kLevellings; ++round) {
    const Underside side = make_underside(stone.vertices_M, stone.faces, R, underside_options(fine));
    const LandingGrid grid = land(fine, side, stone.mass, offsets, &buffer);
    *evaluated += static_cast<long>(grid.landings.size());
    std::optional<WallProposal> of_round;
    int best_u = 0, best_v = 0;
    for (int v = 1 - offsets.n; v < offsets.n; ++v)
      for (int u = 1 - offsets.n; u < offsets.n; ++u) {
        const Landing& landing = grid.at(u, v);
        if (!landing.holds) continue;
        Eigen::Vector3d p_W;
        p_W << heights.node(heights.index(offsets.i + u, offsets.j + v)), landing.height;
        WallProposal made = proposal_of(*start.stone, *start.side, place, levelled(R, landing), p_W, landing,
                                        landing.estimate);
        if (!of_round || made.worth > of_round->worth) of_round = std::move(made), best_u = u, best_v = v;
      }
    if (!of_round) break;
    const Landing& landing = of_round->proposal.landing;
    const double tilt = std::hypot(landing.a, landing.b);
    if (tilt < 2.0 * kLevelTilt && (!best || of_round->worth > best->worth)) best = of_round;
    if (tilt < kLevelTilt && best_u == 0 && best_v == 0) break;
    offsets.i = std::clamp(offsets.i + best_u, -limit, limit);
    offsets.j = std::clamp(offsets.j + best_v, -limit, limit);
    R = levelled(R, landing);
  }
  return best;
}

/// Stones side by side on the table.
std::vector<WallProposal> on_the_table(const std::vector<const WallStone*>& stones, const WallPlace& place,
                                       double friction) {
  std::vector<WallProposal> list;
  for (const WallStone* stone : stones)
    for (const WallSide& side : stone->sides) {
      Eigen::Vector3d p_W;
      p_W << place.wanted(*stone, side), side.on_table.height;
      const double firmness = std::min(friction, side.on_table.margin / side.on_table.lever);
      list.push_back(proposal_of(*stone, side, place, side.R_W_O, p_W, side.on_table, firmness));
    }
  return list;
}

/// Best first, at most `keep`, and `per_stone` of each stone that are distinct.
std::vector<WallProposal> best_of_each(std::vector<WallProposal> list, std::size_t keep,
                                       std::size_t per_stone) {
  std::stable_sort(list.begin(), list.end(),
                   [](const WallProposal& p, const WallProposal& q) { return p.worth > q.worth; });
  std::vector<WallProposal> kept;
  for (WallProposal& next : list) {
    if (kept.size() == keep) break;
    std::size_t same = 0;
    bool known = false;
    for (const WallProposal& other : kept) {
      if (other.stone != next.stone) continue;
      ++same;
      known = known || !distinct(other.proposal.body, next.proposal.body);
    }
    if (same < per_stone && !known) kept.push_back(std::move(next));
  }
  return kept;
}

}  // namespace

WallProposals table_proposals(const SearchContext& context, const WallPlace& place,
                              const std::vector<const WallStone*>& stones) {
  WallProposals result;
  result.list =
      best_of_each(on_the_table(stones, place, context.options->friction), kRefinedInSlot, kPerStone);
  result.evaluated = static_cast<long>(result.list.size());
  return result;
}

WallProposals proposals_at(const SearchContext& context, const WallPlace& place,
                           const std::vector<const WallStone*>& stones) {
  const SearchOptions& o = *context.options;
  WallProposals result;
  SurfaceGrid grid;
  grid.cell = o.grid;
  grid.half = raster_half(context, grid.cell);
  grid.centre = place.centre;
  const StackField coarse = place.field(grid);
  struct Task {
    const WallStone* stone;
    const WallSide* side;
  };
  std::vector<Task> tasks;
  for (const WallStone* stone : stones)
    for (const WallSide& side : stone->sides) tasks.push_back({stone, &side});
  std::vector<std::optional<WallProposal>> found(tasks.size());
  std::vector<long> evaluated(tasks.size(), 0);
  run_tasks(o.threads, tasks.size(), [&](std::size_t k) {
    GapField buffer;
    found[k] = best_landing(coarse, *tasks[k].stone, *tasks[k].side, place, &buffer, &evaluated[k]);
  });
  std::vector<WallProposal> list;
  for (auto& made : found)
    if (made) list.push_back(*std::move(made));
  list = best_of_each(std::move(list), kRefinedInSlot, kPerStone);
  grid.cell = 0.5 * o.grid;
  grid.half = raster_half(context, grid.cell);
  const StackField fine = place.field(grid);
  std::vector<std::optional<WallProposal>> better(list.size());
  evaluated.resize(tasks.size() + list.size(), 0);
  run_tasks(o.threads, list.size(), [&](std::size_t k) {
    better[k] = refined_landing(fine, list[k], place, &evaluated[tasks.size() + k]);
  });
  for (auto& made : better)
    if (made && made->proposal.robust > 0.0) result.list.push_back(*std::move(made));
  result.list = best_of_each(std::move(result.list), kRefinedInSlot, kPerStone);
  for (const long count : evaluated) result.evaluated += count;
  return result;
}

WallProposals wall_proposals(const SearchContext& context, const WallState& state, const WallSlot& slot,
                             const std::vector<WallStone>& stones) {
  const std::vector<const WallStone*> left = stones_left(stones, state);
  WallPlace place;
  place.course = slot.course;
  place.wanted = [&](const WallStone&, const WallSide& side) { return wanted_place(slot, side); };
  place.worth = [&](const WallStonePlaced& placed, double firmness) {
    return worth_in_slot(slot, placed, firmness, context.options->friction);
  };
  if (slot.course == 0) return table_proposals(context, place, left);
  double half_length = 0.0;
  for (const WallStone* stone : left)
    half_length += 0.5 * (stone->sides.front().extents.max - stone->sides.front().extents.min).x() /
                   static_cast<double>(left.size());
  place.centre = {slot.centre ? *slot.centre : slot.from + half_length, 0.0};
  place.field = [&](const SurfaceGrid& grid) { return wall_field(context, state, slot, grid); };
  return proposals_at(context, place, left);
}

std::vector<const WallStone*> stones_left(const std::vector<WallStone>& stones, const WallState& state) {
  std::vector<const WallStone*> left;
  for (const WallStone& stone : stones)
    if (!state.holds(stone.stone)) left.push_back(&stone);
  return left;
}

}  // namespace stonestack::search
