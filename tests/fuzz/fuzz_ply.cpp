// PLY files as clouds and as meshes: refused with a FileError, or sound.
#include "fuzz/checks.hpp"
#include "geometry/cloud_parse.hpp"
#include "geometry/mesh_parse.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::report;
  const std::string text = fuzz::text_of(data, size);
  try {
    fuzz::check_cloud(parse_cloud("fuzz.ply", "ply", text));
  } catch (const FileError&) {
  }
  try {
    fuzz::check_mesh(parse_mesh("fuzz.ply", "ply", text));
  } catch (const FileError&) {
  }
  return 0;
}
