#include "protocol/primary_wire.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "protocol/big_endian.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::protocol {
namespace {

constexpr std::size_t kHeader = 5;
constexpr std::uint8_t kRobotState = 16, kRobotMessage = 20;
constexpr std::uint8_t kKinematicsPart = 5, kSafetyPart = 10;
constexpr std::size_t kChecksums = 6;  // one a joint, before the table
constexpr int kReadOnly = 210;
constexpr std::size_t kLongestTitle = 255;

using Kind = PrimaryMessage::Kind;

std::string take_rest(BigEndianReader& in) {
  std::string text(in.take(in.rest().size()));
  text.erase(std::find(text.begin(), text.end(), '\0'), text.end());
  return text;
}

void get_version(BigEndianReader& in, PrimaryMessage& m) {
  m.title = std::string(in.take(in.get<std::uint8_t>()));  // project name
  m.version.major = in.get<std::uint8_t>();
  m.version.minor = in.get<std::uint8_t>();
  in.get(m.version.bugfix);
  in.get(m.version.build);
  m.text = take_rest(in);  // build date
}

/// Reads the body after the kind; true if that kind is read here.
bool get_body(BigEndianReader& in, PrimaryMessage& m) {
  switch (m.kind) {
    case Kind::kText:
      m.text = take_rest(in);
      return true;
    case Kind::kVersion:
      get_version(in, m);
      return true;
    case Kind::kSafetyMode:
      m.code = in.get<std::int32_t>();
      m.argument = in.get<std::int32_t>();
      m.level = in.get<std::uint8_t>();  // the safety mode
      return true;
    case Kind::kError:
      m.code = in.get<std::int32_t>();
      m.argument = in.get<std::int32_t>();
      m.level = in.get<std::int32_t>();
      in.take(2 * sizeof(std::uint32_t));  // data type and data
      m.text = take_rest(in);
      return true;
    case Kind::kKey:
      m.code = in.get<std::int32_t>();
      m.argument = in.get<std::int32_t>();
      m.title = std::string(in.take(in.get<std::uint8_t>()));
      m.text = take_rest(in);
      return true;
    case Kind::kRuntimeException:
      m.line = in.get<std::int32_t>();
      m.column = in.get<std::int32_t>();
      m.text = take_rest(in);
      return true;
    case Kind::kPopup:
    case Kind::kRequestValue:
      break;
  }
  return false;
}

std::optional<PrimaryMessage> decode_message(std::string_view payload) {
  BigEndianReader in(payload);
  PrimaryMessage message;
  in.get(message.timestamp);
  message.source = static_cast<std::int8_t>(in.get<std::uint8_t>());
  message.kind = static_cast<Kind>(in.get<std::uint8_t>());
  if (!in.sound() || !get_body(in, message) || !in.sound()) return std::nullopt;
  return message;
}

void put_body(std::string& out, const PrimaryMessage& m) {
  const auto put_title = [&] {
    const std::string title = m.title.substr(0, kLongestTitle);
    put(out, static_cast<std::uint8_t>(title.size()));
    out += title;
  };
  const auto put_int = [&](int value) { put(out, static_cast<std::int32_t>(value)); };
  switch (m.kind) {
    case Kind::kVersion:
      put_title();
      put(out, static_cast<std::uint8_t>(m.version.major));
      put(out, static_cast<std::uint8_t>(m.version.minor));
      put(out, m.version.bugfix);
      put(out, m.version.build);
      break;
    case Kind::kSafetyMode:
      put_int(m.code);
      put_int(m.argument);
      put(out, static_cast<std::uint8_t>(m.level));
      put_int(0);
      put_int(0);
      return;
    case Kind::kError:
      for (const int value : {m.code, m.argument, m.level, 0, 0}) put_int(value);
      break;
    case Kind::kKey:
      put_int(m.code);
      put_int(m.argument);
      put_title();
      break;
    case Kind::kRuntimeException:
      put_int(m.line);
      put_int(m.column);
      break;
    case Kind::kText:
    case Kind::kPopup:
    case Kind::kRequestValue:
      break;
  }
  out += m.text;
}

bool is_finite(const std::array<double, 6>& values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

/// Data of the first part of that type in a robot state.
std::optional<std::string_view> find_part(std::string_view state, std::uint8_t wanted) {
  BigEndianReader parts(state);
  while (parts.sound() && parts.rest().size() >= kHeader) {
    const auto size = parts.get<std::uint32_t>();
    const auto type = parts.get<std::uint8_t>();
    if (size < kHeader) break;
    const std::string_view part = parts.take(size - kHeader);
    if (parts.sound() && type == wanted) return part;
  }
  return std::nullopt;
}

std::optional<PrimaryKinematics> find_kinematics(std::string_view state) {
  const auto part = find_part(state, kKinematicsPart);
  if (!part) return std::nullopt;
  BigEndianReader in(*part);
  in.take(kChecksums * sizeof(std::uint32_t));
  PrimaryKinematics found;
  for (auto* column : {&found.theta, &found.a, &found.d, &found.alpha}) {
    in.get(*column);
    if (!in.sound() || !is_finite(*column)) return std::nullopt;
  }
  return found;
}

std::optional<std::uint32_t> find_safety_checksum(std::string_view state) {
  const auto part = find_part(state, kSafetyPart);
  if (!part) return std::nullopt;
  BigEndianReader in(*part);
  const auto checksum = in.get<std::uint32_t>();
  return in.sound() ? std::optional(checksum) : std::nullopt;
}

}  // namespace

std::string checksum_text(std::uint32_t checksum) {
  std::array<char, 9> text{};
  std::snprintf(text.data(), text.size(), "%08X", checksum);
  return text.data();
}

std::optional<std::uint32_t> parse_checksum(const std::string& text) {
  std::uint32_t checksum = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), checksum, 16);
  if (text.size() != 8 || problem != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return checksum;
}

bool is_read_only_error(const PrimaryMessage& message) {
  return message.kind == Kind::kError && message.code == kReadOnly;
}

std::string encode(const PrimaryMessage& message) {
  std::string body;
  put(body, message.timestamp);
  put(body, static_cast<std::uint8_t>(message.source));
  put(body, static_cast<std::uint8_t>(message.kind));
  put_body(body, message);
  std::string bytes;
  put(bytes, static_cast<std::uint32_t>(body.size() + kHeader));
  put(bytes, kRobotMessage);
  return bytes + body;
}

void PrimaryStream::feed(std::string_view bytes) {
  if (!problem_.empty()) return;
  bytes_.erase(0, begin_);
  begin_ = 0;
  bytes_.append(bytes);
}

std::optional<PrimaryMessage> PrimaryStream::next() {
  while (problem_.empty() && bytes_.size() - begin_ >= kHeader) {
    BigEndianReader in(std::string_view(bytes_).substr(begin_));
    const auto size = in.get<std::uint32_t>();
    const auto type = in.get<std::uint8_t>();
    if (size < kHeader || size > max_) {
      problem_ = concat("package of ", size, " bytes (", kHeader, " to ", max_, " expected)");
      break;
    }
    if (bytes_.size() - begin_ < size) break;
    begin_ += size;
    const std::string_view payload = in.take(size - kHeader);
    if (type == kRobotMessage)
      if (auto message = decode_message(payload)) return message;
    if (type == kRobotState) {
      if (const auto found = find_kinematics(payload)) kinematics_ = found;
      if (const auto found = find_safety_checksum(payload)) safety_checksum_ = found;
    }
    ++passed_over_;
    states_ += type == kRobotState ? 1 : 0;
  }
  return std::nullopt;
}

}  // namespace stonestack::protocol
