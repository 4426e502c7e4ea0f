// Coupled rigid-block analysis on published assemblies: verdict, margin and time beside those of the force
// method, growth with the number of blocks of a wall, and the tilt at which an assembly collapses beside the
// one that Bullet finds.
#include "structures.hpp"

#include <cmath>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <memory>

#include "physics/block_assembly.hpp"
#include "physics/shape.hpp"
#include "physics/world.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::bench {
namespace {

using namespace physics;

constexpr int kPushDirections = 16;
constexpr double kSimulatedSize = 0.1;    // m: largest block in simulation
constexpr double kSimulatedHeight = 3.0;  // m: above the world's table
constexpr double kMoved = 0.005;          // m: more is a fall

struct StructuresOptions {
  std::string folder = "../shared/assemblies";
  bool growth = false, tilt = false;
  int largest = 500, margin_blocks = 100;
};

/// An assembly with supports and friction as its publication sets it up.
struct Published {
  const char *file, *supports;
  double friction, tilt_deg;
  const char* verdict;
};

constexpr Published kPublished[] = {
    {"cra/A", "0,1", 0.84, 0, "falls"},
    {"cra/H", "0,1", 0.84, 0, "falls"},
    {"cra/armadillo", "", 0.84, 0, ""},
    {"cra/armadillo_cra", "", 0.84, 0, "stands"},
    {"cra/bridge", "0,1", 0.9, 0, "stands"},
    {"cra/concave-long", "0", 0.84, 50, "stands"},
    {"cra/concave-short", "0", 0.84, 40, "stands"},
    {"cra/cube-curve-short", "0", 0.84, 0, "stands"},
    {"cra/cube-curve-tall", "0", 0.84, 0, "stands"},
    {"cra/cubes", "0", 0.84, 0, "stands"},
    {"cra/curve-3-blocks", "0", 0.84, 0, "stands"},
    {"cra/shelf", "0", 0.9, 0, "falls"},
    {"cra/shelf-s1", "0", 0.9, 0, ""},
    {"cra/shelf-s2", "0", 0.9, 0, ""},
    {"cra/shelf-s3", "0", 0.9, 0, ""},
    {"cra/shelf-stable", "0", 0.9, 0, "stands"},
    {"cra/snake", "0", 0.7, 0, "stands"},
    {"cra/type-a", "0,1", 0.84, 0, ""},
    {"cra/type-b", "0,1", 0.84, 90, "stands"},
    {"cra/type-c", "0,1", 0.84, 0, ""},
    {"cra/type-d", "0,1", 0.84, 0, ""},
    {"arch_assembly", "", 0.7, 0, "stands"},
    {"wall_assembly", "", 0.84, 0, ""},
    {"stack_assembly", "", 0.84, 0, ""},
};

double cpu_ms() {
  return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

Eigen::Vector3d down_at(double degrees) {
  const double angle = degrees * M_PI / 180.0;
  return {-std::sin(angle), 0.0, -std::cos(angle)};
}

BlockAssembly read_published(const StructuresOptions& options, const Published& item) {
  BlockAssembly assembly = read_assembly(options.folder + "/" + item.file + ".json");
  const std::string supports = std::string(",") + item.supports + ",";
  bool any = false;
  for (AssemblyBlock& block : assembly.blocks) {
    block.support = block.support || supports.find("," + block.name + ",") != std::string::npos;
    any = any || block.support;
  }
  // armadillo names no supports: those of armadillo_cra, its twin
  if (!any) {
    const BlockAssembly twin = read_assembly(options.folder + "/" + item.file + "_cra.json");
    for (std::size_t i = 0; i < assembly.blocks.size(); ++i)
      assembly.blocks[i].support = twin.blocks[i].support;
  }
  if (std::string(item.file) == "cra/bridge")
    for (AssemblyBlock& block : assembly.blocks)
      if (std::stoi(block.name) >= 11) block.density = 3.51;
  return assembly;
}

Equilibrium by_forces(const AssemblyStatics& statics, double friction) {
  std::vector<Contact> contacts;
  for (const BlockContact& c : statics.contacts) contacts.push_back(c.contact);
  EquilibriumOptions options;
  options.friction = friction;
  options.directions = kPushDirections;
  options.min_friction = false;
  options.torque_arm = 0.5;
  return solve_equilibrium(statics.bodies, contacts, options);
}

std::vector<TableValue> sample_row(const StructuresOptions& options, const Published& item) {
  const double start = cpu_ms();
  BlockAssembly assembly = read_published(options, item);
  if (assembly.interfaces.empty()) assembly.interfaces = find_interfaces(assembly.blocks);
  const AssemblyStatics statics = statics_of(assembly);
  const double read = cpu_ms();
  const Eigen::Vector3d down = down_at(item.tilt_deg);
  const CoupledState state = CoupledSolver(statics.bodies, statics.contacts).solve(item.friction, down);
  const double solved = cpu_ms();
  TableValue margin, least, all, forces;
  if (static_cast<int>(statics.bodies.size()) <= options.margin_blocks) {
    const CoupledAnalysis found =
        analyse_coupled(statics.bodies, statics.contacts, item.friction, kPushDirections, down);
    all = cpu_ms() - solved;
    margin = found.margin;
    least = found.min_friction;
    if (item.tilt_deg == 0.0) forces = by_forces(statics, item.friction).stands ? "stands" : "falls";
  }
  return {item.file,
          *item.verdict ? TableValue(item.verdict) : TableValue(),
          state.stands ? "stands" : "falls",
          forces,
          margin,
          least,
          statics.contacts.size(),
          read - start,
          solved - read,
          all};
}

/// The rows of a table, one a draw; an empty one is left out.
template <class Row>
void add_rows(const std::string& name, std::size_t total, Results& results, Draws& draws, const Row& row) {
  for (const auto& cells : draws.outcomes(name, static_cast<int>(total), row))
    if (!cells.empty()) results.row(cells);
}

void samples(const StructuresOptions& options, Results& results, Draws& draws) {
  results.table("published assemblies", {{"assembly"},
                                         {"published"},
                                         {"coupled"},
                                         {"forces_alone"},
                                         {"margin_g", 3},
                                         {"min_friction", 3},
                                         {"contacts"},
                                         {"read_cpu_ms", 1},
                                         {"verdict_cpu_ms", 1},
                                         {"all_cpu_ms", 0}});
  add_rows("assembly", std::size(kPublished), results, draws,
           [&](int k) { return sample_row(options, kPublished[k]); });
}

/// Quarter bond of bricks 0.25 x 0.12 x 0.065 m, ten a row, on a fixed plinth.
BlockAssembly brick_wall(int bricks) {
  constexpr int kRow = 10;
  BlockAssembly wall;
  const auto add = [&](const Eigen::Vector3d& size, const Eigen::Vector3d& centre, bool support) {
    wall.blocks.push_back({std::to_string(wall.blocks.size()),
                           transformed(make_box(size), Pose(Eigen::Translation3d(centre))), support});
  };
  add({3.0, 0.3, 0.1}, {1.25, 0.0, -0.05}, true);
  for (int i = 0; i < bricks; ++i) {
    const int row = i / kRow;
    add({0.25, 0.12, 0.065}, {0.25 * (i % kRow) + (row % 2 == 1 ? 0.0625 : 0.0), 0.0, 0.065 * row + 0.0325},
        false);
  }
  wall.interfaces = find_interfaces(wall.blocks);
  return wall;
}

std::vector<TableValue> growth_row(const StructuresOptions& options, int bricks) {
  const double start = cpu_ms();
  const AssemblyStatics statics = statics_of(brick_wall(bricks));
  const double found = cpu_ms();
  const CoupledState state = CoupledSolver(statics.bodies, statics.contacts).solve(0.6, down_at(0.0));
  const double solved = cpu_ms();
  TableValue margin, all;
  if (bricks <= options.margin_blocks) {
    margin = analyse_coupled(statics.bodies, statics.contacts, 0.6, kPushDirections).margin;
    all = cpu_ms() - solved;
  }
  return {bricks, statics.contacts.size(), state.stands, found - start, solved - found, margin, all};
}

void growth(const StructuresOptions& options, Results& results, Draws& draws) {
  results.table("walls of bricks, friction 0.6", {{"bricks"},
                                                  {"contacts"},
                                                  {"stands"},
                                                  {"interfaces_cpu_ms", 1},
                                                  {"verdict_cpu_ms", 1},
                                                  {"margin_g", 3},
                                                  {"all_cpu_ms", 0}});
  std::vector<int> bricks{10, 20, 50, 100, 200, 500};
  std::erase_if(bricks, [&](int count) { return count > options.largest; });
  add_rows("wall", bricks.size(), results, draws,
           [&](int k) { return growth_row(options, bricks[static_cast<std::size_t>(k)]); });
}

/// Blocks that stay in Bullet for `seconds` under a tilted gravity.
class Simulated {
 public:
  explicit Simulated(const BlockAssembly& assembly) {
    double largest = 0.0;
    for (const AssemblyBlock& block : assembly.blocks)
      if (!block.support) largest = std::max(largest, bounds(block.mesh).sizes().maxCoeff());
    ShapeOptions coarse;  // contact is between features; the field only finds what lies deep
    coarse.cell = 0.003;
    coarse.spacing = 0.01;
    for (const AssemblyBlock& block : assembly.blocks) {
      const Mesh mesh = scaled(block.mesh, kSimulatedSize / largest);
      shapes_.push_back(
          make_contact_shape(mesh, mass_properties(mesh, 2600.0 * block.density), block.name, coarse));
      fixed_.push_back(block.support);
    }
  }
  [[nodiscard]] bool stands(double friction, double degrees, double seconds) const {
    WorldOptions options;
    options.friction = friction;
    options.iterations = 200;
    options.step = 0.001;
    World world(options);
    world.set_gravity(options.gravity * down_at(degrees));
    const Pose raised(Eigen::Translation3d(0.0, 0.0, kSimulatedHeight));
    for (std::size_t i = 0; i < shapes_.size(); ++i) world.add_stone(shapes_[i], raised, fixed_[i]);
    for (double t = 0.0; t < seconds; t += 0.1) {
      world.run(0.1);
      for (std::size_t i = 0; i < shapes_.size(); ++i) {
        const Eigen::Vector3d& p = shapes_[i]->mass.p_O_M;
        if ((world.pose(static_cast<int>(i)) * p - raised * p).norm() > kMoved) return false;
      }
    }
    return true;
  }

 private:
  ShapeList shapes_;
  std::vector<bool> fixed_;
};

/// Largest tilt [deg] from 0 that `stands` bears, to `step`; negative if none.
template <typename Stands>
double tilt_borne(double step, const Stands& stands) {
  double low = -step, high = 90.0;
  if (!stands(0.0)) return low;
  low = 0.0;
  while (high - low > step) {
    const double middle = 0.5 * (low + high);
    (stands(middle) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Empty for an assembly that does not stand as it is.
std::vector<TableValue> tilt_row(const StructuresOptions& options, const Published& item) {
  BlockAssembly assembly = read_published(options, item);
  if (assembly.interfaces.empty()) assembly.interfaces = find_interfaces(assembly.blocks);
  const AssemblyStatics statics = statics_of(assembly);
  CoupledSolver solver(statics.bodies, statics.contacts);
  const double coupled =
      tilt_borne(0.1, [&](double d) { return solver.solve(item.friction, down_at(d)).stands; });
  if (coupled < 0.0) return {};
  const Simulated world(assembly);
  const double simulated = tilt_borne(0.2, [&](double d) { return world.stands(item.friction, d, 1.5); });
  return {item.file, item.friction, coupled, simulated, simulated - coupled};
}

void tilt(const StructuresOptions& options, Results& results, Draws& draws) {
  results.table(
      "tilt about y at which assemblies collapse",
      {{"assembly"}, {"friction", 2}, {"coupled_deg", 1}, {"simulated_deg", 1}, {"difference_deg", 1}});
  std::vector<const Published*> items;
  for (const Published& item : kPublished) {
    const std::string file = item.file;
    if (file.find("armadillo") == std::string::npos && file.find("curve") == std::string::npos)
      items.push_back(&item);
  }
  add_rows("tilt", items.size(), results, draws,
           [&](int k) { return tilt_row(options, *items[static_cast<std::size_t>(k)]); });
}

void measure_structures(const StructuresOptions& options, Results& results, Draws& draws) {
  results.settings({{"directions", kPushDirections}, {"margin_blocks", options.margin_blocks}});
  if (options.growth) growth(options, results, draws);
  const bool there = std::filesystem::exists(options.folder);
  if (!there && !options.growth)
    throw FileError(options.folder, "is not there", "name the folder of the assemblies with --folder");
  if (there && options.tilt) tilt(options, results, draws);
  if (there && !options.tilt && !options.growth) samples(options, results, draws);
  throw_if_interrupted();
}

}  // namespace

void add_structures(CLI::App& app) {
  auto options = std::make_shared<StructuresOptions>();
  CLI::App* sub = app.add_subcommand("structures", "Coupled rigid-block analysis on published assemblies");
  sub->add_option("--folder", options->folder, "Assemblies of COMPAS")->capture_default_str();
  sub->add_flag("--growth", options->growth, "Walls of 10 to 500 bricks instead");
  sub->add_flag("--tilt", options->tilt, "Collapse by tilting instead, beside Bullet");
  sub->add_option("--largest", options->largest, "Bricks of the largest wall")->capture_default_str();
  sub->add_option("--margin-blocks", options->margin_blocks,
                  "Blocks up to which margin and friction are found")
      ->capture_default_str();
  sub->footer(
      "Examples:\n"
      "  stonestack-bench structures\n"
      "  stonestack-bench structures --growth\n"
      "  stonestack-bench structures --tilt");
  measure_draws_by(
      *sub, [options](Results& results, Draws& draws) { measure_structures(*options, results, draws); });
}

}  // namespace stonestack::bench
