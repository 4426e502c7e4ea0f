#pragma once
#include "search/proposals.hpp"
#include "stonestack/core/clock.hpp"

namespace stonestack::search {

/// A search problem that was checked, with what every stage needs.
struct SearchContext {
  const SearchProblem* problem = nullptr;
  const SearchOptions* options = nullptr;
  std::vector<StoneGeometry> geometry;  ///< one for each shape
  /// Of the loose stones, for each list of SearchProblem::possible_shapes; empty where that has no shape
  std::vector<std::vector<StoneGeometry>> possible_geometry;
  Stack stack;                         ///< as it stands after a check, perhaps a little moved
  std::vector<PlacedStone> available;  ///< without the stones of the stack
  bool tower = true;                   ///< a stone touches those next to it in the stack alone; false: a wall
  Stopwatch watch;
  std::function<void(const std::string&)> report;

  [[nodiscard]] const ShapeList& shapes() const { return *problem->shapes; }
  /// Finished towers are shaken.
  [[nodiscard]] bool firm() const { return options->objective == "firm"; }
  [[nodiscard]] bool out_of_time() const {
    return time_is_over() || (options->budget > 0.0 && watch.seconds() >= options->budget);
  }
  void log(const std::string& line) const {
    if (report) report(line);
  }
};
/// For a problem that was checked; it and the options must outlive the context.
[[nodiscard]] SearchContext make_context(const SearchProblem& problem, const SearchOptions& options,
                                         const std::function<void(const std::string&)>& report);
/// The stack's bodies, bottom first.
[[nodiscard]] std::vector<BodyPose> bodies_of(const SearchContext& context, const Stack& stack);
/// Indices of a stack's stones, bottom first.
[[nodiscard]] std::vector<StoneIndex> stones_of(const Stack& stack);
/// True for a stone that may have other shapes than its model.
[[nodiscard]] bool is_known_in_part(const SearchProblem& problem, StoneIndex stone);
/// The loose stones with every orientation that the tilt limit allows.
[[nodiscard]] std::vector<LooseStone> loose_stones(const SearchContext& context);

/// Why nothing, or no more, was found where `budget` ended the search.
inline constexpr const char* kTimeOver = "the time was over before a pose was found";
/// Why a search was interrupted before it found anything: the time, or the user.
[[nodiscard]] inline const char* why_interrupted() {
  return time_is_over() ? kTimeOver : "interrupted before a pose was found";
}
/// Motion in 0.1 s [m] below which a stone is at rest in a verdict (10 um in 10 s).
inline constexpr double kStill = 1e-7;
/// The step of the search's verdicts, as good as finer ones (docs/measurements.md, Contact) [s].
inline constexpr double kVerdictStep = 1.0 / 480.0;

/// Throws InvalidArgument for options that cannot be.
void check_options(const SearchOptions& options);
/// Throws InvalidArgument for stones and options that cannot be.
void check_problem(const SearchProblem& problem, const SearchOptions& options);
/// A stack as it comes to rest.
struct StandingStack {
  std::optional<Stack> stack;
  std::string reason;  ///< why it does not stand, if it is empty
};
/// The stack as it comes to rest, if it stands as given (exactly where it moves by less than 0.1 mm and
/// 2 mrad); else the stack that results when each stone in turn is let down from just above its given pose,
/// provided that it ends near there (5 mm, 5 deg) and stands; else empty with the reason. Measured poses are
/// off by a millimetre: a tower measured so may not stand exactly, or hover above its contacts.
/// @param tower each stone touches those next to it alone; false: a wall, the lower stones first
[[nodiscard]] StandingStack settled_stack(const ShapeList& shapes, const Stack& stack,
                                          const SearchOptions& options, bool tower = true);

}  // namespace stonestack::search
