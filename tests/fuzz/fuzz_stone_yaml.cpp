// A stone's file in a catalogue: refused with a FileError, or finite and positive where it must be.
#include <cmath>

#include "fuzz/checks.hpp"
#include "rooms.hpp"
#include "stone/stone_yaml.hpp"
#include "stonestack/core/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::report;
  using fuzz::check;
  static const fuzz::Scratch scratch;
  const std::string path = scratch.write("stone.yaml", fuzz::text_of(data, size));
  try {
    const StoneFile file = read_stone_yaml(path);
    const Stone& stone = file.stone;
    check(stone.mass.mass > 0 && stone.density > 0 && stone.friction > 0 && stone.scale > 0);
    check(stone.mass.p_O_M.allFinite() && stone.mass.I_M.allFinite() && is_valid(stone.T_O_file));
    check(file.symmetries.p_O.allFinite());
    for (const SymmetryAxis& axis : file.symmetries.axes)
      check(std::abs(axis.n_O.norm() - 1.0) < 0.01 && axis.order >= 0 && axis.deviation >= 0);
    for (const SymmetryPlane& plane : file.symmetries.planes)
      check(std::abs(plane.n_O.norm() - 1.0) < 0.01 && plane.deviation >= 0);
    check(file.faces >= 4 && file.faces <= 500 && file.pieces >= 1 && file.pieces <= 1000);
  } catch (const FileError&) {
  }
  return 0;
}
