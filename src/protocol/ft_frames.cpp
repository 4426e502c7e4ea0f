#include "protocol/ft_frames.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "protocol/modbus_frame.hpp"

namespace stonestack::protocol {
namespace {

constexpr std::uint8_t kFirst = 0x20, kSecond = 0x4E;
constexpr std::array<double, 6> kCounts{100, 100, 100, 1000, 1000, 1000};  // per N, per Nm
constexpr std::size_t kLongestText = 160;                                  // bytes between brackets
constexpr std::size_t kMaxKept = 4096;
constexpr double kMaxPlausible = 1e4;  // N, Nm: more is no reading of any sensor

std::optional<FtReading> decode_frame(std::span<const std::uint8_t> bytes) {
  const auto crc = static_cast<std::uint16_t>(bytes[14] + 256U * bytes[15]);
  if (bytes[0] != kFirst || bytes[1] != kSecond || modbus::crc16(bytes.first(14)) != crc) return std::nullopt;
  FtReading reading;
  for (std::size_t i = 0; i < reading.size(); ++i)
    reading[i] = static_cast<std::int16_t>(bytes[2 + 2 * i] + 256U * bytes[3 + 2 * i]) / kCounts[i];
  return reading;
}

// Six finite numbers between commas.
std::optional<FtReading> decode_text(std::string_view text) {
  FtReading reading;
  for (std::size_t i = 0; i < reading.size(); ++i) {
    const auto comma = i + 1 < reading.size() ? text.find(',') : text.size();
    if (comma == std::string_view::npos) return std::nullopt;
    std::string_view word = text.substr(0, comma);
    while (!word.empty() && word.front() == ' ') word.remove_prefix(1);
    while (!word.empty() && word.back() == ' ') word.remove_suffix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), reading[i]);
    if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
    if (!std::isfinite(reading[i]) || std::abs(reading[i]) > kMaxPlausible) return std::nullopt;
    text.remove_prefix(std::min(text.size(), comma + 1));
  }
  return reading;
}

}  // namespace

std::array<std::uint8_t, kFtFrame> encode_ft_frame(const FtReading& reading) {
  std::array<std::uint8_t, kFtFrame> frame{kFirst, kSecond};
  for (std::size_t i = 0; i < reading.size(); ++i) {
    const double count = std::clamp(std::round(reading[i] * kCounts[i]), -32768.0, 32767.0);
    const auto bits =
        static_cast<std::uint16_t>(static_cast<std::int16_t>(std::isfinite(count) ? count : 0.0));
    frame[2 + 2 * i] = static_cast<std::uint8_t>(bits & 0xFFU);
    frame[3 + 2 * i] = static_cast<std::uint8_t>(bits >> 8U);
  }
  const std::uint16_t crc = modbus::crc16(std::span(frame).first(14));
  frame[14] = static_cast<std::uint8_t>(crc & 0xFFU);
  frame[15] = static_cast<std::uint8_t>(crc >> 8U);
  return frame;
}

std::string encode_ft_text(const FtReading& reading) {
  std::array<char, 160> text;
  const int length = std::snprintf(text.data(), text.size(), "(%.3f , %.3f , %.3f , %.4f , %.4f , %.4f)",
                                   reading[0], reading[1], reading[2], reading[3], reading[4], reading[5]);
  return {text.data(), static_cast<std::size_t>(std::clamp(length, 0, static_cast<int>(text.size()) - 1))};
}

void FtParser::feed(std::span<const std::uint8_t> bytes) {
  kept_.insert(kept_.end(), bytes.begin(), bytes.end());
  if (kept_.size() > kMaxKept) {
    bad_ += static_cast<long>(kept_.size() - kMaxKept);
    drop(kept_.size() - kMaxKept);
  }
}

void FtParser::drop(std::size_t count) {
  kept_.erase(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(count));
}

std::optional<FtReading> FtParser::next() {
  return format_ == Format::kSerial ? next_frame() : next_text();
}

std::optional<FtReading> FtParser::next_frame() {
  std::size_t at = 0;
  std::optional<FtReading> reading;
  for (; at + kFtFrame <= kept_.size(); ++at)
    if ((reading = decode_frame(std::span(kept_).subspan(at, kFtFrame)))) break;
  bad_ += static_cast<long>(at);
  drop(at + (reading ? kFtFrame : 0));
  return reading;
}

std::optional<FtReading> FtParser::next_text() {
  for (;;) {
    const auto open = std::find(kept_.begin(), kept_.end(), '(');
    bad_ += open - kept_.begin();
    kept_.erase(kept_.begin(), open);
    // A new bracket inside means that the end of the one before was lost.
    const auto stop = std::find_if(kept_.begin() + (kept_.empty() ? 0 : 1), kept_.end(),
                                   [](std::uint8_t byte) { return byte == ')' || byte == '('; });
    const auto length = static_cast<std::size_t>(stop - kept_.begin());
    if (stop == kept_.end() && length <= kLongestText) return std::nullopt;
    std::optional<FtReading> reading;
    if (stop != kept_.end() && *stop == ')' && length <= kLongestText)
      reading = decode_text({reinterpret_cast<const char*>(kept_.data()) + 1, length - 1});
    const std::size_t used = stop != kept_.end() && *stop == ')' ? length + 1 : length;
    if (!reading) bad_ += static_cast<long>(used);
    drop(used);
    if (reading) return reading;
  }
}

}  // namespace stonestack::protocol
