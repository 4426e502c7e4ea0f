#include "stacking/next_view.hpp"

#include <array>

namespace stonestack::stacking {

std::vector<StoneIndex> missing_stones(const WorldEstimate& world, const RunMemory& memory) {
  std::vector<StoneIndex> missing;
  for (const auto& [stone, p_W] : memory.last_seen)
    if (!holds(world.stack, stone) && !holds(world.loose, stone) && !memory.out_of_sight.contains(stone))
      missing.push_back(stone);
  return missing;
}

std::vector<StoneIndex> awaited_in_vain(const WorldEstimate& world, const RunMemory& memory) {
  std::vector<StoneIndex> lost;
  for (const StoneIndex stone : memory.awaited)
    if (!holds(world.stack, stone) && !holds(world.loose, stone)) lost.push_back(stone);
  return lost;
}

std::optional<LookAgain> next_view(const WorldEstimate& world, const RunMemory& memory) {
  constexpr double kBeside = 0.22, kHeight = 0.04;  // m, from the site and above the table
  static const std::array<Eigen::Vector2d, 4> kDirections{{{0.0, 1.0}, {-1.0, 0.0}, {1.0, 0.0}, {0.0, -1.0}}};
  const std::vector<StoneIndex> missing = missing_stones(world, memory);
  for (const StoneIndex stone : missing)
    if (!memory.sought_where_it_was.contains(stone))
      return LookAgain{stone, LookAgain::Where::kWhereItWas, memory.last_seen.at(stone)};
  const auto place = static_cast<std::size_t>(memory.sought_beside_site);
  if (missing.empty() || place >= kDirections.size()) return std::nullopt;
  const Eigen::Vector2d p = world.layout.site + kBeside * kDirections[place];
  return LookAgain{missing.front(), LookAgain::Where::kBesideSite, {p.x(), p.y(), kHeight}};
}

}  // namespace stonestack::stacking
