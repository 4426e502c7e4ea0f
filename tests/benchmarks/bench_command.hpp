#pragma once
#include <string>

#include "apps/commands.hpp"
#include "benchmarks/rooms.hpp"

namespace stonestack::bench {

/// `stonestack-bench` as a user runs it, in a folder of its own.
class BenchCommand : public Commands {
 protected:
  BenchCommand() { program_ = STONESTACK_BENCH; }

  [[nodiscard]] Outcome run_stonestack(const std::string& arguments) const {
    return shell(concat("cd ", folder_, " && ", STONESTACK_BINARY, " ", arguments, " 2>err"));
  }
};

/// The rows of a table of a result; null if there is none of that name.
[[nodiscard]] inline json rows_of(const json& result, const std::string& table) {
  for (const json& one : result["tables"])
    if (one["name"] == table) return one["rows"];
  return nullptr;
}

}  // namespace stonestack::bench
