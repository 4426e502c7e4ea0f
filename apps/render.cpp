#include <iostream>
#include <numbers>
#include <numeric>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::apps {
namespace {

struct RenderCommand {
  std::string catalogue;  ///< empty: the stones that come with the project
  std::string out;
  std::vector<std::string> stones;
  bool json = false;
  Loudness loudness;
  double tilt_degrees = -1.0;  ///< negative: not given
  bool no_noise = false;
  SceneOptions options;
  Settings settings;
};

void render(RenderCommand& command) {
  command.loudness.apply();
  SceneOptions& options = command.options;
  command.settings.apply(
      join({nest("scene", fields(options)), nest("simulation", fields(options.simulation))}));
  if (command.tilt_degrees >= 0) options.tilt = command.tilt_degrees * std::numbers::pi / 180;
  if (command.no_noise) options.simulation.sensor_noise = false;
  require_writable(command.out + "/scene.yaml");
  const Catalogue catalogue =
      read_catalogue(command.catalogue.empty() ? data_path("stones") : command.catalogue);
  std::vector<StoneIndex> present;
  for (const auto& name : command.stones) present.push_back(catalogue.index(name));
  if (present.empty()) present = first_stones(catalogue.stones.size());
  const SimulatedScene scene = render_scene(catalogue.stones, present, CellLayout{}, options);
  write_scene(command.out, scene, catalogue.stones);
  log_info("wrote depth.png, cloud.ply and scene.yaml to " + command.out);
  std::cout << (command.json ? scene_json(scene, catalogue, command.out, options.simulation.seed)
                             : scene_table(scene, catalogue));
}

}  // namespace

void add_render(CLI::App& app) {
  const auto [sub, command] = add_subcommand<RenderCommand>(
      app, "render", "Write a simulated scene: depth image, cloud, ground truth", render);
  SimulationOptions& simulation = command.options.simulation;
  add_path(sub, "--out", command.out, "Folder to write to; made if missing", "DIR")->required();
  sub.add_option("--stones", command.stones, "Stones to scatter, by name, comma-separated (default: all)")
      ->delimiter(',');
  command.settings.bind(
      sub.add_option("--distance", command.options.distance, "Camera to table along its axis, m")
          ->check(CLI::Range(0.2, 3.0))
          ->capture_default_str(),
      "scene.distance");
  sub.add_option("--tilt", command.tilt_degrees, "Camera off the vertical, degrees (default: 10)")
      ->check(CLI::Range(0.0, 80.0));
  command.settings.bind(
      sub.add_option("--sensor", simulation.sensor,
                     "Depth camera to imitate: sr300, d435, d415, l515, xtion, kinect1, azure, "
                     "f200, ideal or a file (docs/formats.md, Sensors)")
          ->capture_default_str(),
      "simulation.sensor");
  sub.add_flag("--no-noise", command.no_noise, "A perfect sensor of that kind");
  add_path(sub, "--catalogue", command.catalogue, "Folder of stones (default: those that come with it)",
           "DIR");
  command.settings.bind(sub.add_option("--seed", simulation.seed, "Same seed, same scene")
                            ->capture_default_str()
                            ->check(CLI::Range(0, 2147483647)),
                        "*.seed");
  sub.add_flag("--json", command.json, "Result as JSON on stdout");
  command.loudness.register_on(sub);
  command.settings.register_on(sub);
  sub.footer(
      "Examples:\n"
      "  stonestack render --out scene --seed 1\n"
      "  stonestack render --out scene --stones limestone_1,limestone_2 --distance 0.6 --tilt 30\n"
      "  stonestack detect scene/scene.yaml --json\n"
      "depth.png holds 16-bit counts of depth_unit metres; scene.yaml holds the camera and the true poses.");
}

}  // namespace stonestack::apps
