#pragma once
#include <string>
#include <vector>

/// The rows of a comparison of experiments.
namespace stonestack::apps {

/// One row of a comparison: the experiment with some options set differently.
struct Variant {
  std::string name;
  std::vector<std::string> assignments;
};

/// Each way in which the cell is hard, alone, against all of them and none of them.
[[nodiscard]] std::vector<Variant> cell_variants();
/// Each part of the design taken away, alone.
[[nodiscard]] std::vector<Variant> design_variants();
/// "name: option=value, option=value". Throws InvalidArgument.
[[nodiscard]] Variant parse_variant(const std::string& text);

}  // namespace stonestack::apps
