#pragma once
// What `stonestack-bench search` reports of each draw and of a row of them.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ode_witness.hpp"
#include "result_table.hpp"
#include "rooms.hpp"

namespace stonestack::bench {

/// The outcome of one draw.
struct SearchOutcome {
  int planned = 0;
  int clean = 0;                 // stones that stay, each upon the one below it only
  double cpu = 0.0, wall = 0.0;  // s
  double margin = 0.0;           // g, of the planned tower
  int shaken = 0;                // stones that stand after a shake
  double once = 0.0;             // s of wall clock, of paper mode's first pass
  int once_planned = 0;          // stones in it
  OdeVerdict ode;
  std::string reason;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SearchOutcome, planned, clean, cpu, wall, margin, shaken, once,
                                   once_planned, ode, reason)

/// A row of the table: which stones, which method, and how towers were asked for and judged.
struct SearchRow {
  std::string pool;          // name of the stones
  std::string method;        // default or paper
  int stones = 4;            // asked for
  double min_margin = 0.02;  // g
  bool ode = false;          // judged in the other engine, too
  OdeOptions in_ode;
};

/// Columns of the table of searches; `ode` adds how many towers stand in the other engine.
[[nodiscard]] std::vector<Column> search_columns(bool ode);
[[nodiscard]] std::vector<TableValue> search_cells(const SearchRow& row,
                                                   const std::vector<SearchOutcome>& outcomes);

/// The time of one pass of paper mode beside what the paper took for detection and search.
void report_paper_time(const std::string& pool, const std::vector<SearchOutcome>& outcomes, Results& results);

/// One draw, as a line of stderr.
void report_draw(const SearchRow& row, int draw, const SearchOutcome& outcome);

}  // namespace stonestack::bench
