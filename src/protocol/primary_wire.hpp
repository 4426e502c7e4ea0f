#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/ur_version.hpp"

/// Messages of a controller's primary port: packages of `int32 size, uint8 type`, of which robot messages
/// (type 20) report the state of a program. Of robot states (type 16) only the kinematics and the checksum of
/// the safety configuration are read: state comes by RTDE.
namespace stonestack::protocol {

/// A robot message. Which fields mean something depends on the kind.
struct PrimaryMessage {
  enum class Kind : std::uint8_t {
    kText = 0,
    kPopup = 2,
    kVersion = 3,
    kSafetyMode = 5,
    kError = 6,
    kKey = 7,
    kRequestValue = 9,
    kRuntimeException = 10,
  };
  Kind kind = Kind::kText;
  std::uint64_t timestamp = 0;  ///< of the controller, us
  int source = 0;
  std::string text;            ///< kText, kError, kKey, kRuntimeException
  std::string title;           ///< kKey: PROGRAM_XXX_STARTED, PROGRAM_XXX_STOPPED, ...
  int code = 0, argument = 0;  ///< kError, kKey, kSafetyMode: "C210A0"
  int level = 0;               ///< kError
  int line = 0, column = 0;    ///< kRuntimeException: place in the script, from 1
  UrVersion version;           ///< kVersion
};

/// The arm's own DH table (standard DH, absolute: calibration included), of a robot state.
struct PrimaryKinematics {
  std::array<double, 6> theta{}, a{}, d{}, alpha{};  ///< of the joints from the base [m, rad]
};

/// "0A1B2C3D": a checksum of the safety configuration as cells and messages have it.
[[nodiscard]] std::string checksum_text(std::uint32_t checksum);
/// The number of eight hexadecimal digits; empty for what is none.
[[nodiscard]] std::optional<std::uint32_t> parse_checksum(const std::string& text);

/// C210: a script came in on a connection that may only read (robot in local control).
[[nodiscard]] bool is_read_only_error(const PrimaryMessage& message);

/// A whole package of type 20 for tests and for a simulated controller.
[[nodiscard]] std::string encode(const PrimaryMessage& message);

/// Cuts the stream into packages, however the bytes arrive.
class PrimaryStream {
 public:
  explicit PrimaryStream(std::size_t max = 1 << 16) : max_(max) {}
  void feed(std::string_view bytes);
  /// The next robot message of a known kind; other packages are passed over and counted. Empty: more bytes
  /// are needed, or `problem()` names a permanent fault.
  [[nodiscard]] std::optional<PrimaryMessage> next();
  [[nodiscard]] const std::string& problem() const { return problem_; }
  [[nodiscard]] long passed_over() const { return passed_over_; }
  /// Robot states (type 16) among them.
  [[nodiscard]] long states() const { return states_; }
  /// Of the newest state that had them.
  [[nodiscard]] const std::optional<PrimaryKinematics>& kinematics() const { return kinematics_; }
  /// Checksum of the applied safety configuration, of the newest state that had it: the first four bytes of
  /// the state's part 10, which UR does not document (forum.universal-robots.com/t/safety-checksum/988).
  [[nodiscard]] const std::optional<std::uint32_t>& safety_checksum() const { return safety_checksum_; }

 private:
  std::size_t max_;
  std::string bytes_;
  std::size_t begin_ = 0;
  std::string problem_;
  long passed_over_ = 0, states_ = 0;
  std::optional<PrimaryKinematics> kinematics_;
  std::optional<std::uint32_t> safety_checksum_;
};

}  // namespace stonestack::protocol
