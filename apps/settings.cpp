#include "settings.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "stonestack/core/error.hpp"
#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::apps {
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

/// Returns the options that detection.method stands for, by name, as far as it is not the default.
std::vector<std::pair<std::string, std::string>> set_of_method(const FieldList& list) {
  const auto method =
      std::find_if(list.begin(), list.end(), [](const Field& f) { return f.name == "detection.method"; });
  if (method == list.end()) return {};
  DetectionOptions plain, meant = options_of(field_text(*method));
  plain.method = meant.method;
  const FieldList before = nest("detection", fields(plain)), after = nest("detection", fields(meant));
  std::vector<std::pair<std::string, std::string>> set;
  for (std::size_t i = 0; i < after.size(); ++i)
    if (field_text(before[i]) != field_text(after[i])) set.emplace_back(after[i].name, field_text(after[i]));
  return set;
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

}  // namespace

void Settings::register_on(CLI::App& command) {
  command.add_option("--set", assignments_, "Set an option, e.g. --set search.friction=0.3 (repeatable)")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  command.add_option("--config", config_, "Option file in place of ./stonestack.yaml")->type_name("FILE");
}

FieldList every_field(EveryOption& every) {
  return join({fields(every.build), nest("tracking", fields(every.tracking)),
               nest("simulation", fields(every.simulation)), nest("scene", fields(every.scene))});
}

void Settings::apply_file(const FieldList& list, const std::string& path, const std::string& kind) {
  const auto before = values(list);
  EveryOption others;  // checked, but of no effect on this command
  read_fields(list, path, every_field(others));
  const auto after = values(list);
  for (std::size_t i = 0; i < list.size(); ++i)
    if (before[i] != after[i]) origins_[list[i].name] = kind + " " + path;
}

void Settings::bind(CLI::Option* flag, const std::string& name) {
  bound_.emplace_back(flag, name);
}

void Settings::apply_bound(const FieldList& list) {
  for (const auto& [flag, name] : bound_) {
    if (flag->count() == 0) continue;
    for (const auto& field : list) {
      const bool seed = name == "*.seed" && (field.name == "seed" || field.name.ends_with(".seed"));
      if (field.name != name && !seed) continue;
      set_field(list, field.name + "=" + flag->results().back());
      origins_[field.name] = "flag " + flag->get_name();
    }
  }
}

void Settings::apply(const FieldList& list) {
  const auto apply_all = [&] {
    const std::string user = user_file();
    if (!user.empty() && std::filesystem::exists(user)) apply_file(list, user, "user file");
    if (!config_.empty()) {
      apply_file(list, config_, "file");
    } else if (std::filesystem::exists("stonestack.yaml")) {
      apply_file(list, "stonestack.yaml", "project file");
    }
    for (const auto& field : list)
      if (const auto name = apply_environment(list, field.name))
        origins_[field.name] = "environment " + *name;
    apply_bound(list);
    for (const auto& assignment : assignments_) {
      set_field(list, assignment);
      origins_[assignment.substr(0, assignment.find('='))] = "flag --set";
    }
  };
  apply_all();
  const auto set = set_of_method(list);
  for (const auto& [name, value] : set) {
    set_field(list, name + "=" + value);
    origins_[name] = "detection.method";
  }
  if (!set.empty()) apply_all();  // over it
}

void set_fields(const FieldList& list, const std::vector<std::string>& assignments) {
  const auto set_all = [&] {
    for (const auto& assignment : assignments) set_field(list, assignment);
  };
  const auto before = set_of_method(list);
  set_all();
  const auto after = set_of_method(list);
  if (after == before) return;
  for (const auto& [name, value] : after) set_field(list, name + "=" + value);
  set_all();  // over it
}

std::string Settings::origin(const std::string& name) const {
  const auto found = origins_.find(name);
  return found == origins_.end() ? "default" : found->second;
}

}  // namespace stonestack::apps
