#pragma once
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "rooms.hpp"
#include "stacking/state_file.hpp"

namespace stonestack::test {

/// A folder for the states of a run: below the folder that the environment names in STONESTACK_STATES (that
/// is how tests/data/states was made), else a temporary one.
inline std::string states_folder(const std::string& temporary, const std::string& name) {
  const char* kept = std::getenv("STONESTACK_STATES");
  std::string folder = (kept != nullptr ? std::string(kept) + "/" : temporary) + name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

/// Decisions of each saved state of a run, in order, without the cell: names of actions.
inline std::vector<std::string> decisions(const std::string& folder, const Catalogue& catalogue,
                                          const RobotModel& robot) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  std::optional<Models> models;
  std::vector<std::string> names;
  for (const std::string& file : files) {
    State state = read_state(file, catalogue);
    if (!models) models = make_models(catalogue, robot, CellLayout{}, state.options.wall);
    add_resting_stacks(*models, state.options, state.memory.friction, state.world);
    names.push_back(name_of(choose_action(state.world, state.memory, *models, state.options).action));
  }
  return names;
}

}  // namespace stonestack::test
