#include "stonestack/report/record_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "experiment/clustered_count.hpp"
#include "report/csv.hpp"
#include "report/text.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

// Paper §4.2, eleven runs of four stones.
constexpr std::array<int, 5> kPaperHeights{0, 0, 3, 6, 2};
constexpr double kPaperRun = 271.0;          // s
constexpr double kPaperManipulation = 0.61;  // share of it

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
  const auto counts = heights(experiment), by_paper = paper_heights(experiment);
  std::string text = "height     runs   by the paper's protocol   paper's 11\n";
  for (int h = static_cast<int>(counts.size()) - 1; h >= 0; --h) {
    const int count = counts[static_cast<std::size_t>(h)];
    const bool in_paper = experiment.per_run == 4 && h < static_cast<int>(kPaperHeights.size());
    text += format("%6d %8d   %23d   %6s  ", h, count, by_paper[static_cast<std::size_t>(h)],
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
    ClusteredCount count;
    for (const auto& run : experiment.runs)
      count.add(run.report, standing(run) >= run.report.result.height && run.report.result.height > 0);
    return count.rate();
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
  return {{"hits", rate.hits}, {"trials", rate.trials}, {"share", rate.share()},
          {"low", rate.low()}, {"high", rate.high()},   {"stone_sets", rate.clusters}};
}

/// Mean height by `height`, and the share of whole towers.
std::string height_lines(const Experiment& experiment) {
  double sum = 0.0, by_paper = 0.0;
  for (const auto& run : experiment.runs) {
    sum += judged_height(run);
    by_paper += paper_height(run.report);
  }
  const auto n = std::max<double>(1.0, static_cast<double>(experiment.runs.size()));
  const int all = experiment.per_run;
  return format("mean height %.2f; by the paper's protocol %.2f (paper 2.91)\n", sum / n, by_paper / n) +
         format("towers of %d: ", all) + percent(reached(experiment, all)) +
         format("\n  by the paper's protocol (no placement failed before): ") +
         percent(reached_by_paper(experiment, all)) +
         format("\nsets of stones: %d; intervals count runs of one set as a cluster\n\n",
                stone_sets(experiment));
}

/// Towers on which the engines do not agree.
std::string disagreement_lines(const Experiment& experiment) {
  std::string text;
  int judged = 0, differ = 0;
  for (const auto& run : experiment.runs) {
    if (!run.report.truth || run.report.truth->engines.empty()) continue;
    ++judged;
    if (!engines_disagree(*run.report.truth)) continue;
    ++differ;
    text += format("  run %d:", run.number);
    for (const auto& verdict : run.report.truth->engines)
      text += format(" %s %d of %d", verdict.engine.c_str(), verdict.height, run.report.result.height) +
              (verdict.note.empty() ? "" : " (" + verdict.note + ")") + ";";
    text.back() = '\n';
  }
  if (judged == 0) return "";
  return format("towers on which the engines disagree (they count as far as both let them stand): %d of %d\n",
                differ, judged) +
         text + "\n";
}

}  // namespace

std::string title_of(const Experiment& experiment) {
  if (experiment.shard.count == 1) return experiment.title;
  return experiment.title + ", shard " + to_text(experiment.shard);
}

std::string experiment_table(const Experiment& experiment) {
  std::string text = title_of(experiment) + format(" (%zu done)", experiment.runs.size()) + "\n\n" +
                     histogram(experiment) + "\n";
  text += height_lines(experiment) + disagreement_lines(experiment);
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
  for (const auto& run : experiment.runs) {
    const auto& r = run.report.result;
    text += format("run %3d  seed %-8d height %d%s  robot %5.1f s, detection %4.1f s, search %5.1f s  ",
                   run.number, run.report.seed, judged_height(run),
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
    entry["run"] = run.number;
    entry["judged_height"] = judged_height(run);
    entry["paper_height"] = paper_height(run.report);
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
              {"seed", experiment.seed},
              {"total", experiment.total},
              {"shard", {{"index", experiment.shard.index}, {"count", experiment.shard.count}}},
              {"stones", experiment.stones},
              {"protocol", experiment.protocol},
              {"per_run", experiment.per_run},
              {"new_stones", experiment.new_stones},
              {"new_stones_from", experiment.new_stones_from},
              {"stone_sets", stone_sets(experiment)},
              {"heights", heights(experiment)},
              {"whole", rate_json(reached(experiment, experiment.per_run))},
              {"by_paper_protocol",
               {{"heights", paper_heights(experiment)},
                {"whole", rate_json(reached_by_paper(experiment, experiment.per_run))}}},
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
      "run,seed,stones,height,reported,paper_height,end,motion_s,detection_s,search_s,planning_s,"
      "beside_motion_s\n";
  for (const auto& run : experiment.runs) {
    std::string stones;
    for (const auto& name : run.report.present) stones += (stones.empty() ? "" : " ") + name;
    const auto& r = run.report.result;
    text += format("%d,%d,", run.number, run.report.seed) + csv_field(stones) +
            format(",%d,%d,%d,", judged_height(run), r.height, paper_height(run.report)) +
            csv_field(r.ended) +
            format(",%.1f,%.2f,%.2f,%.2f,%.2f\n", r.seconds.motion, r.seconds.detection, r.seconds.search,
                   r.seconds.planning, r.seconds.beside_motion);
  }
  return text;
}

}  // namespace stonestack::report
