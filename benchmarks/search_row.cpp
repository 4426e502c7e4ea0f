#include "search_row.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "stonestack/core/error.hpp"

namespace stonestack::bench {

std::vector<Column> search_columns(bool ode) {
  std::vector<Column> columns{{"stones"},
                              {"method"},
                              {"draws"},
                              {"mean_clean"},
                              {"whole_percent", 0},
                              {"whole_with_margin_percent", 0},
                              {"whole_after_shake_percent", 0},
                              {"cpu_s_each", 1},
                              {"wall_s_each", 1}};
  if (ode) columns.push_back({"whole_that_stand_in_ode"});
  columns.push_back({"heights"});
  return columns;
}

std::vector<TableValue> search_cells(const SearchRow& row, const std::vector<SearchOutcome>& outcomes) {
  std::map<int, int> clean;
  double sum = 0.0, cpu = 0.0, wall = 0.0;
  int whole = 0, firm = 0, shaken = 0, in_ode = 0;
  for (const SearchOutcome& outcome : outcomes) {
    ++clean[outcome.clean];
    sum += outcome.clean;
    cpu += outcome.cpu;
    wall += outcome.wall;
    if (outcome.clean != row.stones) continue;
    ++whole;
    firm += outcome.margin >= row.min_margin ? 1 : 0;
    shaken += outcome.shaken == row.stones ? 1 : 0;
    in_ode += outcome.ode.standing == row.stones ? 1 : 0;
  }
  const auto n = static_cast<double>(outcomes.size());
  std::string heights;
  for (const auto& [height, count] : clean) heights += concat(heights.empty() ? "" : " ", height, ":", count);
  std::vector<TableValue> cells{row.pool,       row.method,       outcomes.size(), sum / n, 100 * whole / n,
                                100 * firm / n, 100 * shaken / n, cpu / n,         wall / n};
  if (row.ode) cells.emplace_back(in_ode);
  cells.emplace_back(heights);
  return cells;
}

void report_paper_time(const std::string& pool, const std::vector<SearchOutcome>& outcomes,
                       Results& results) {
  constexpr double kPaperRun = 106.0;    // s: 39 % of 271.0 s (paper section 4.2)
  constexpr double kPaperStones = 2.91;  // mean height of its eleven runs
  double seconds = 0.0;
  int stones = 0;
  for (const SearchOutcome& outcome : outcomes) {
    seconds += outcome.once;
    stones += outcome.once_planned;
  }
  results.row({pool, seconds / static_cast<double>(outcomes.size()), seconds / std::max(1, stones), kPaperRun,
               kPaperRun / kPaperStones});
}

void report_draw(const SearchRow& row, int draw, const SearchOutcome& outcome) {
  std::string ode;
  if (row.ode)
    ode = concat(", ODE ", outcome.ode.standing, " (", 1e3 * outcome.ode.shift, " mm, ",
                 outcome.ode.turn * 180 / M_PI, " deg)");
  std::fprintf(stderr, "%s draw %d: planned %d, clean %d, margin %.3f g, shaken %d, CPU %.1f s%s%s%s\n",
               row.method.c_str(), draw, outcome.planned, outcome.clean, outcome.margin, outcome.shaken,
               outcome.cpu, ode.c_str(), outcome.reason.empty() ? "" : "; ", outcome.reason.c_str());
}

}  // namespace stonestack::bench
