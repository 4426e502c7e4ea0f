// What a stone's folder says of its surface: refused with a FileError, or of the scan and finite.
#include <cmath>

#include "fuzz/checks.hpp"
#include "rooms.hpp"
#include "stone/surface_file.hpp"
#include "stonestack/core/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace stonestack;
  using namespace stonestack::report;
  using fuzz::check;
  static const fuzz::Scratch scratch;
  constexpr std::size_t kVertices = 4;
  try {
    const stone::SurfaceKnowledge surface =
        stone::read_surface(scratch.write("surface.json", fuzz::text_of(data, size)), kVertices);
    check(surface.sigma.size() == kVertices && surface.seen.size() == kVertices);
    for (const double sigma : surface.sigma) check(std::isfinite(sigma) && sigma >= 0.0);
    for (const Eigen::Vector3d& up_O : surface.up_O_at_rest) check(std::abs(up_O.norm() - 1.0) < 1e-9);
    const stone::SurfaceKnowledge again =
        stone::read_surface(scratch.write("again.json", stone::surface_json(surface)), kVertices);
    check(again.sigma == surface.sigma && again.seen == surface.seen);
  } catch (const FileError&) {
  }
  return 0;
}
