#include "search_row.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "stonestack/core/error.hpp"

namespace stonestack::bench {

void print_search_header() {
  std::printf("%-10s %-8s %6s %10s %8s %14s %11s %9s   %s\n", "stones", "method", "draws", "mean clean",
              "whole", "whole, margin", "CPU s each", "wall s", "heights");
}

void print_search_row(const SearchRow& row, const std::vector<SearchOutcome>& outcomes) {
  std::map<int, int> clean;
  double sum = 0.0, cpu = 0.0, wall = 0.0;
  int whole = 0, firm = 0;
  for (const SearchOutcome& outcome : outcomes) {
    ++clean[outcome.clean];
    sum += outcome.clean;
    cpu += outcome.cpu;
    wall += outcome.wall;
    whole += outcome.clean == row.stones ? 1 : 0;
    firm += outcome.clean == row.stones && outcome.margin >= row.least_margin ? 1 : 0;
  }
  const auto n = static_cast<double>(outcomes.size());
  std::string heights;
  for (const auto& [height, count] : clean) heights += concat(heights.empty() ? "" : " ", height, ":", count);
  std::printf("%-10s %-8s %6d %10.2f %6.0f %% %12.0f %% %11.1f %9.1f   %s\n", row.pool.c_str(),
              row.method.c_str(), static_cast<int>(outcomes.size()), sum / n, 100 * whole / n, 100 * firm / n,
              cpu / n, wall / n, heights.c_str());
  if (row.ode) {
    int planned = 0, standing = 0;
    for (const SearchOutcome& outcome : outcomes) {
      if (outcome.clean != row.stones) continue;
      ++planned;
      standing += outcome.ode.standing == row.stones ? 1 : 0;
    }
    const OdeOptions& o = row.in_ode;
    std::printf(
        "%-10s %-8s of %d whole towers %d stand in ODE for %g s within %g mm and %.3g deg (step %g ms)\n",
        row.pool.c_str(), row.method.c_str(), planned, standing, o.seconds, 1e3 * o.largest_shift,
        o.largest_turn * 180 / M_PI, 1e3 * o.step);
  }
  std::fflush(stdout);
}

void print_paper_time(const std::string& pool, const std::vector<SearchOutcome>& outcomes) {
  constexpr double kPaperRun = 106.0;    // s: 39 % of 271.0 s (paper section 4.2)
  constexpr double kPaperStones = 2.91;  // mean height of its eleven runs
  double seconds = 0.0;
  int stones = 0;
  for (const SearchOutcome& outcome : outcomes) {
    seconds += outcome.once;
    stones += outcome.once_planned;
  }
  std::printf(
      "%-10s paper    one pass: %.1f s of search a run, %.1f s a stone; in the paper: %.0f s a run of "
      "detection and search, %.0f s a stone\n",
      pool.c_str(), seconds / static_cast<double>(outcomes.size()), seconds / std::max(1, stones), kPaperRun,
      kPaperRun / kPaperStones);
}

void tell_draw(const SearchRow& row, int draw, const SearchOutcome& outcome) {
  std::string ode;
  if (row.ode)
    ode = concat(", ODE ", outcome.ode.standing, " (", 1e3 * outcome.ode.shift, " mm, ",
                 outcome.ode.turn * 180 / M_PI, " deg)");
  std::fprintf(stderr, "%s draw %d: planned %d, clean %d, margin %.3f g, CPU %.1f s%s%s%s\n",
               row.method.c_str(), draw, outcome.planned, outcome.clean, outcome.margin, outcome.cpu,
               ode.c_str(), outcome.reason.empty() ? "" : "; ", outcome.reason.c_str());
}

}  // namespace stonestack::bench
