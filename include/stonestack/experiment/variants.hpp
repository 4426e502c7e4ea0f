#pragma once
#include <string>
#include <vector>

#include "stonestack/experiment/simulated_run.hpp"

#pragma GCC visibility push(default)

/// The rows of a comparison of experiments.
namespace stonestack::experiment {

/// One row of a comparison: the experiment with some options set differently.
struct Variant {
  std::string name;
  std::vector<std::string> assignments;
};

/// Each way in which the cell is hard, alone, against all of them and none of them.
[[nodiscard]] std::vector<Variant> cell_variants();
/// Each part of the design taken away, alone.
[[nodiscard]] std::vector<Variant> design_variants();
/// "name: option=value, option=value".
/// @throws InvalidArgument
[[nodiscard]] Variant parse_variant(const std::string& text);

/// Throws InvalidArgument, before anything is built, for an option of a variant that there is not, and for a
/// seed that the runs of an experiment would not have: `run` are the settings of all, `seed` the
/// experiment's.
void check_variants(const std::vector<Variant>& variants, const SimulatedRun& run, int seed);

}  // namespace stonestack::experiment

#pragma GCC visibility pop
