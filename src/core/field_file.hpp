#pragma once
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"

/// Private to the library: kinds of things that are files of named figures, one each, in a folder of the data
/// (grippers, depth cameras).
namespace stonestack::core {

/// True for the path of a YAML, false for the name of a file that comes with stonestack.
[[nodiscard]] bool is_yaml_path(const std::string& name_or_path);

/// Names of the files in a folder of the data, sorted; empty where there is no such folder.
[[nodiscard]] std::vector<std::string> data_names(const std::string& folder);

/// Path of a file by its name in a folder of the data, or of a file that is given by its path.
/// @param kind as errors name it: "gripper"
/// @throws FileError that lists the known names.
[[nodiscard]] std::string data_file(const std::string& kind, const std::string& folder,
                                    const std::string& name_or_path);

/// Reads the fields of a file. Each must be there but `optional`, and nothing else.
/// @throws FileError with the remedy.
void read_fields(const std::string& path, const FieldList& list, const std::string& remedy,
                 const std::vector<std::string>& optional = {});

}  // namespace stonestack::core
