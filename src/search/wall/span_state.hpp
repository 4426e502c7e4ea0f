#pragma once
#include <span>

#include "search/wall/wall_state.hpp"

namespace stonestack::search {

/// Where a stone crosses the x axis of the structure, seen from above, how high it is there, and from where
/// to where along x it stands on the table, itself or by what it rests on [m].
struct AxisCrossing {
  double from = 0.0, to = 0.0;
  double top = 0.0;
  double ground_from = 0.0, ground_to = 0.0;
};
/// Of each stone of a state; empty where it lies beside the axis.
using Crossings = std::vector<std::optional<AxisCrossing>>;
/// @param contacts of the state's stones, indices into them
[[nodiscard]] Crossings axis_crossings(const SearchContext& context, const WallState& state,
                                       std::span<const Contact> contacts);
/// By the contacts of the stones as they stand.
[[nodiscard]] Crossings axis_crossings(const SearchContext& context, const WallState& state);

/// An end of the part of a span over which nothing lies yet.
struct SpanEnd {
  bool wanted = true;  ///< something can stand on this side
  int stone = -1;      ///< of the state, that reaches furthest from this side; -1: none is high enough yet
  double x = 0.0;      ///< as far as it reaches [m]
  double top = 0.0;    ///< its height at the axis [m]
};
/// The part of a span over which nothing lies yet.
struct OpenSpan {
  bool closed = false;
  SpanEnd left, right;
  [[nodiscard]] double length() const { return closed ? 0.0 : right.x - left.x; }
};
/// A span is closed where stones lie over all of it that stand on both sides, as far as anything may stand
/// there.
/// @param reach length of a usual stone: how far beyond a missing end the next one is taken to be [m]
[[nodiscard]] OpenSpan open_span(const SpanTask& task, const Span& span, const Crossings& crossings,
                                 double reach);

/// How far a stone reaches into what is kept clear in one of the spans [m].
[[nodiscard]] double in_the_way(const SearchContext& context, std::span<const Span> spans,
                                const WallStonePlaced& placed);

/// Does a stone lie where the task wants one to be carried: with its centre of mass within 30 mm of it, none
/// upon it, and the spans closed without it?
[[nodiscard]] bool carries(const SearchContext& context, const SpanTask& task, const WallState& state);
/// Is the task done? Stones that were measured may seem to reach 5 mm into what is kept clear.
[[nodiscard]] bool is_done(const SearchContext& context, const SpanTask& task, const WallState& state);

/// Figures of a structure that does a task, without its supports. Nothing of a span counts in which a stone
/// stands.
/// @param supports stones at the head of the state that are supports of the task
[[nodiscard]] WallMetrics span_metrics(const SearchContext& context, const SpanTask& task,
                                       const WallState& state, std::size_t supports);

}  // namespace stonestack::search
