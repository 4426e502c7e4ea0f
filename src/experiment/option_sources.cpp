#include "stonestack/experiment/option_sources.hpp"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::experiment {
namespace {

/// search.theta_init -> STONESTACK_SEARCH_THETA_INIT
std::string environment_name(const std::string& field) {
  std::string name = "STONESTACK_";
  for (const char c : field)
    name += c == '.' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

std::string user_file() {
  if (const char* home = std::getenv("XDG_CONFIG_HOME")) return std::string(home) + "/stonestack/config.yaml";
  if (const char* home = std::getenv("HOME")) return std::string(home) + "/.config/stonestack/config.yaml";
  return "";
}

std::vector<std::string> values(const FieldList& list) {
  std::vector<std::string> texts;
  for (const auto& field : list) texts.push_back(field_text(field));
  return texts;
}

/// One option that a named set sets.
struct NamedValue {
  std::string source;              ///< option that names the set: detection.method, simulation.cell
  std::string name, value, plain;  ///< `plain`: without it
  bool operator==(const NamedValue&) const = default;
};

/// The options of `group` that the set named by `source` in `list` stands for, as far as they are not the
/// defaults; none if `list` does not have `source`.
template <class Options>
void add_named_set(std::vector<NamedValue>& set, const FieldList& list, const std::string& group,
                   const std::string& source, Options (*options_of_name)(const std::string&)) {
  const std::string whole = group + "." + source;
  const auto named = std::find_if(list.begin(), list.end(), [&](const Field& f) { return f.name == whole; });
  if (named == list.end()) return;
  Options plain, meant = options_of_name(field_text(*named));
  const FieldList before = nest(group, fields(plain)), after = nest(group, fields(meant));
  for (std::size_t i = 0; i < after.size(); ++i)
    if (after[i].name != whole && field_text(before[i]) != field_text(after[i]))
      set.push_back({whole, after[i].name, field_text(after[i]), field_text(before[i])});
}

/// The gripper that plans count on in a cell: one with the linkage that the cell has by its name, whatever
/// simulation.linkage says.
void add_gripper_of_cell(std::vector<NamedValue>& set, const FieldList& list) {
  const auto named = [&](const std::string& name) {
    return std::find_if(list.begin(), list.end(), [&](const Field& f) { return f.name == name; });
  };
  const auto cell = named("simulation.cell"), linkage = named("gripper.linkage");
  if (cell == list.end() || linkage == list.end()) return;
  const std::string plain = BuildOptions{}.linkage, meant = options_of_cell(field_text(*cell)).linkage;
  if (meant != plain) set.push_back({cell->name, linkage->name, meant, plain});
}

/// The options that detection.method and simulation.cell stand for.
std::vector<NamedValue> named_sets(const FieldList& list) {
  std::vector<NamedValue> set;
  add_named_set<DetectionOptions>(set, list, "detection", "method", detection::options_of);
  add_named_set<SimulationOptions>(set, list, "simulation", "cell", simulation::options_of_cell);
  add_gripper_of_cell(set, list);
  return set;
}

/// Warns of variables that look like options and are none. A warning only: the environment is shared with
/// other programs.
void warn_of_unknown_variables(const FieldList& list) {
  EveryOption every;
  std::vector<std::string> known{"STONESTACK_DATA"};
  for (const FieldList& fields_of : {list, fields(every)})
    for (const Field& field : fields_of) known.push_back(environment_name(field.name));
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry, name = text.substr(0, text.find('='));
    if (!name.starts_with("STONESTACK_") || std::find(known.begin(), known.end(), name) != known.end())
      continue;
    const auto meant = likely_meant(known, name);
    log_warning(concat("environment variable ", name, " sets no option of this command",
                       meant.empty() ? "" : "; did you mean " + meant.front() + "?"));
  }
}

/// Takes the option from its environment variable and returns that one's name, if there is one.
std::optional<std::string> apply_environment(const FieldList& list, const std::string& option) {
  const std::string name = environment_name(option);
  const char* value = std::getenv(name.c_str());
  if (value == nullptr) return {};
  try {
    set_field(list, option + "=" + value);
  } catch (const InvalidArgument& problem) {
    throw InvalidArgument(concat("environment variable ", name, ": ", problem.what()));
  }
  return name;
}

void apply_file(const FieldList& list, const std::string& path, const std::string& kind,
                OptionOrigins& origins) {
  const auto before = values(list);
  EveryOption others;
  read_fields(list, path, fields(others));
  const auto after = values(list);
  for (std::size_t i = 0; i < list.size(); ++i)
    if (before[i] != after[i]) origins[list[i].name] = kind + " " + path;
}

bool is_meant(const FlagValue& flag, const std::string& option) {
  if (flag.option == "*.seed") return option == "seed" || option.ends_with(".seed");
  return option == flag.option;
}

/// Refuses an option of another command; its name is spelled well.
void check_command_has(const FieldList& list, const std::string& name) {
  const auto knows = [&](const FieldList& some) {
    return std::any_of(some.begin(), some.end(), [&](const Field& f) { return f.name == name; });
  };
  EveryOption every;
  require(knows(list) || !knows(fields(every)), "this command has no option ", name,
          "; `stonestack config show --expert` lists those of all commands");
}

/// Applies the sources once, the strongest last.
void apply_all(const FieldList& list, const OptionSources& sources, OptionOrigins& origins) {
  const std::string user = user_file(), project = "stonestack.yaml";
  if (!user.empty() && std::filesystem::exists(user)) apply_file(list, user, "user file", origins);
  if (!sources.config.empty())
    apply_file(list, sources.config, "file", origins);
  else if (std::filesystem::exists(project))
    apply_file(list, project, "project file", origins);
  for (const auto& field : list)
    if (const auto name = apply_environment(list, field.name)) origins[field.name] = "environment " + *name;
  for (const FlagValue& flag : sources.flags)
    for (const auto& field : list) {
      if (!is_meant(flag, field.name)) continue;
      set_field(list, field.name + "=" + flag.value);
      origins[field.name] = "flag " + flag.flag;
    }
  for (const auto& assignment : sources.assignments) {
    const std::string name = assignment.substr(0, assignment.find('='));
    check_command_has(list, name);
    set_field(list, assignment);
    origins[name] = "flag --set";
  }
}

nlohmann::json bound_json(double bound) {
  return std::abs(bound) < FieldRange{}.high ? nlohmann::json(bound) : nlohmann::json(nullptr);
}

nlohmann::json field_json(const Field& field) {
  nlohmann::json option = {{"name", field.name}, {"description", field.description}};
  std::visit([&](const auto* value) { option["value"] = *value; }, field.value);
  if (option["value"].is_number()) {
    option["range"] = {bound_json(field.range.low), bound_json(field.range.high)};
    option["unit"] = field.unit;
  }
  return option;
}

}  // namespace

FieldList fields(EveryOption& every) {
  return join({fields(every.build), nest("tracking", fields(every.tracking)),
               nest("simulation", fields(every.simulation)), nest("scene", fields(every.scene))});
}

OptionOrigins apply_options(const FieldList& list, const OptionSources& sources) {
  OptionOrigins origins;
  warn_of_unknown_variables(list);
  apply_all(list, sources, origins);
  const auto set = named_sets(list);
  if (set.empty()) return origins;
  for (const auto& [source, name, value, plain] : set) {
    set_field(list, name + "=" + value);
    origins[name] = source;
  }
  apply_all(list, sources, origins);  // over it
  return origins;
}

void set_fields(const FieldList& list, const std::vector<std::string>& assignments) {
  const auto set_all = [&] {
    for (const auto& assignment : assignments) set_field(list, assignment);
  };
  const auto before = named_sets(list);
  set_all();
  const auto after = named_sets(list);
  if (after == before) return;
  for (const auto& old : before) {  // what the former set had set, unless somebody changed it since
    const auto now =
        std::find_if(list.begin(), list.end(), [&](const Field& f) { return f.name == old.name; });
    if (now != list.end() && field_text(*now) == old.value) set_field(list, old.name + "=" + old.plain);
  }
  for (const auto& value : after) set_field(list, value.name + "=" + value.value);
  set_all();  // over it
}

std::string origin_of(const std::string& option, const OptionOrigins& origins) {
  const auto found = origins.find(option);
  return found == origins.end() ? "default" : found->second;
}

std::string option_file_template(const FieldList& list) {
  std::string text =
      "# Options of stonestack. Take away the # before a name to set it.\n"
      "# Stronger than this file: a flag, --set NAME=VALUE, and the environment "
      "(STONESTACK_SEARCH_FRICTION=0.3).\n";
  std::string group;
  for (const Field& field : list) {
    const std::string line = write_fields({field}), prefix = field.name.substr(0, field.name.rfind('.'));
    const std::size_t comment = line.find("  # ", field.name.size() + 2 + field_text(field).size());
    if (prefix != group) text += concat("\n# ", group = prefix, '\n');
    text += concat("\n# ", line.substr(comment + 4), '#', line.substr(0, comment), '\n');
  }
  return text;
}

std::string fields_json(const FieldList& list, const OptionOrigins* origins) {
  nlohmann::json options = nlohmann::json::array();
  for (const Field& field : list) {
    options.push_back(field_json(field));
    if (origins != nullptr) options.back()["origin"] = origin_of(field.name, *origins);
  }
  return nlohmann::json{{"schema", "stonestack.config/1"}, {"options", options}}.dump(2) + "\n";
}

}  // namespace stonestack::experiment
