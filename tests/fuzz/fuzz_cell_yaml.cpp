// Cell files: refused with a FileError, or a layout of rotations and finite places.
#include "rooms.hpp"
#include "fuzz/checks.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/hardware/cell_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::report;
  using fuzz::check;
  static const fuzz::Scratch scratch;
  const std::string path = scratch.write("cell.yaml", fuzz::text_of(data, size));
  try {
    const CellConfig config = read_cell_file(path);
    const CellLayout layout = to_layout(config);
    check(is_valid(layout.T_W_R) && is_valid(layout.T_F_T) && is_valid(layout.T_T_C));
    check(layout.site.allFinite() && layout.field_centre.allFinite() && layout.field_size.minCoeff() > 0);
    for (const auto& obstacle : layout.obstacles)
      for (const auto& piece : obstacle.pieces) fuzz::check_mesh(piece);
  } catch (const FileError&) {
  }
  return 0;
}
