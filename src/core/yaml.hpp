#pragma once
#include <yaml-cpp/yaml.h>

#include <functional>
#include <string>

#include "stonestack/core/error.hpp"

/// Private to the library: strict reading of YAML files. A file is read whole, is at most 1 MiB, and every
/// error names the file, the place and the remedy.
namespace stonestack::core::yaml {

/// Reads and parses. Throws FileError, also for a key that a map has twice (named, with its line).
[[nodiscard]] YAML::Node read_file(const std::string& path);
/// Parses text that came from `path` (named in errors).
[[nodiscard]] YAML::Node parse(const std::string& text, const std::string& path);
/// Visits every scalar below `node` as ("a.b.c", text), and every list as its YAML text; at most 100,000
/// visits and 64 levels, so alias bombs end.
void for_each_scalar(const YAML::Node& node,
                     const std::function<void(const std::string&, const std::string&)>& visit);

/// A map whose keys are known: get what you expect, then `finish()` refuses what is left over.
class Map {
 public:
  /// `where` is how the place is named in errors: "stone.yaml: mass".
  Map(YAML::Node node, std::string path, std::string where = "");
  [[nodiscard]] bool has(const std::string& key) const;
  /// Finite number; throws FileError when missing or not one.
  [[nodiscard]] double number(const std::string& key);
  [[nodiscard]] double number(const std::string& key, double low, double high);
  [[nodiscard]] std::string text(const std::string& key);
  [[nodiscard]] Map map(const std::string& key);
  [[nodiscard]] YAML::Node node(const std::string& key);
  /// Throws FileError if the file has a key that nobody asked for.
  void finish() const;
  [[noreturn]] void fail(const std::string& key, const std::string& problem, const std::string& remedy) const;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  YAML::Node node_;
  std::string path_;
  std::string where_;
  std::vector<std::string> asked_;
};

}  // namespace stonestack::core::yaml
