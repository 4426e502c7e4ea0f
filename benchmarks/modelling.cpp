// Measures the models that the arm's camera makes of stones that nobody scanned, in the simulated cell: how
// far their surfaces lie from the true ones, what of them was seen, and how long the robot took.
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "bench.hpp"
#include "common_options.hpp"
#include "core/constants.hpp"
#include "core/quantile.hpp"
#include "experiment/new_stones.hpp"
#include "geometry/small_motion.hpp"
#include "geometry/surface_tree.hpp"
#include "simulation/true_shape.hpp"
#include "stacking/model_field.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/simulation/simulated_cell.hpp"

namespace stonestack::bench {
namespace {

constexpr int kAlignSteps = 30;
constexpr double kOtherSide = 0.35;   // rad between two attitudes on different sides
constexpr double kSamePlace = 0.02;   // m between where a stone is and where its model says
constexpr double kUnderside = 0.010;  // m above the table: what other stones are stood on
constexpr double kGate = 0.006;       // m between surfaces that are brought together to compare them
constexpr double kBump = 0.008;       // m around a vertex, within which others tell what errors are smooth

/// Brings `from` to lie on `onto` (iterated closest points, point to plane), from a pose near it.
Pose aligned(const Mesh& from, const SurfaceTree& onto, Pose T_onto_from) {
  for (int step = 0; step < kAlignSteps; ++step) {
    Eigen::Matrix<double, 6, 6> H = 1e-9 * Eigen::Matrix<double, 6, 6>::Identity();
    Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
    const double gate = step < kAlignSteps / 2 ? 3.0 * kGate : kGate;
    for (const auto& vertex : from.vertices) {
      const Eigen::Vector3d p = T_onto_from * vertex;
      const SurfacePoint near = onto.nearest(p, gate);
      if (near.face < 0) continue;
      Eigen::Matrix<double, 6, 1> J;
      J << near.normal, p.cross(near.normal);
      H += J * J.transpose();
      g += near.normal.dot(p - near.point) * J;
    }
    const Eigen::Matrix<double, 6, 1> x = -H.ldlt().solve(g);
    T_onto_from = orthonormal(small_motion(x) * T_onto_from);
  }
  return T_onto_from;
}

/// Distances of two surfaces from each other, in both directions [m].
std::vector<double> distances(const Mesh& model, const Mesh& truth, const Pose& T_true_model) {
  const SurfaceTree onto(truth), back(model);
  std::vector<double> all;
  for (const auto& sample : sample_surface(model, 0.003))
    all.push_back(std::abs(onto.nearest(T_true_model * sample.point).distance));
  const Pose T_model_true = T_true_model.inverse();
  for (const auto& sample : sample_surface(truth, 0.003))
    all.push_back(std::abs(back.nearest(T_model_true * sample.point).distance));
  return all;
}

struct ModellingCommand {
  CommonOptions common;
  int runs = 10, stones = 4;
  std::string rocks;
  SimulationOptions simulation;
  stacking::ModelFieldOptions options;
};

/// Sums over all runs.
struct ModellingTally {
  int wanted = 0, modelled = 0, lies_otherwise = 0, turned = 0, placed = 0, within = 0, stopped = 0,
      foreign = 0;
  std::vector<double> median, worst, seconds, host;
  std::vector<double> of_seen, of_unseen, of_underside;  ///< errors over the model's standard deviations
  std::vector<double> below;  ///< distances of the true surface outside of what was completed [m]
  std::vector<double> bumps;  ///< errors of what was seen against the mean around them [m]
};

double root_mean_square(const std::vector<double>& list) {
  double sum = 0.0;
  for (const double value : list) sum += value * value;
  return list.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(list.size()));
}

/// Adds the errors of seen vertices against the mean error of those around them: bumps that the stone has
/// not.
void add_bumps(const std::vector<Eigen::Vector3d>& vertices, const std::vector<double>& errors,
               ModellingTally& tally) {
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    double sum = 0.0, count = 0.0;
    for (std::size_t w = 0; w < vertices.size(); ++w) {
      if ((vertices[v] - vertices[w]).squaredNorm() > kBump * kBump) continue;
      sum += errors[w];
      ++count;
    }
    tally.bumps.push_back(errors[v] - sum / count);
  }
}

/// Compares the errors of a model with what it says of them. `T_true_model` brings it onto the true surface.
void compare_uncertainty(const Stone& model, const SurfaceTree& truth, const Pose& T_true_model,
                         ModellingTally& tally) {
  if (!model.surface || model.surface->up_O_at_rest.empty()) return;
  const Eigen::Vector3d& up_O = model.surface->up_O_at_rest.front();
  double lowest = 1e9;
  for (const auto& p : model.scan.vertices) lowest = std::min(lowest, up_O.dot(p));
  std::vector<Eigen::Vector3d> seen;
  std::vector<double> seen_errors;
  for (std::size_t v = 0; v < model.scan.vertices.size(); ++v) {
    const Eigen::Vector3d& p = model.scan.vertices[v];
    const double error = -truth.nearest(T_true_model * p).distance;
    const double ratio = error / model.surface->sigma[v];
    (model.surface->seen[v] != 0 ? tally.of_seen : tally.of_unseen).push_back(ratio);
    if (model.surface->seen[v] != 0) {
      seen.push_back(p);
      seen_errors.push_back(error);
      continue;
    }
    tally.below.push_back(error);
    if (up_O.dot(p) - lowest < kUnderside) tally.of_underside.push_back(ratio);
  }
  add_bumps(seen, seen_errors, tally);
}

void model_run(const ModellingCommand& command, std::uint64_t seed, const std::vector<Stone>& stones,
               const RobotModel& robot, ModellingTally& tally, Results& results) {
  SimulationOptions simulation = command.simulation;
  simulation.seed = static_cast<int>(seed);
  std::vector<StoneIndex> present = first_stones(stones.size());
  CellLayout layout;
  layout.linkage = simulation.linkage;  // as `run` does for a named cell
  SimulatedCell world(stones, present, robot, layout, simulation);
  const std::vector<Pose> T_W_O_first = world.truth().T_W_O;
  Cell cell = world.cell();
  const Stopwatch watch;
  stacking::ModelFieldOptions options = command.options;
  options.motion.seed = options.modelling.segment.seed = static_cast<int>(seed);
  stacking::ModelledField field;
  tally.wanted += static_cast<int>(present.size());
  try {
    field = stacking::model_field(cell, robot, options);
  } catch (const DeviceError& problem) {
    field.stopped = problem.what();
  }
  if (!field.stopped.empty()) {
    ++tally.stopped;
    log_warning(concat("seed ", seed, ": ", field.stopped));
  }
  const double host = watch.seconds();
  const std::vector<Stone> truth = simulation::as_they_are(stones, simulation);
  const std::vector<Pose> T_W_O = world.truth().T_W_O;
  tally.seconds.push_back(field.seconds / std::max<std::size_t>(1, field.stones.size()));
  tally.host.push_back(host);
  for (std::size_t k = 0; k < field.stones.size(); ++k) {
    const auto& made = field.stones[k];
    // The stones first, then the objects that are in no catalogue.
    const bool from_first = made.T_W_O_first.has_value();
    const Pose T_W_model = from_first ? *made.T_W_O_first : made.T_W_O.value_or(Pose::Identity());
    const std::vector<Pose>& lay = from_first ? T_W_O_first : T_W_O;
    const auto nearest = std::min_element(lay.begin(), lay.end(), [&](const Pose& a, const Pose& b) {
      return (a.translation() - T_W_model.translation()).norm() <
             (b.translation() - T_W_model.translation()).norm();
    });
    const auto index = static_cast<std::size_t>(nearest - lay.begin());
    if (index >= truth.size()) {
      ++tally.foreign;
      continue;
    }
    const Stone& is = truth[index];
    const Mesh& model = field.catalogue.stones[k].scan;
    const SurfaceTree surface(is.scan);
    const Pose T_true_model = aligned(model, surface, nearest->inverse() * T_W_model);
    const std::vector<double> off = distances(model, is.scan, T_true_model);
    const double median = quantile(off, 0.5), most = quantile(off, 0.95);
    const double volume_error = volume(model) / volume(is.scan) - 1.0;
    compare_uncertainty(field.catalogue.stones[k], surface, T_true_model, tally);
    ++tally.modelled;
    tally.turned += made.turned ? 1 : 0;
    const Eigen::Vector3d up_O = T_W_O_first[index].linear().transpose() * Eigen::Vector3d::UnitZ();
    const double tilt = std::acos(std::clamp((T_W_O[index].linear() * up_O).z(), -1.0, 1.0));
    tally.lies_otherwise += tilt > kOtherSide ? 1 : 0;
    tally.placed +=
        made.T_W_O && (made.T_W_O->translation() - T_W_O[index].translation()).norm() < kSamePlace;
    tally.within += median <= 0.0007 && most <= 0.002 ? 1 : 0;
    tally.median.push_back(median);
    tally.worst.push_back(most);
    results.row({seed, is.name, made.views, tilt / kDegree, made.turned ? 1 : 0, 100.0 * made.seen_share,
                 1e3 * median, 1e3 * most, 1e3 * made.sigma, 100.0 * volume_error, 1e3 * field.apart_before,
                 1e3 * field.apart_after, made.note});
  }
  for (const auto& left : field.left_out) log_info(left);
}

void measure_modelling(const ModellingCommand& command, Results& results) {
  const RobotModel robot = read_robot("ur10");
  const experiment::NewStones source(command.stones, command.rocks, static_cast<int>(command.common.seed),
                                     robot);
  ModellingTally tally;
  results.table("models", {{"seed"},
                           {"stone"},
                           {"views"},
                           {"tilted_deg", 0},
                           {"turned"},
                           {"seen_percent", 0},
                           {"median_mm", 2},
                           {"p95_mm", 2},
                           {"sigma_mm", 2},
                           {"volume_percent", 1},
                           {"apart_before_mm", 2},
                           {"apart_mm", 2},
                           {"note"}});
  for (int run = 0; run < command.runs; ++run) {
    const auto seed = command.common.seed + static_cast<std::uint64_t>(run);
    const Catalogue drawn = source.of_run(run + 1, static_cast<int>(seed));
    model_run(command, seed, drawn.stones, robot, tally, results);
  }
  results.table("all", {{"stones"},
                        {"modelled"},
                        {"lie_otherwise"},
                        {"turned"},
                        {"where_said"},
                        {"within_marks"},
                        {"runs_stopped"},
                        {"foreign"},
                        {"median_mm", 2},
                        {"p95_mm", 2},
                        {"seen_errors_over_sigma", 2},
                        {"unseen_errors_over_sigma", 2},
                        {"underside_errors_over_sigma", 2},
                        {"unseen_outside_mm", 2},
                        {"bumps_mm", 2},
                        {"robot_seconds_a_stone", 0},
                        {"host_seconds_a_run", 0}});
  const auto mid = [](const std::vector<double>& list) { return list.empty() ? 0.0 : quantile(list, 0.5); };
  results.row({tally.wanted, tally.modelled, tally.lies_otherwise, tally.turned, tally.placed, tally.within,
               tally.stopped, tally.foreign, 1e3 * mid(tally.median), 1e3 * mid(tally.worst),
               root_mean_square(tally.of_seen), root_mean_square(tally.of_unseen),
               root_mean_square(tally.of_underside), 1e3 * mid(tally.below),
               1e3 * root_mean_square(tally.bumps), mid(tally.seconds), mid(tally.host)});
}

}  // namespace

void add_modelling(CLI::App& app) {
  auto command = std::make_shared<ModellingCommand>();
  CLI::App* sub = app.add_subcommand(
      "modelling", "Models made by the arm's camera of stones that nobody scanned, against the true stones");
  sub->add_option("--runs", command->runs, "Cells")->check(CLI::Range(1, 10000))->capture_default_str();
  sub->add_option("--stones", command->stones, "A cell")->check(CLI::Range(1, 12))->capture_default_str();
  sub->add_option("--rocks", command->rocks,
                  "Draw the stones of every cell from this folder (default: new limestones)")
      ->type_name("DIR");
  sub->add_option("--first-views", command->options.first_views, "Views of the stones as they lie")
      ->check(CLI::Range(1, 20))
      ->capture_default_str();
  sub->add_option("--turned-views", command->options.turned_views,
                  "Views once they are turned; 0: none is turned")
      ->check(CLI::Range(0, 20))
      ->capture_default_str();
  command->common.register_draw(*sub);
  command->common.loudness.register_on(*sub);
  sub->footer("Example:\n  stonestack-bench modelling --runs 20 --set simulation.cell=lab");
  measure_by(*sub, [command](Results& results) {
    command->common.begin();
    command->common.settings.apply(join({nest("simulation", fields(command->simulation)),
                                         nest("modelling", fields(command->options.modelling))}));
    results.settings({{"runs", command->runs},
                      {"stones", command->stones},
                      {"first_views", command->options.first_views},
                      {"turned_views", command->options.turned_views}});
    measure_modelling(*command, results);
  });
}

}  // namespace stonestack::bench
