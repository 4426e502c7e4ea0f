// Depth frames from the wire: what is accepted fits its header, and encodes to what decodes to the same.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "protocol/frame_stream.hpp"
#include "rooms.hpp"

namespace {

using namespace stonestack;
using namespace stonestack::report;

constexpr std::size_t kMaxPixels = 1U << 16U;  // an input cannot fill more

void check(bool held) {
  if (!held) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);
  std::string problem;
  auto header = parse_frame_header(bytes, problem);
  check(header.has_value() != !problem.empty());
  if (!header || header->pixel_bytes > 2 * kMaxPixels) return 0;
  check(header->pixel_bytes ==
        2U * static_cast<unsigned>(header->camera.width) * static_cast<unsigned>(header->camera.height));
  const auto pixels = bytes.subspan(kFrameHeader);
  static_cast<void>(parse_frame(*header, pixels));
  // A mutated frame hardly ever has the right checksum: give it one.
  const auto cut = pixels.first(std::min<std::size_t>(pixels.size(), header->pixel_bytes));
  header->crc = crc32(cut);
  const auto frame = parse_frame(*header, cut);
  check(frame.has_value() == (cut.size() == header->pixel_bytes));
  if (!frame) return 0;
  for (const float z : frame->image.z) check(std::isfinite(z) && z >= 0);
  const auto again = encode_frame(*frame, header->unit);
  check(again.size() == kFrameHeader + cut.size());
  return 0;
}
