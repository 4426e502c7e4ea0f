#include "protocol/rtde_wire.hpp"

#include <algorithm>

#include "protocol/big_endian.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::protocol {
namespace {

constexpr std::size_t kRtdeHeader = 3;
constexpr std::size_t kMaxPacket = 65535;
constexpr std::size_t kRtdeLongestText = 255;
constexpr std::size_t kKeptBytes = 1 << 16;  // consumed bytes are dropped beyond this

bool is_known(std::uint8_t type) {
  for (const RtdeKind kind :
       {RtdeKind::kSetupInputs, RtdeKind::kTextMessage, RtdeKind::kSetupOutputs, RtdeKind::kPause,
        RtdeKind::kStart, RtdeKind::kDataPackage, RtdeKind::kProtocolVersion, RtdeKind::kControlVersion})
    if (static_cast<std::uint8_t>(kind) == type) return true;
  return false;
}

void put_text(std::string& out, std::string_view text) {
  const std::size_t length = std::min(text.size(), kRtdeLongestText);
  put(out, static_cast<std::uint8_t>(length));
  out.append(text.substr(0, length));
}

std::string take_text(BigEndianReader& in) {
  return std::string(in.take(in.get<std::uint8_t>()));
}

bool has_recipe(int protocol, bool from_controller) {
  return protocol >= 2 || !from_controller;
}

}  // namespace

std::string encode(const RtdePacket& packet) {
  const std::size_t size = packet.payload.size() + kRtdeHeader;
  require(size <= kMaxPacket, "an RTDE packet holds ", kMaxPacket, " bytes at most, not ", size);
  std::string bytes;
  put(bytes, static_cast<std::uint16_t>(size));
  put(bytes, static_cast<std::uint8_t>(packet.kind));
  return bytes + packet.payload;
}

void RtdeStream::feed(std::string_view bytes) {
  if (!problem_.empty()) return;
  if (begin_ > kKeptBytes || begin_ == bytes_.size()) {
    bytes_.erase(0, begin_);
    begin_ = 0;
  }
  bytes_.append(bytes);
}

std::optional<RtdePacket> RtdeStream::next() {
  if (!problem_.empty() || bytes_.size() - begin_ < kRtdeHeader) return std::nullopt;
  BigEndianReader in(std::string_view(bytes_).substr(begin_));
  const auto size = in.get<std::uint16_t>();
  const auto type = in.get<std::uint8_t>();
  if (size < kRtdeHeader || size > max_)
    problem_ = concat("RTDE packet of ", size, " bytes (", kRtdeHeader, " to ", max_, " expected)");
  else if (!is_known(type))
    problem_ = concat("RTDE packet of unknown type ", int{type});
  if (!problem_.empty() || bytes_.size() - begin_ < size) return std::nullopt;
  RtdePacket packet{static_cast<RtdeKind>(type), std::string(in.take(size - kRtdeHeader))};
  begin_ += size;
  return packet;
}

RtdePacket encode_protocol_request(std::uint16_t version) {
  RtdePacket packet{RtdeKind::kProtocolVersion, {}};
  put(packet.payload, version);
  return packet;
}

std::optional<std::uint16_t> decode_protocol_request(const RtdePacket& packet) {
  BigEndianReader in(packet.payload);
  const auto version = in.get<std::uint16_t>();
  if (packet.kind != RtdeKind::kProtocolVersion || !in.finished()) return std::nullopt;
  return version;
}

RtdePacket encode_accepted(RtdeKind kind, bool accepted) {
  RtdePacket packet{kind, {}};
  put(packet.payload, accepted);
  return packet;
}

std::optional<bool> decode_accepted(const RtdePacket& packet, RtdeKind kind) {
  BigEndianReader in(packet.payload);
  const bool accepted = in.get<bool>();
  if (packet.kind != kind || !in.finished()) return std::nullopt;
  return accepted;
}

RtdePacket encode_control_version(const UrVersion& version) {
  RtdePacket packet{RtdeKind::kControlVersion, {}};
  for (const std::uint32_t part : {version.major, version.minor, version.bugfix, version.build})
    put(packet.payload, part);
  return packet;
}

std::optional<UrVersion> decode_control_version(const RtdePacket& packet) {
  BigEndianReader in(packet.payload);
  UrVersion version;
  for (auto* part : {&version.major, &version.minor, &version.bugfix, &version.build}) in.get(*part);
  if (packet.kind != RtdeKind::kControlVersion || !in.finished()) return std::nullopt;
  return version;
}

RtdePacket encode_text(const RtdeText& text, int protocol) {
  RtdePacket packet{RtdeKind::kTextMessage, {}};
  const auto level = static_cast<std::uint8_t>(text.level);
  if (protocol >= 2) {
    put_text(packet.payload, text.message);
    put_text(packet.payload, text.source);
    put(packet.payload, level);
  } else {
    put(packet.payload, level);
    packet.payload.append(text.message.substr(0, kRtdeLongestText));
  }
  return packet;
}

std::optional<RtdeText> decode_text(const RtdePacket& packet, int protocol) {
  BigEndianReader in(packet.payload);
  RtdeText text;
  std::uint8_t level = 0;
  if (protocol >= 2) {
    text.message = take_text(in);
    text.source = take_text(in);
    in.get(level);
  } else {
    in.get(level);
    text.message = std::string(in.take(in.rest().size()));
  }
  if (packet.kind != RtdeKind::kTextMessage || !in.finished()) return std::nullopt;
  text.level = static_cast<RtdeText::Level>(std::min<std::uint8_t>(level, 3));
  return text;
}

RtdePacket encode_output_setup(const RtdeSetup& setup, int protocol) {
  RtdePacket packet{RtdeKind::kSetupOutputs, {}};
  if (protocol >= 2) put(packet.payload, setup.frequency);
  packet.payload += join_names(setup.names);
  return packet;
}

std::optional<RtdeSetup> decode_output_setup(const RtdePacket& packet, int protocol) {
  BigEndianReader in(packet.payload);
  RtdeSetup setup;
  if (protocol >= 2) in.get(setup.frequency);
  if (packet.kind != RtdeKind::kSetupOutputs || !in.sound()) return std::nullopt;
  setup.names = split_names(in.rest());
  return setup;
}

RtdePacket encode_input_setup(const std::vector<std::string>& names) {
  return {RtdeKind::kSetupInputs, join_names(names)};
}

std::optional<RtdeSetup> decode_input_setup(const RtdePacket& packet) {
  if (packet.kind != RtdeKind::kSetupInputs) return std::nullopt;
  return RtdeSetup{split_names(packet.payload), 0.0};
}

RtdePacket encode_setup_reply(RtdeKind kind, const RtdeSetupReply& reply, int protocol) {
  RtdePacket packet{kind, {}};
  if (has_recipe(protocol, kind == RtdeKind::kSetupOutputs)) put(packet.payload, reply.recipe);
  packet.payload += join_names(reply.types);
  return packet;
}

std::optional<RtdeSetupReply> decode_setup_reply(const RtdePacket& packet, RtdeKind kind, int protocol) {
  BigEndianReader in(packet.payload);
  RtdeSetupReply reply;
  if (has_recipe(protocol, kind == RtdeKind::kSetupOutputs)) in.get(reply.recipe);
  if (packet.kind != kind || !in.sound()) return std::nullopt;
  reply.types = split_names(in.rest());
  return reply;
}

RtdePacket encode_data(const RtdeData& data, int protocol, bool from_controller) {
  RtdePacket packet{RtdeKind::kDataPackage, {}};
  if (has_recipe(protocol, from_controller)) put(packet.payload, data.recipe);
  for (const RtdeValue& value : data.values)
    std::visit([&packet](const auto& v) { put(packet.payload, v); }, value);
  return packet;
}

std::optional<RtdeData> decode_data(const RtdePacket& packet, const std::vector<RtdeType>& types,
                                    int protocol, bool from_controller) {
  BigEndianReader in(packet.payload);
  RtdeData data;
  if (has_recipe(protocol, from_controller)) in.get(data.recipe);
  std::size_t size = 0;
  for (const RtdeType type : types) size += rtde_size(type);
  if (packet.kind != RtdeKind::kDataPackage || !in.sound() || in.rest().size() != size) return std::nullopt;
  data.values.reserve(types.size());
  for (const RtdeType type : types) {
    data.values.push_back(rtde_zero(type));
    std::visit([&in](auto& v) { in.get(v); }, data.values.back());
  }
  return data;
}

std::optional<std::uint8_t> data_recipe(const RtdePacket& packet) {
  if (packet.kind != RtdeKind::kDataPackage || packet.payload.empty()) return std::nullopt;
  return static_cast<std::uint8_t>(packet.payload.front());
}

std::string join_names(const std::vector<std::string>& names) {
  std::string joined;
  for (const std::string& name : names) joined += (joined.empty() ? "" : ",") + name;
  return joined;
}

std::vector<std::string> split_names(std::string_view joined) {
  std::vector<std::string> names;
  while (!joined.empty()) {
    const std::size_t comma = std::min(joined.find(','), joined.size());
    names.emplace_back(joined.substr(0, comma));
    joined.remove_prefix(std::min(comma + 1, joined.size()));
  }
  return names;
}

}  // namespace stonestack::protocol
