#include "core/field_file.hpp"

#include <algorithm>
#include <filesystem>

#include "core/yaml.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::core {

bool is_yaml_path(const std::string& name_or_path) {
  const auto extension = std::filesystem::path(name_or_path).extension();
  return name_or_path.find('/') != std::string::npos || extension == ".yaml" || extension == ".yml";
}

std::vector<std::string> data_names(const std::string& folder) {
  std::vector<std::string> names;
  try {
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(data_path(folder), ignored))
      if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  } catch (const FileError&) {
    return {};
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string data_file(const std::string& kind, const std::string& folder, const std::string& name_or_path) {
  if (is_yaml_path(name_or_path)) return name_or_path;
  try {
    return data_path(concat(folder, "/", name_or_path, ".yaml"));
  } catch (const FileError&) {
    std::string known;
    for (const auto& file : data_names(folder)) known += (known.empty() ? "" : ", ") + file;
    throw FileError(concat(kind, " '", name_or_path, "'"), "is not known",
                    known.empty() ? concat("set STONESTACK_DATA to the folder that holds ", folder, "/")
                                  : concat("use ", known, " or the path of a YAML"));
  }
}

void read_fields(const std::string& path, const FieldList& list, const std::string& remedy,
                 const std::vector<std::string>& optional) {
  std::vector<std::string> given = optional;
  try {
    yaml::for_each_scalar(yaml::read_file(path), [&](const std::string& name, const std::string& value) {
      set_field(list, name + "=" + value);
      given.push_back(name);
    });
  } catch (const InvalidArgument& problem) {
    throw FileError(path, problem.what(), remedy);
  }
  for (const Field& f : list)
    if (std::find(given.begin(), given.end(), f.name) == given.end())
      throw FileError(
          path, concat(f.name, " is missing", f.unit.empty() ? "" : " [" + f.unit + "]", ": ", f.description),
          remedy);
}

}  // namespace stonestack::core
