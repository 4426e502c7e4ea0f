#include "core/yaml.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "stonestack/core/file.hpp"

namespace stonestack::core::yaml {
namespace {

constexpr std::size_t kMaxFile = 1 << 20;
constexpr int kMaxVisits = 100000;
constexpr int kMaxLevels = 64;

struct Walk {
  const std::function<void(const std::string&, const std::string&)>& visit;
  int visits = 0;

  void down(const YAML::Node& node, const std::string& name, int level) {
    require(++visits <= kMaxVisits && level <= kMaxLevels, "nested too deeply at '", name, "'");
    if (node.IsScalar()) return visit(name, node.Scalar());
    if (node.IsSequence()) return visit(name, YAML::Dump(node));
    require(node.IsMap() || node.IsNull(), "'", name, "' must be a value or a map of values");
    for (const auto& entry : node) {
      const std::string& key = entry.first.Scalar();
      down(entry.second, name.empty() ? key : name + "." + key, level + 1);
    }
  }
};

/// yaml-cpp keeps both of two equal keys and finds one of them; who wrote the other would never know. A key
/// that is a list, a map or nothing has no name. Stops early in what is too deep or too large, which `Walk`
/// refuses.
void check_keys(const YAML::Node& node, const std::string& path, int& visits, int level) {
  if (++visits > kMaxVisits || level > kMaxLevels) return;
  if (node.IsSequence())
    for (const auto& entry : node) check_keys(entry, path, visits, level + 1);
  if (!node.IsMap()) return;
  std::set<std::string> keys;
  for (const auto& entry : node) {
    if (!entry.first.IsScalar())
      throw FileError(path, concat("has a key that is no word in line ", entry.first.Mark().line + 1),
                      "write 'name: value'");
    if (!keys.insert(entry.first.Scalar()).second)
      throw FileError(path,
                      concat("the key '", entry.first.Scalar(), "' stands twice in one map, again in line ",
                             entry.first.Mark().line + 1),
                      "keep one of the two");
    check_keys(entry.second, path, visits, level + 1);
  }
}

}  // namespace

YAML::Node parse(const std::string& text, const std::string& path) {
  try {
    YAML::Node node = YAML::Load(text);
    int visits = 0;
    check_keys(node, path, visits, 0);
    return node;
  } catch (const YAML::Exception& problem) {
    throw FileError(path, concat("not YAML: ", problem.what()), "mend the file at that line");
  }
}

YAML::Node read_file(const std::string& path) {
  return parse(core::read_file(path, kMaxFile), path);
}

void for_each_scalar(const YAML::Node& node,
                     const std::function<void(const std::string&, const std::string&)>& visit) {
  Walk{visit}.down(node, "", 0);
}

Map::Map(YAML::Node node, std::string path, std::string where)
    : node_(std::move(node)), path_(std::move(path)), where_(std::move(where)) {
  if (!node_.IsMap())
    throw FileError(path_, concat(where_.empty() ? "the file" : where_, " is not a map of keys"),
                    "see the examples in data/");
}

bool Map::has(const std::string& key) const {
  return node_[key].IsDefined();
}

YAML::Node Map::node(const std::string& key) {
  asked_.push_back(key);
  if (!has(key)) fail(key, "is missing", "add it");
  return node_[key];
}

double Map::number(const std::string& key) {
  const YAML::Node value = node(key);
  double number = std::nan("");
  if (!value.IsScalar() || !YAML::convert<double>::decode(value, number) || !std::isfinite(number))
    fail(key,
         concat("must be a finite number, got '", value.IsScalar() ? value.Scalar() : "a list or map", "'"),
         "write a number");
  return number;
}

double Map::number(const std::string& key, double low, double high) {
  const double value = number(key);
  if (value < low || value > high)
    fail(key, concat("is ", value), concat("it must be in [", low, ", ", high, "]"));
  return value;
}

std::string Map::text(const std::string& key) {
  const YAML::Node value = node(key);
  if (!value.IsScalar()) fail(key, "must be text", "write one value");
  return value.Scalar();
}

Map Map::map(const std::string& key) {
  return {node(key), path_, where_.empty() ? key : where_ + "." + key};
}

void Map::finish() const {
  for (const auto& entry : node_) {
    const std::string key = entry.first.Scalar();
    if (std::find(asked_.begin(), asked_.end(), key) == asked_.end())
      fail(key, "is not a key of this file", "remove it or correct its name");
  }
}

void Map::fail(const std::string& key, const std::string& problem, const std::string& remedy) const {
  throw FileError(path_, concat(where_.empty() ? "" : where_ + ".", key, " ", problem), remedy);
}

}  // namespace stonestack::core::yaml
