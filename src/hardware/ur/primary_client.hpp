#pragma once
#include <atomic>
#include <memory>
#include <optional>
#include <vector>

#include "core/socket.hpp"
#include "protocol/primary_wire.hpp"

namespace stonestack::hardware {

struct PrimaryOptions {
  std::vector<int> ports = {30001, 30002, 30003};  ///< primary, then secondary, then realtime
  double connect_timeout = 2.0;                    ///< each [s]
  double send_timeout = 5.0;                       ///< [s]
};

/// Sends scripts to a controller and receives its reports about them. A thread of its own drains the
/// connection. The realtime port (30003) reports nothing about programs. Thread-safe.
class PrimaryClient {
 public:
  /// Takes the first port that accepts. Interrupted after Ctrl-C.
  /// @throws DeviceError that names all of them.
  PrimaryClient(const std::string& address, const PrimaryOptions& options = {});
  ~PrimaryClient();

  /// Sends a program; one that runs is killed by it. Connects again first if the connection was lost.
  /// @throws DeviceError
  void send(const std::string& script);
  /// Sends a program as `send`, unless `stop` is set when its turn has come, and returns whether it did: a
  /// stop that was set before it was sent itself is not overtaken. Null: nothing can stop it. Does not
  /// connect again.
  /// @throws DeviceError
  [[nodiscard]] bool send_unless(const std::string& script, const std::atomic<bool>* stop);
  /// Connects again if the connection was lost.
  /// @throws DeviceError
  void connect_if_lost();
  /// Closes and connects again: helps after a switch from local to remote control, when an old connection may
  /// only read.
  void reconnect();
  /// Messages since the last call, at most the newest 256.
  [[nodiscard]] std::vector<PrimaryMessage> take_messages();
  /// Waits for a message that only a controller sends: its version, or a state. Throws DeviceError when
  /// nothing or something else comes, Interrupted after Ctrl-C.
  void wait_until_heard(Deadline deadline) const;
  /// The arm's kinematics, once a state has said them; empty where none has within the deadline. Interrupted
  /// after Ctrl-C.
  [[nodiscard]] std::optional<PrimaryKinematics> wait_for_kinematics(Deadline deadline) const;
  /// Checksum of the safety configuration as states of the present connection have it
  /// (`PrimaryStream::safety_checksum`), the newest; empty where none has said it yet.
  [[nodiscard]] std::optional<std::uint32_t> safety_checksum() const;
  /// Waits for that until a state has said it; empty where three states, or the deadline, have passed without
  /// it. Interrupted after Ctrl-C.
  [[nodiscard]] std::optional<std::uint32_t> wait_for_safety_checksum(Deadline deadline) const;
  /// The port in use.
  [[nodiscard]] int port() const;

 private:
  struct Link;
  std::unique_ptr<Link> link_;
};

/// Why a safety configuration with the checksum `found` is not the one that is `wanted` (eight hexadecimal
/// digits; empty: any). Empty: it is.
/// @throws InvalidArgument for a wanted one that is none
[[nodiscard]] std::string describe_other_safety(const std::optional<std::uint32_t>& found,
                                                const std::string& wanted);
/// Remedy for another safety configuration.
inline constexpr const char* kCompareSafety =
    "let whoever may change it compare the safety configuration on the pendant with what the cell needs, "
    "then "
    "write arm.safety_checksum as `stonestack doctor` shows it, or remove the line where the controller says "
    "none";

}  // namespace stonestack::hardware
