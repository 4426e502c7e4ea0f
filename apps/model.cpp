#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "scene_input.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::apps {
namespace {

struct ModelCommand {
  Loudness loudness;
  SceneInputs inputs;
  ModelOrder order;
  bool exact_poses = false, json = false;
};

void model(ModelCommand& command) {
  command.loudness.apply();
  ModelOrder& order = command.order;
  order.views = depth_views_of(read_views(command.inputs));
  order.modelling.refine_poses = !command.exact_poses;
  const ModelledViews made = model_views(order);
  std::cout << (command.json ? modelled_json(made, order.catalogue) : modelled_table(made));
  if (made.stones.empty())
    throw Error(concat(command.inputs.paths.front(), ": no stone: ",
                       made.failed.empty() ? made.scene.segmentation.note : made.failed.front().error),
                ExitCode::kNothingDetected);
  if (!made.failed.empty())
    throw Error(
        concat(made.failed.size(), " objects could not be made a stone, see above; the others are stored"),
        ExitCode::kUnreadable);
}

}  // namespace

void add_model(CLI::App& app) {
  const auto [sub, command] = add_subcommand<ModelCommand>(
      app, "model", "Model the objects on a table from several views of them, as stones of a catalogue",
      model);
  register_scene_inputs(sub, command.inputs);
  add_path(sub, "--catalogue", command.order.catalogue, "Folder to store the stones in; made if missing",
           "DIR")
      ->required();
  sub.add_option("--prefix", command.order.prefix, "Names are PREFIX_1, PREFIX_2, ...")
      ->capture_default_str();
  register_stone_options(sub, command.order.stone);
  sub.add_flag("--exact-poses", command.exact_poses, "Take the cameras' poses as they are said to be");
  sub.add_flag("--force", command.order.force, "Replace stones that are in the catalogue already");
  sub.add_flag("--json", command.json, "Result as JSON on stdout");
  command.loudness.register_on(sub);
  sub.footer(
      "Examples:\n"
      "  stonestack model left/scene.yaml right/scene.yaml top/scene.yaml --catalogue rocks\n"
      "  stonestack model views/*.pcd --catalogue rocks --density 2700 --json");
}

}  // namespace stonestack::apps
