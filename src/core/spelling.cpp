#include "stonestack/core/options.hpp"

#include <algorithm>
#include <map>

namespace stonestack::core {
namespace {

constexpr std::size_t kMaxMeant = 3;

/// Are the words the same but for two neighbours that swapped places?
bool are_swapped(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  const auto first = std::mismatch(a.begin(), a.end(), b.begin());
  if (a.end() - first.first < 2) return false;
  std::string swapped(a);
  std::iter_swap(swapped.begin() + (first.first - a.begin()),
                 swapped.begin() + (first.first - a.begin()) + 1);
  return swapped == b;
}

/// Names by their edit distance, neighbours that swapped places as one edit; the order of equal ones is kept.
std::multimap<std::size_t, std::string> ranked(const std::vector<std::string>& names, std::string_view name) {
  std::multimap<std::size_t, std::string> list;
  for (const std::string& known : names)
    list.emplace(are_swapped(name, known) ? 1 : edit_distance(name, known), known);
  return list;
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row.back();
}

std::vector<std::string> likely_meant(const std::vector<std::string>& names, std::string_view name) {
  std::vector<std::string> list;
  const auto add = [&](const std::string& known) {
    if (list.size() < kMaxMeant && std::find(list.begin(), list.end(), known) == list.end())
      list.push_back(known);
  };
  for (const std::string& known : names)
    if (!name.empty() && known.starts_with(name)) add(known);
  const std::size_t slip = std::max<std::size_t>(1, name.size() / 3);
  const auto by_distance = ranked(names, name);
  for (const auto& [distance, known] : by_distance)
    if (distance <= slip && distance == by_distance.begin()->first) add(known);
  return list;
}

}  // namespace stonestack::core
