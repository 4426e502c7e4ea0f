#pragma once
#include <string>
#include <vector>

#include "ranks.hpp"

namespace stonestack::mpi {

/// A benchmark in parts, each of which `stonestack-bench ... --shard K/PARTS` performs in a process of its
/// own.
struct BenchOrder {
  std::string program;                 ///< path of stonestack-bench
  std::vector<std::string> arguments;  ///< its subcommand and options
  std::string out;                     ///< folder of the parts, which all ranks see
  int parts = 32;
  bool continues = false;  ///< perform what the folder lacks
  std::string record;      ///< where the merged tables are written; empty: nowhere
  bool json = false;       ///< the merged tables as JSON on stdout
};

/// Path of the stonestack-bench that lies beside this program.
[[nodiscard]] std::string own_bench();

/// Deals the parts to all ranks, merges them and prints the tables; on rank 0. A part that was begun goes on
/// with the draws that it lacks. Says on stderr which part has ended, unless `quiet`.
/// @throws InvalidArgument if the folder holds parts and none are to be continued, or another number of parts
/// @throws Error what a part or the merge reports; what was performed stays in the folder
void deal_parts(const Ranks& ranks, const BenchOrder& order, bool quiet);

/// Performs the parts that rank 0 deals to this rank, until there are none.
void perform_dealt_parts(const Ranks& ranks, const BenchOrder& order);

}  // namespace stonestack::mpi
