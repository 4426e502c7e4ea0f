// Both streams of the force sensor: finite readings only, whole or byte by byte the same, bounded memory.
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "protocol/ft_frames.hpp"
#include "rooms.hpp"

namespace {

using namespace stonestack;
using namespace stonestack::report;

void check(bool held) {
  if (!held) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, std::min<std::size_t>(size, 4000));
  for (const auto format : {FtParser::Format::kSerial, FtParser::Format::kCap}) {
    FtParser whole(format), cut(format);
    std::vector<FtReading> readings, readings_cut;
    whole.feed(bytes);
    while (const auto reading = whole.next()) readings.push_back(*reading);
    for (const auto byte : bytes) {
      cut.feed({&byte, 1});
      while (const auto reading = cut.next()) readings_cut.push_back(*reading);
    }
    check(readings == readings_cut);
    for (const auto& reading : readings)
      for (const double value : reading) check(std::isfinite(value));
    check(whole.bad_bytes() >= 0 && whole.bad_bytes() <= static_cast<long>(bytes.size()));
    if (format == FtParser::Format::kSerial && !readings.empty()) {
      FtParser again(format);
      again.feed(encode_ft_frame(readings.front()));
      check(again.next() == readings.front());
    }
  }
  return 0;
}
