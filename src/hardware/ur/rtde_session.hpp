#pragma once
#include <functional>
#include <memory>
#include <mutex>

#include "hardware/ur/rtde_client.hpp"

/// One RTDE connection from V to S: what has to be done again after every loss of the link.
namespace stonestack::hardware {

/// An input is owned by somebody else; worth another attempt.
class RtdeInUse : public DeviceError {
 public:
  using DeviceError::DeviceError;
};

using RtdeTextSink = std::function<void(const RtdeText&)>;

class RtdeSession {
 public:
  /// Connects and does the whole setup. Throws DeviceError, RtdeInUse among them; Interrupted after Ctrl-C if
  /// the setup may be `interruptible`.
  RtdeSession(const Endpoint& controller, const RtdeRecipeFor& recipe, const RtdeOptions& options,
              RtdeTextSink text_sink, bool interruptible = false);

  /// The next data of the output recipe; empty at the deadline. Texts go to the sink. Throws DeviceError when
  /// the link is closed or out of step. `refused` counts packets that were not as set up.
  [[nodiscard]] std::optional<RtdeData> receive(Deadline deadline, long& refused);
  void send(std::size_t recipe, const std::vector<RtdeValue>& values);
  void shut() { socket_.shut(); }

  int protocol = 1;
  UrVersion version;
  double frequency = 0.0;
  std::shared_ptr<const std::vector<std::string>> outputs;
  std::vector<std::string> missing;

 private:
  struct Input {
    std::uint8_t recipe = 0;
    std::vector<std::string> names;
    std::vector<RtdeType> types;
  };

  void agree_on_protocol();
  void read_version();
  void set_up_outputs(const RtdeRecipe& recipe);
  void set_up_inputs(const std::vector<std::string>& names);
  void start();
  RtdeSetupReply request_setup(const RtdePacket& request, std::size_t names);
  /// The reply of that kind; texts and data before it are passed over.
  RtdePacket request(const RtdePacket& packet);
  /// Throws DeviceError unless the controller reports the type that the field has (`known` may be null).
  void require_type(const std::string& name, RtdeType reported, const RtdeField* known) const;
  /// The types of `names`; those that the controller does not have go to `not_found`.
  std::vector<RtdeType> read_types(const std::vector<std::string>& names, const RtdeSetupReply& reply,
                                   std::vector<std::string>& not_found) const;
  /// Empty at the deadline, however much the controller sends.
  std::optional<RtdePacket> next_packet(Deadline deadline);
  void write(const RtdePacket& packet);
  [[noreturn]] void fail(const std::string& problem, const std::string& next_step) const;

  std::string name_;
  const RtdeOptions options_;
  const bool interruptible_;
  RtdeTextSink text_sink_;
  TcpStream socket_;
  RtdeStream stream_;
  std::mutex writing_;
  std::uint8_t output_recipe_ = 0;
  std::vector<RtdeType> output_types_;
  std::vector<Input> inputs_;
};

}  // namespace stonestack::hardware
