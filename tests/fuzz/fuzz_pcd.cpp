// PCD clouds: refused with a FileError, or sound.
#include "fuzz/checks.hpp"
#include "geometry/cloud_parse.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::report;
  try {
    fuzz::check_cloud(parse_cloud("fuzz.pcd", "pcd", fuzz::text_of(data, size)));
  } catch (const FileError&) {
  }
  return 0;
}
