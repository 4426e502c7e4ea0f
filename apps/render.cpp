#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "geometry/pose_json.hpp"
#include "settings.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/simulation/render_scene.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::apps {
namespace {

constexpr double kDegree = 0.017453292519943295;

struct RenderCommand {
  std::string catalogue;  ///< empty: the stones that come with the project
  std::string out;
  std::vector<std::string> stones;
  bool json = false;
  bool quiet = false;
  double tilt_degrees = -1.0;  ///< negative: not given
  bool no_noise = false;
  SceneOptions options;
  Settings settings;
};

std::vector<int> present(const RenderCommand& command, const Catalogue& catalogue) {
  std::vector<int> indices;
  if (command.stones.empty())
    for (std::size_t i = 0; i < catalogue.stones.size(); ++i) indices.push_back(static_cast<int>(i));
  else
    for (const auto& name : command.stones) indices.push_back(catalogue.index(name));
  return indices;
}

void print_json(const SimulatedScene& scene, const Catalogue& catalogue, const RenderCommand& command) {
  nlohmann::json stones = nlohmann::json::array();
  for (const auto& placed : scene.stones)
    stones.push_back({{"stone", catalogue.stones[static_cast<std::size_t>(placed.stone)].name},
                      {"T_W_O", pose_json(placed.T_W_O)},
                      {"T_C_O", pose_json(scene.T_W_C.inverse() * placed.T_W_O)}});
  std::cout << nlohmann::json{{"schema", "stonestack.render/1"},         {"folder", command.out},
                              {"seed", command.options.simulation.seed}, {"T_W_C", pose_json(scene.T_W_C)},
                              {"depth_unit", scene.depth_unit},          {"stones", stones}}
                   .dump(2)
            << '\n';
}

void render(RenderCommand& command) {
  if (command.quiet) set_log_level(LogLevel::kWarning);
  command.settings.apply(
      join({nest("scene", fields(command.options)), nest("simulation", fields(command.options.simulation))}));
  if (command.tilt_degrees >= 0) command.options.tilt = command.tilt_degrees * kDegree;
  if (command.no_noise) command.options.simulation.sensor_noise = false;
  require_writable(command.out + "/scene.yaml");
  const Catalogue catalogue =
      read_catalogue(command.catalogue.empty() ? data_path("stones") : command.catalogue);
  const SimulatedScene scene =
      render_scene(catalogue.stones, present(command, catalogue), CellLayout{}, command.options);
  write_scene(command.out, scene, catalogue.stones);
  log_info("wrote depth.png, cloud.ply and scene.yaml to " + command.out);
  if (command.json) {
    print_json(scene, catalogue, command);
    return;
  }
  std::printf("%-20s   true position in the world (m)\n", "stone");
  for (const auto& placed : scene.stones) {
    const auto& p = placed.T_W_O.translation();
    std::printf("%-20s   %7.4f %7.4f %7.4f\n",
                catalogue.stones[static_cast<std::size_t>(placed.stone)].name.c_str(), p.x(), p.y(), p.z());
  }
}

}  // namespace

void add_render(CLI::App& app) {
  auto command = std::make_shared<RenderCommand>();
  CLI::App* sub = app.add_subcommand("render", "Write a simulated scene: depth image, cloud, ground truth");
  sub->add_option("--out", command->out, "Folder to write to; made if missing")->required()->type_name("DIR");
  sub->add_option("--stones", command->stones, "Stones to scatter, by name, comma-separated (default: all)")
      ->delimiter(',');
  command->settings.bind(
      sub->add_option("--distance", command->options.distance, "Camera to table along its axis, m")
          ->check(CLI::Range(0.2, 3.0))
          ->capture_default_str(),
      "scene.distance");
  sub->add_option("--tilt", command->tilt_degrees, "Camera off the vertical, degrees (default: 10)")
      ->check(CLI::Range(0.0, 80.0));
  command->settings.bind(
      sub->add_option("--sensor", command->options.simulation.sensor, "Depth camera to imitate")
          ->check(CLI::IsMember({"sr300", "d435", "ideal"}))
          ->capture_default_str(),
      "simulation.sensor");
  sub->add_flag("--no-noise", command->no_noise, "A perfect sensor of that kind");
  sub->add_option("--catalogue", command->catalogue, "Folder of stones (default: those that come with it)")
      ->type_name("DIR");
  command->settings.bind(sub->add_option("--seed", command->options.simulation.seed, "Same seed, same scene")
                             ->capture_default_str()
                             ->check(CLI::Range(0, 2147483647)),
                         "*.seed");
  sub->add_flag("--json", command->json, "Result as JSON on stdout");
  sub->add_flag("--quiet,-q", command->quiet, "Warnings and errors only on stderr");
  command->settings.register_on(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack render --out scene --seed 1\n"
      "  stonestack render --out scene --stones limestone_1,limestone_2 --distance 0.6 --tilt 30\n"
      "  stonestack detect scene/scene.yaml --json\n"
      "depth.png holds 16-bit counts of depth_unit metres; scene.yaml holds the camera and the true poses.");
  sub->callback([command] { render(*command); });
}

}  // namespace stonestack::apps
