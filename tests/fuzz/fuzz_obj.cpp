// OBJ meshes: refused with a FileError, or sound.
#include "fuzz/checks.hpp"
#include "geometry/mesh_parse.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::report;
  try {
    fuzz::check_mesh(parse_mesh("fuzz.obj", "obj", fuzz::text_of(data, size)));
  } catch (const FileError&) {
  }
  return 0;
}
