#pragma once
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

/// Private to the library and the command: reading other people's JSON files.
namespace stonestack::geometry {

/// Parses a file of at most 64 MiB. Throws FileError.
[[nodiscard]] inline nlohmann::json read_json(const std::string& path) {
  const std::string text = read_file(path, 64U << 20U);
  auto content = nlohmann::json::parse(text, nullptr, false);
  if (content.is_discarded()) throw FileError(path, "not JSON", "correct the file or download it again");
  return content;
}

/// A list of `count` finite numbers under `key`. Throws FileError naming the key.
[[nodiscard]] inline std::vector<double> numbers_of(const nlohmann::json& map, const std::string& key,
                                                    std::size_t count, const std::string& path) {
  if (!map.is_object() || !map.contains(key)) throw FileError(path, concat(key, " is missing"), "add it");
  const auto& list = map.at(key);
  std::vector<double> numbers;
  if (list.is_array())
    for (const auto& value : list)
      if (value.is_number() && std::isfinite(value.get<double>())) numbers.push_back(value.get<double>());
  if (numbers.size() != count || list.size() != count)
    throw FileError(path, concat(key, " is not a list of ", count, " finite numbers"), "correct it");
  return numbers;
}

/// A finite number under `key` in [low, high]. Throws FileError naming key and value.
[[nodiscard]] inline double number_of(const nlohmann::json& map, const std::string& key, double low,
                                      double high, const std::string& path) {
  if (!map.is_object() || !map.contains(key) || !map.at(key).is_number())
    throw FileError(path, concat(key, " is missing or not a number"), "add it");
  const double value = map.at(key).get<double>();
  if (!(value >= low && value <= high))
    throw FileError(path, concat(key, " is ", value), concat("it must be in [", low, ", ", high, "]"));
  return value;
}

}  // namespace stonestack::geometry
