#include "stonestack/geometry/obstacle.hpp"

#include <algorithm>

#include "core/yaml.hpp"

namespace stonestack::geometry {
namespace {

constexpr std::size_t kMax = 200;       // entries
constexpr double kPaddingWidest = 1.0;  // m
constexpr const char* kMoves[] = {"arm",     "hand",    "held",    "shoulder", "upper arm",
                                  "forearm", "wrist 1", "wrist 2", "wrist 3"};

std::string listed(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// The text under `key`, which must be one of `known`.
std::string name_of(yaml::Map& entry, const char* key, const std::vector<std::string>& known) {
  const std::string name = entry.text(key);
  if (std::find(known.begin(), known.end(), name) == known.end())
    entry.fail(key, "is '" + name + "'", "write one of " + listed(known));
  return name;
}

}  // namespace

std::vector<PairPadding> parse_pair_paddings(const std::string& text, const std::string& path,
                                             const std::string& where,
                                             std::span<const std::string> obstacles) {
  const YAML::Node list = yaml::parse(text, path);
  std::vector<PairPadding> paddings;
  if (!list.IsDefined() || list.IsNull()) return paddings;
  if (!list.IsSequence())
    throw FileError(path, where + " is not a list", "write '- {a: hand, b: table, m: 0.004}'");
  if (list.size() > kMax)
    throw FileError(path, concat(where, " has ", list.size(), " entries"),
                    concat("at most ", kMax, " are read"));
  const std::vector<std::string> moves(std::begin(kMoves), std::end(kMoves));
  std::vector<std::string> stands{"table"};
  stands.insert(stands.end(), obstacles.begin(), obstacles.end());
  for (std::size_t i = 0; i < list.size(); ++i) {
    yaml::Map entry(list[i], path, concat(where, "[", i, "]"));
    PairPadding padding{name_of(entry, "a", moves), name_of(entry, "b", stands),
                        entry.number("m", 0.0, kPaddingWidest)};
    if (padding.a == "shoulder" && padding.b == "table")
      entry.fail("a", "is 'shoulder'", "the shoulder stands on the table; name another link");
    entry.finish();
    paddings.push_back(std::move(padding));
  }
  return paddings;
}

}  // namespace stonestack::geometry
