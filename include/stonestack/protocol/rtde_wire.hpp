#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "stonestack/protocol/rtde_fields.hpp"

#pragma GCC visibility push(default)

/// RTDE packets, both directions, big-endian: `uint16 size` (with these three bytes), `uint8 type`, payload.
/// Encoders throw InvalidArgument for what does not fit; decoders return nothing for what is malformed, so
/// that a peer's bytes can never do more than be refused. Used by the client and by the simulator.
namespace stonestack::protocol {

enum class RtdeKind : std::uint8_t {
  kSetupInputs = 73,      // I
  kTextMessage = 77,      // M
  kSetupOutputs = 79,     // O
  kPause = 80,            // P
  kStart = 83,            // S
  kDataPackage = 85,      // U
  kProtocolVersion = 86,  // V
  kControlVersion = 118,  // v
};

/// One packet without its header.
struct RtdePacket {
  RtdeKind kind = RtdeKind::kTextMessage;
  std::string payload;
};
/// With its header. Throws InvalidArgument above 65535 bytes.
[[nodiscard]] std::string encode(const RtdePacket& packet);

/// Cuts a byte stream into packets, however the bytes arrive. A length below 3 or above `max`, or an
/// unknown type, means that the two sides are out of step: the stream is broken and stays so, and the only
/// way on is a new connection.
class RtdeStream {
 public:
  explicit RtdeStream(std::size_t max = 4096) : max_(max) {}
  void feed(std::string_view bytes);
  /// The next whole packet, or nothing: more bytes are needed, or `problem()` says what is broken.
  [[nodiscard]] std::optional<RtdePacket> next();
  /// Empty while the stream is sound.
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  std::size_t max_;
  std::string bytes_;
  std::size_t begin_ = 0;
  std::string problem_;
};

/// V: what protocol the client wants.
[[nodiscard]] RtdePacket encode_protocol_request(std::uint16_t version);
[[nodiscard]] std::optional<std::uint16_t> decode_protocol_request(const RtdePacket& packet);
/// V, S, P: the controller's yes or no. `kind` is the request's.
[[nodiscard]] RtdePacket encode_accepted(RtdeKind kind, bool accepted);
[[nodiscard]] std::optional<bool> decode_accepted(const RtdePacket& packet, RtdeKind kind);
/// v: the request is empty; the reply holds four numbers.
[[nodiscard]] RtdePacket encode_control_version(const UrVersion& version);
[[nodiscard]] std::optional<UrVersion> decode_control_version(const RtdePacket& packet);

/// M: what either side may say at any time. Texts are cut at 255 bytes; protocol 1 has no source.
struct RtdeText {
  enum class Level : std::uint8_t { kException, kError, kWarning, kInfo };
  std::string message;
  std::string source;
  Level level = Level::kInfo;
};
[[nodiscard]] RtdePacket encode_text(const RtdeText& text, int protocol);
[[nodiscard]] std::optional<RtdeText> decode_text(const RtdePacket& packet, int protocol);

/// O and I, client to controller. `frequency` (Hz) is sent with outputs in protocol 2 only. The decoder takes
/// a trailing comma, as ur_rtde sends it.
struct RtdeSetup {
  std::vector<std::string> names;
  double frequency = 0.0;
};
[[nodiscard]] RtdePacket encode_output_setup(const RtdeSetup& setup, int protocol);
[[nodiscard]] std::optional<RtdeSetup> decode_output_setup(const RtdePacket& packet, int protocol);
[[nodiscard]] RtdePacket encode_input_setup(const std::vector<std::string>& names);
[[nodiscard]] std::optional<RtdeSetup> decode_input_setup(const RtdePacket& packet);

/// O and I, controller to client: one entry per name in its order, a type or NOT_FOUND or IN_USE. Outputs
/// have no recipe id in protocol 1.
struct RtdeSetupReply {
  std::uint8_t recipe = 0;
  std::vector<std::string> types;
};
[[nodiscard]] RtdePacket encode_setup_reply(RtdeKind kind, const RtdeSetupReply& reply, int protocol);
[[nodiscard]] std::optional<RtdeSetupReply> decode_setup_reply(const RtdePacket& packet, RtdeKind kind,
                                                               int protocol);

/// U: values of a recipe. From the controller in protocol 1 without a recipe id (`from_controller`).
struct RtdeData {
  std::uint8_t recipe = 0;
  std::vector<RtdeValue> values;
};
[[nodiscard]] RtdePacket encode_data(const RtdeData& data, int protocol, bool from_controller);
/// Nothing unless the payload is exactly as long as `types` ask. Doubles may be NaN or infinite: the reader
/// of a field judges that.
[[nodiscard]] std::optional<RtdeData> decode_data(const RtdePacket& packet,
                                                  const std::vector<RtdeType>& types, int protocol,
                                                  bool from_controller);
/// The recipe id of a data packet (protocol 2, or any from a client), for a server that must choose a recipe.
[[nodiscard]] std::optional<std::uint8_t> data_recipe(const RtdePacket& packet);

/// "a,b,c" and back; an empty last entry is dropped.
[[nodiscard]] std::string join_names(const std::vector<std::string>& names);
[[nodiscard]] std::vector<std::string> split_names(std::string_view joined);

}  // namespace stonestack::protocol

#pragma GCC visibility pop
