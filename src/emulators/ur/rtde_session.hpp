#pragma once
#include <map>
#include <set>

#include "emulators/ur/rtde_access.hpp"
#include "protocol/rtde_wire.hpp"

namespace stonestack::emulators {

/// Owner of each input: a session's number.
using InputOwners = std::map<std::string, int>;

/// The server's side of one RTDE connection, without the socket.
class RtdeSession {
 public:
  /// Both must outlive the session.
  RtdeSession(int number, UrController& controller, InputOwners& owners);
  /// Frees its inputs.
  ~RtdeSession();
  RtdeSession(const RtdeSession&) = delete;
  RtdeSession& operator=(const RtdeSession&) = delete;

  /// Takes what the client sent; the answers, one string a packet.
  [[nodiscard]] std::vector<std::string> feed(std::string_view bytes);
  /// The data package of this control step, if one is due.
  [[nodiscard]] std::optional<std::string> sample();
  /// The client sent what no packet can be: the link must be closed.
  [[nodiscard]] bool broken() const { return !stream_.problem().empty(); }
  [[nodiscard]] bool started() const { return started_; }

 private:
  struct InputRecipe {
    std::vector<std::string> names;
    std::vector<RtdeType> types;
    std::vector<RtdeWriter> writers;
  };

  void answer(const RtdePacket& packet, std::vector<std::string>& replies);
  [[nodiscard]] RtdeSetupReply set_up_outputs(const RtdeSetup& setup);
  [[nodiscard]] RtdeSetupReply set_up_inputs(const RtdeSetup& setup);
  [[nodiscard]] std::string input_state(const std::string& name) const;
  void take_data(const RtdePacket& packet);

  int number_;
  UrController* controller_;
  InputOwners* owners_;
  RtdeStream stream_{65535};
  int protocol_ = 1;
  std::vector<RtdeReader> outputs_;
  double frequency_ = 0.0;
  std::vector<InputRecipe> inputs_;
  bool started_ = false;
  std::uint64_t last_sample_ = 0;
};

}  // namespace stonestack::emulators
