#include <algorithm>
#include <cmath>

#include "report/csv.hpp"
#include "report/svg.hpp"
#include "stonestack/report/record_run.hpp"

namespace stonestack::report {
namespace {

constexpr double kWidth = 720, kHeight = 440, kLeft = 64, kRight = 150, kTop = 28, kBottom = 52;

/// One selected pose.
struct Point {
  int level = 1;
  double cost = 0.0;
  bool held = true;
  std::string stone;
};

/// The level a stone was meant for is one above what then stood; an attempt after a fall, or after stones
/// were unstacked, starts lower again. Older records do not contain it: there, a stone that is handled again
/// had come off, with all above it.
std::vector<Point> points(const ExperimentRun& run) {
  using Outcome = PlacementRecord::Outcome;
  std::vector<Point> list;
  std::vector<std::string> standing;
  for (const auto& record : run.report.result.placements) {
    if (record.outcome == Outcome::kNotPicked) continue;
    standing.erase(std::find(standing.begin(), standing.end(), record.stone), standing.end());
    if (!was_tried(record)) continue;
    const int level = record.level > 0 ? record.level : static_cast<int>(standing.size()) + 1;
    list.push_back({level, record.planned.cost, record.outcome == Outcome::kPlaced, record.stone});
    if (record.outcome == Outcome::kPlaced || record.outcome == Outcome::kMoved)
      standing.push_back(record.stone);
  }
  return list;
}

/// Colours far apart for any number of runs: golden-angle hues.
std::string colour(std::size_t run) {
  return format("hsl(%.0f,62%%,%d%%)", std::fmod(137.508 * static_cast<double>(run), 360.0),
                38 + 8 * static_cast<int>(run % 3));
}

/// From data to the drawing.
struct Scale {
  double levels = 4, cost = 1;
  [[nodiscard]] double x(double level) const {
    return kLeft + (kWidth - kLeft - kRight) * (level - 0.5) / levels;
  }
  [[nodiscard]] double y(double value) const {
    return kHeight - kBottom - (kHeight - kTop - kBottom) * std::min(value, cost) / cost;
  }
};

std::string axes(const Scale& scale) {
  std::string text;
  const double step = tick(scale.cost);
  for (double v = 0; v <= scale.cost + 1e-9; v += step)
    text += format(
        "<line x1='%.0f' x2='%.0f' y1='%.1f' y2='%.1f' stroke='#ddd'/>"
        "<text x='%.0f' y='%.1f' text-anchor='end'>%g</text>\n",
        kLeft, kWidth - kRight, scale.y(v), scale.y(v), kLeft - 8, scale.y(v) + 4, v);
  for (int level = 1; level <= static_cast<int>(scale.levels); ++level)
    text += format("<text x='%.1f' y='%.0f' text-anchor='middle'>%d</text>\n", scale.x(level),
                   kHeight - kBottom + 20, level);
  text += format("<text x='%.0f' y='%.0f' text-anchor='middle'>level</text>", (kLeft + kWidth - kRight) / 2,
                 kHeight - 10);
  return text + format(
                    "<text transform='translate(16 %.0f) rotate(-90)' text-anchor='middle'>cost of the "
                    "selected pose, eq. (2)</text>\n",
                    (kTop + kHeight - kBottom) / 2);
}

std::string mark(double x, double y, bool held, const std::string& paint) {
  if (held)
    return format("<circle cx='%.1f' cy='%.1f' r='5' fill='none' stroke='%s' stroke-width='2'/>", x, y,
                  paint.c_str());
  return format("<path d='M%.1f %.1fl10 10m0 -10l-10 10' stroke='%s' stroke-width='2.5'/>", x - 5, y - 5,
                paint.c_str());
}

std::string draw_run(const Scale& scale, const ExperimentRun& run, std::size_t number, std::size_t runs) {
  const std::string paint = colour(number);
  // Runs stand a little beside each other within a level.
  const double aside = 0.5 * (static_cast<double>(number) + 0.5) / static_cast<double>(runs) - 0.25;
  std::string line, marks;
  for (const auto& point : points(run)) {
    const double x = scale.x(point.level + aside), y = scale.y(point.cost);
    line += format("%s%.1f %.1f", line.empty() ? "M" : "L", x, y);
    marks += mark(x, y, point.held, paint) + "\n";
  }
  return "<path d='" + line + "' fill='none' stroke='" + paint + "' stroke-opacity='0.45'/>\n" + marks;
}

std::string legend(const Experiment& experiment) {
  constexpr std::size_t kMax = 22;
  std::string text = mark(kWidth - kRight + 22, kTop + 4, true, "#444") +
                     format("<text x='%.0f' y='%.0f'>held</text>", kWidth - kRight + 34, kTop + 8) +
                     mark(kWidth - kRight + 82, kTop + 4, false, "#444") +
                     format("<text x='%.0f' y='%.0f'>failed</text>\n", kWidth - kRight + 94, kTop + 8);
  for (std::size_t i = 0; i < std::min(kMax, experiment.runs.size()); ++i)
    text += format("<text x='%.0f' y='%.0f' fill='%s'>run %d: %d</text>\n", kWidth - kRight + 18,
                   kTop + 30 + 15.5 * static_cast<double>(i), colour(i).c_str(), experiment.runs[i].number,
                   judged_height(experiment.runs[i]));
  return text;
}

}  // namespace

std::string figure5_csv(const Experiment& experiment) {
  std::string text = "run,seed,level,stone,cost,held\n";
  for (const auto& run : experiment.runs) {
    for (const auto& point : points(run))
      text += format("%d,%d,%d,", run.number, run.report.seed, point.level) + csv_field(point.stone) +
              format(",%.6g,%d\n", point.cost, point.held ? 1 : 0);
  }
  return text;
}

std::string figure5_svg(const Experiment& experiment) {
  Scale scale;
  scale.levels = experiment.per_run;
  scale.cost = 0.1;
  for (const auto& run : experiment.runs)
    for (const auto& point : points(run)) {
      scale.cost = std::max(scale.cost, 1.05 * point.cost);
      scale.levels = std::max(scale.levels, static_cast<double>(point.level));
    }
  std::string text = format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %.0f %.0f' font-family='sans-serif' "
      "font-size='12' fill='#333'>\n<rect width='100%%' height='100%%' fill='white'/>\n",
      kWidth, kHeight);
  text += axes(scale);
  for (std::size_t i = 0; i < experiment.runs.size(); ++i)
    text += draw_run(scale, experiment.runs[i], i, experiment.runs.size());
  return text + legend(experiment) + "</svg>\n";
}

}  // namespace stonestack::report
