#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stonestack/core/rooms.hpp"

/// The two streams of Robotiq's force sensors, as parsers that take any bytes, and their encoders.
///
/// Serial: 16 bytes "20 4E", six int16 little-endian (0.01 N, 0.001 Nm), CRC-16 of Modbus over the first 14,
/// low byte first. Cap: ASCII "(Fx , Fy , Fz , Mx , My , Mz)" in N and Nm, one behind the other without any
/// separator.
namespace stonestack::protocol {

/// Fx Fy Fz in N, Mx My Mz in Nm.
using FtReading = std::array<double, 6>;

inline constexpr std::size_t kFtFrame = 16;
[[nodiscard]] std::array<std::uint8_t, kFtFrame> encode_ft_frame(const FtReading& reading);
[[nodiscard]] std::string encode_ft_text(const FtReading& reading);

/// Cuts a stream into readings; bytes may come in any pieces.
class FtParser {
 public:
  enum class Format { kSerial, kCap };
  explicit FtParser(Format format) : format_(format) {}
  void feed(std::span<const std::uint8_t> bytes);
  /// The next whole reading; empty: feed more.
  [[nodiscard]] std::optional<FtReading> next();
  /// Bytes that belonged to no frame so far.
  [[nodiscard]] long bad_bytes() const { return bad_; }

 private:
  [[nodiscard]] std::optional<FtReading> next_frame();
  [[nodiscard]] std::optional<FtReading> next_text();
  void drop(std::size_t count);

  Format format_;
  std::vector<std::uint8_t> kept_;
  long bad_ = 0;
};

}  // namespace stonestack::protocol
