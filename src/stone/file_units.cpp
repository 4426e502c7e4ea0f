#include "stone/file_units.hpp"

#include <array>
#include <cmath>

#include "stonestack/core/error.hpp"

namespace stonestack::stone {
namespace {

struct Unit {
  const char* name;
  double metres;
};
constexpr std::array<Unit, 3> kUnits = {{{"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}}};

constexpr double kMin = 0.02, kMax = 2.0;                    // m, outside it is no stone
constexpr double kGraspableMin = 0.05, kGraspableMax = 0.5;  // m, outside no gripper holds it
constexpr double kGraspableSize = 0.15;                      // m, what `auto` aims at

const Unit* named(const std::string& name) {
  for (const Unit& unit : kUnits)
    if (name == unit.name) return &unit;
  return nullptr;
}

/// The unit that makes `size` file units nearest to hand size, by ratio.
const Unit& nearest_unit(double size) {
  const Unit* best = &kUnits[0];
  const auto off = [&](const Unit& unit) { return std::abs(std::log(size * unit.metres / kGraspableSize)); };
  for (const Unit& unit : kUnits)
    if (off(unit) < off(*best)) best = &unit;
  return *best;
}

bool is_stone_size(double metres) {
  return metres >= kMin && metres <= kMax;
}

/// Suggests what would make the size right: another unit if one does, else a scale.
std::string remedy(double longest, double scale, const std::string& units) {
  const Unit& better = nearest_unit(longest * scale);
  if (units != "auto" && units != better.name && is_stone_size(longest * scale * better.metres))
    return concat("if the file is in ", better.name, ", give --units ", better.name,
                  "; else give --scale to change the size");
  return "give --scale to bring it there";
}

}  // namespace

FileScale file_scale(double longest, const std::string& units, double scale, const std::string& source) {
  require(std::isfinite(scale) && scale > 0.0, "scale must be positive, got ", scale);
  require(units == "auto" || named(units) != nullptr, "units must be m, cm, mm or auto, got '", units, "'");
  const Unit& unit = units == "auto" ? nearest_unit(longest * scale) : *named(units);
  FileScale result;
  result.metres_per_unit = unit.metres * scale;
  const double size = longest * result.metres_per_unit;
  if (!is_stone_size(size))
    throw FileError(source,
                    concat("is ", size, " m long in ", unit.name, ", a stone is between 2 cm and 2 m"),
                    remedy(longest, scale, units));
  if (size < kGraspableMin || size > kGraspableMax)
    result.warnings.push_back(
        concat("is ", size, " m long in ", unit.name, ", no gripper holds that; check --units and --scale"));
  return result;
}

}  // namespace stonestack::stone
