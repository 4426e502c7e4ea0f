#include "stone_draws.hpp"

#include <algorithm>
#include <filesystem>

#include "physics/shape.hpp"
#include "stone/file_units.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/geometry/mesh.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "stonestack/stone/model_stone.hpp"

namespace stonestack::bench {
namespace {

constexpr int kFirstLimestone = 1000;            // seed
constexpr double kBoulder = 0.4, kMetres = 4.0;  // a scan between them, in its unit, is a boulder in metres,
constexpr double kBoulderScale = 0.12;           // made so much smaller (shared/stones/README.md)

Stone stone_of(const std::string& name, const Mesh& scan) {
  Stone stone;
  stone.name = name;
  const Eigen::Vector3d p_com = mass_properties(scan, stone.density).p_O_M;
  stone.scan = transformed(scan, make_pose(Eigen::Vector3d(-p_com)));
  stone.mass = mass_properties(stone.scan, stone.density);
  return stone;
}

std::vector<Stone> read_scans(const std::string& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".obj") files.push_back(entry.path());
  if (files.empty())
    throw FileError(folder, "holds no OBJ file", "name the folder of the scans with --scans");
  std::sort(files.begin(), files.end());
  std::vector<Stone> stones;
  for (const auto& file : files) {
    const Mesh mesh = read_mesh(file.string());
    Eigen::AlignedBox3d box;
    for (const auto& v : mesh.vertices) box.extend(v);
    const double longest = box.sizes().maxCoeff();
    const bool boulder = longest > kBoulder && longest < kMetres;
    const double scale =
        boulder ? kBoulderScale : file_scale(longest, "auto", 1.0, file.string()).metres_per_unit;
    stones.push_back(stone_of(file.stem().string(), scaled(mesh, scale)));
  }
  return stones;
}

std::vector<Stone> make_limestones(int count) {
  std::vector<Stone> stones;
  LimestoneOptions shape;
  shape.faces = 2000;
  for (int k = 0; k < count; ++k)
    stones.push_back(stone_of(concat("limestone_", k),
                              make_limestone(static_cast<std::uint64_t>(kFirstLimestone + k), shape)));
  return stones;
}

}  // namespace

void PoolOptions::register_on(CLI::App& command) {
  command.add_option("--generated", generated, "Draw from so many generated limestones; 0: none")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command
      .add_option("--scans", scans, "Draw from the OBJ scans of this folder; skipped when it is not there")
      ->type_name("DIR")
      ->capture_default_str();
  command.add_option("--catalogue", catalogue, "Draw from this catalogue too")->type_name("DIR");
}

std::vector<StonePool> read_pool_stones(const PoolOptions& options) {
  std::vector<StonePool> pools;
  if (options.generated > 0) pools.push_back({"generated", make_limestones(options.generated), {}, {}});
  if (std::filesystem::is_directory(options.scans))
    pools.push_back({"scans", read_scans(options.scans), {}, {}});
  if (!options.catalogue.empty())
    pools.push_back({options.catalogue, read_catalogue(options.catalogue).stones, {}, {}});
  require(!pools.empty(), "no stones to draw from; give --generated, --scans or --catalogue");
  return pools;
}

std::vector<StonePool> read_pools(const PoolOptions& options) {
  std::vector<StonePool> pools = read_pool_stones(options);
  ShapeOptions finer;
  finer.cell = 0.001;
  finer.spacing = 0.002;
  for (StonePool& pool : pools) {
    pool.shapes = make_contact_shapes(pool.stones);
    pool.fine = make_contact_shapes(pool.stones, finer);
  }
  return pools;
}

std::vector<StonePool> read_pools(const PoolOptions& options, const Draws& draws) {
  return draws.performs() ? read_pools(options) : read_pool_stones(options);
}

SearchProblem draw_problem(const StonePool& pool, int seed, int k, int count) {
  Random random = Random::stream(static_cast<std::uint64_t>(seed), static_cast<std::uint64_t>(k));
  std::vector<StoneIndex> order = first_stones(pool.shapes.size());
  random.shuffle(order.begin(), order.end());
  order.resize(std::min(order.size(), static_cast<std::size_t>(count)));
  SearchProblem problem;
  problem.shapes = &pool.shapes;
  for (const StoneIndex stone : order)
    problem.available.push_back({stone, make_pose(Eigen::Vector3d(0.5, 0, 0.1), random.rotation())});
  return problem;
}

}  // namespace stonestack::bench
