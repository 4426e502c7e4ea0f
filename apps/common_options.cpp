#include "common_options.hpp"

#include <algorithm>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/motion/planning_scene.hpp"

namespace stonestack::apps {

void CommonOptions::register_draw(CLI::App& command) {
  command
      .add_option("--catalogue", catalogue, "Folder of stones (default: the six that come with stonestack)")
      ->type_name("DIR");
  settings.bind(command.add_option("--seed", seed, "Same seed, same result")
                    ->capture_default_str()
                    ->check(CLI::Range(0, 2147483647)),
                "*.seed");
  settings.register_on(command);
}

void CommonOptions::register_on(CLI::App& command) {
  register_draw(command);
  command.add_flag("--json", json, "Result as JSON on stdout");
  command.add_flag("--quiet,-q", quiet, "Warnings and errors only on stderr");
}

void CommonOptions::begin() const {
  if (quiet) set_log_level(LogLevel::kWarning);
}

Catalogue CommonOptions::read() const {
  return read_catalogue(catalogue.empty() ? data_path("stones") : catalogue);
}

void require_stones(const Catalogue& catalogue, int count, const CLI::Option* asked) {
  const auto all = static_cast<int>(catalogue.stones.size());
  require(count <= all || asked == nullptr || asked->count() == 0, "--per-run ", count, ": ", catalogue.path,
          " has ", all, " stones");
}

std::vector<int> draw_stones(const Catalogue& catalogue, int count, int seed, const GripperModel& gripper,
                             const RobotModel& robot) {
  std::vector<int> order(catalogue.stones.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  Random::stream(static_cast<std::uint64_t>(seed), "stones of the run").shuffle(order.begin(), order.end());
  std::string unfit;
  std::erase_if(order, [&](int k) {
    const Stone& stone = catalogue.stones[static_cast<std::size_t>(k)];
    const std::string why = unfit_for_gripper(stone, gripper, robot);
    if (!why.empty()) unfit += concat(unfit.empty() ? "" : ", ", stone.name, " (", why, ")");
    return !why.empty();
  });
  if (order.empty())
    throw Error("no stone of the catalogue can be carried: " + unfit, ExitCode::kExecutionFailed);
  if (!unfit.empty()) log_info("not drawn, for hand or arm cannot hold them: " + unfit);
  order.resize(std::min(order.size(), static_cast<std::size_t>(count)));
  std::sort(order.begin(), order.end());
  return order;
}

}  // namespace stonestack::apps
