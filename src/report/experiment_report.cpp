#include "stonestack/report/experiment_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "report/csv.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/report/run_report.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

// Paper §4.2, eleven runs of four stones.
constexpr std::array<int, 5> kPaperHeights{0, 0, 3, 6, 2};
constexpr double kPaperRun = 271.0;          // s
constexpr double kPaperManipulation = 0.61;  // share of it

/// Printf-style text for the tables.
template <class... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 512> buffer{};
  std::snprintf(buffer.data(), buffer.size(), pattern, values...);
  return buffer.data();
}

std::string percent(const Rate& rate) {
  return format("%5.1f %% (%d of %d; 95 %%: %.0f to %.0f)", 100 * rate.share(), rate.hits, rate.trials,
                100 * rate.low(), 100 * rate.high());
}

bool held(const PlacementRecord& record) {
  return record.outcome == PlacementRecord::Outcome::kPlaced;
}

/// Means over the runs, s.
StageSeconds mean_seconds(const Experiment& experiment) {
  StageSeconds mean;
  const auto n = static_cast<double>(std::max<std::size_t>(1, experiment.runs.size()));
  for (const auto& run : experiment.runs) {
    const auto& s = run.report.result.seconds;
    mean.detection += s.detection / n;
    mean.search += s.search / n;
    mean.planning += s.planning / n;
    mean.motion += s.motion / n;
    mean.beside_motion += s.beside_motion / n;
  }
  return mean;
}

/// Mean cost of placements that held and of those that failed.
std::string cost_line(const Experiment& experiment) {
  std::array<double, 2> sum{};
  std::array<int, 2> count{};
  for (const auto& run : experiment.runs)
    for (const auto& record : run.report.result.placements) {
      if (!was_tried(record)) continue;
      const std::size_t kind = held(record) ? 0 : 1;
      sum[kind] += record.planned.cost;
      ++count[kind];
    }
  std::string text =
      format("cost: %.2f in the mean of %d placements that held", sum[0] / std::max(1, count[0]), count[0]);
  if (count[1] > 0) text += format(", %.2f of %d that failed", sum[1] / count[1], count[1]);
  return text + " (paper: failed ones 2.5 times dearer)\n";
}

std::string histogram(const Experiment& experiment) {
  const auto counts = heights(experiment);
  std::string text = "height     runs   paper's 11\n";
  for (int h = static_cast<int>(counts.size()) - 1; h >= 0; --h) {
    const int count = counts[static_cast<std::size_t>(h)];
    const bool in_paper = experiment.per_run == 4 && h < static_cast<int>(kPaperHeights.size());
    text += format("%6d %8d   %6s  ", h, count,
                   in_paper ? std::to_string(kPaperHeights[static_cast<std::size_t>(h)]).c_str() : "");
    text += std::string(static_cast<std::size_t>(std::min(60, count)), '#') + "\n";
  }
  return text;
}

std::string survival_lines(const Experiment& experiment) {
  if (std::all_of(experiment.runs.begin(), experiment.runs.end(),
                  [](const ExperimentRun& run) { return run.survival.standing.empty(); }))
    return "survival was not tried\n";
  std::string text;
  const auto whole = [&](const auto& standing) {
    Rate rate;
    for (const auto& run : experiment.runs) {
      ++rate.trials;
      rate.hits += standing(run) >= run.report.result.height && run.report.result.height > 0 ? 1 : 0;
    }
    return rate;
  };
  for (std::size_t k = 0; k < experiment.survival_seconds.size(); ++k)
    text += format("towers that stand whole after %4.0f s: ", experiment.survival_seconds[k]) +
            percent(whole([&](const ExperimentRun& run) {
              return k < run.survival.standing.size() ? run.survival.standing[k] : 0;
            })) +
            "\n";
  return text + "towers left whole by the shake (2 m/s^2, 2.4 Hz, 0.7 s, along x and y): " +
         percent(whole([](const ExperimentRun& run) { return run.survival.shaken; })) + "\n";
}

std::string calibration_lines(const Experiment& experiment) {
  std::string text = "predicted success   mean   observed\n";
  for (const auto& bin : calibration(experiment)) {
    if (bin.observed.trials == 0) continue;
    text += format("%.1f to %.1f          %5.2f  ", bin.low, bin.high, bin.mean_prediction) +
            percent(bin.observed) + "\n";
  }
  return text;
}

json rate_json(const Rate& rate) {
  return {{"hits", rate.hits},
          {"trials", rate.trials},
          {"share", rate.share()},
          {"low", rate.low()},
          {"high", rate.high()}};
}

}  // namespace

std::string experiment_table(const Experiment& experiment) {
  std::string text = experiment.title + format(" (%zu done)", experiment.runs.size()) + "\n\n" +
                     histogram(experiment) + "\n";
  double sum = 0.0;
  for (const auto& run : experiment.runs) sum += judged_height(run);
  text += format("mean height %.2f (paper 2.91)\n",
                 sum / std::max<double>(1.0, static_cast<double>(experiment.runs.size())));
  text += format("towers of %d: ", experiment.per_run) + percent(reached(experiment, experiment.per_run)) +
          "\n\n";
  const StageSeconds s = mean_seconds(experiment);
  text += format(
      "seconds a run        here    paper\n  detection, search %7.1f  %7.1f  (with everything but "
      "manipulation; host)\n",
      s.detection + s.search, kPaperRun * (1 - kPaperManipulation));
  text +=
      format("  motion planning   %7.1f        -  (host)\n  manipulation      %7.1f  %7.1f  (robot time)\n",
             s.planning, s.motion, kPaperRun * kPaperManipulation);
  text +=
      format("  whole run         %7.1f  %7.1f\n", s.detection + s.search + s.planning + s.motion, kPaperRun);
  text += format("  detection and search while the arm moved, not in these: %.1f\n\n", s.beside_motion);
  text += survival_lines(experiment) + "\n" + calibration_lines(experiment) + cost_line(experiment) + "\n";
  int number = 0;
  for (const auto& run : experiment.runs) {
    const auto& r = run.report.result;
    text += format("run %3d  seed %-8d height %d%s  robot %5.1f s, detection %4.1f s, search %5.1f s  ",
                   ++number, run.report.seed, judged_height(run),
                   judged_height(run) < r.height ? format(" (reported %d!)", r.height).c_str() : "",
                   r.seconds.motion, r.seconds.detection, r.seconds.search) +
            r.ended + "\n";
  }
  return text;
}

std::string experiment_json(const Experiment& experiment) {
  json runs = json::array();
  for (const auto& run : experiment.runs) {
    json entry = json::parse(run_json(run.report));
    entry["judged_height"] = judged_height(run);
    entry["survival"] = {{"seconds", experiment.survival_seconds},
                         {"standing", run.survival.standing},
                         {"after_shake", run.survival.shaken}};
    runs.push_back(entry);
  }
  json bins = json::array();
  for (const auto& bin : calibration(experiment))
    bins.push_back({{"low", bin.low},
                    {"high", bin.high},
                    {"mean_prediction", bin.mean_prediction},
                    {"observed", rate_json(bin.observed)}});
  const StageSeconds s = mean_seconds(experiment);
  return json{{"schema", "stonestack.experiment/1"},
              {"title", experiment.title},
              {"per_run", experiment.per_run},
              {"heights", heights(experiment)},
              {"whole", rate_json(reached(experiment, experiment.per_run))},
              {"calibration", bins},
              {"seconds",
               {{"detection", s.detection},
                {"search", s.search},
                {"planning", s.planning},
                {"motion", s.motion},
                {"beside_motion", s.beside_motion}}},
              {"runs", runs}}
             .dump(2) +
         "\n";
}

std::string runs_csv(const Experiment& experiment) {
  std::string text =
      "run,seed,stones,height,reported,end,motion_s,detection_s,search_s,planning_s,beside_motion_s\n";
  int number = 0;
  for (const auto& run : experiment.runs) {
    std::string stones;
    for (const auto& name : run.report.present) stones += (stones.empty() ? "" : " ") + name;
    const auto& r = run.report.result;
    text += format("%d,%d,", ++number, run.report.seed) + csv_field(stones) +
            format(",%d,%d,", judged_height(run), r.height) + csv_field(r.ended) +
            format(",%.1f,%.2f,%.2f,%.2f,%.2f\n", r.seconds.motion, r.seconds.detection, r.seconds.search,
                   r.seconds.planning, r.seconds.beside_motion);
  }
  return text;
}

}  // namespace stonestack::report
