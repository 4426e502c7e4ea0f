#include <array>

#include "core/socket.hpp"
#include "hardware/constants.hpp"
#include "hardware/robotiq/two_finger_gripper.hpp"
#include "protocol/gripper_text.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

/// Peers of the text socket see their answers in one piece, mostly without a line end: silence of
/// `ModbusOptions::quiet` ends one.
class UrCapLink final : public TwoFingerLink {
 public:
  explicit UrCapLink(const TwoFingerOptions& options)
      : options_(options.modbus),
        peer_{options.modbus.address, options.modbus.port},
        name_("Robotiq gripper at " + to_text(peer_) + " (URCap)") {
    require(options_.attempts >= 1, name_, ": at least one attempt is needed, got ", options_.attempts);
  }

  TwoFingerStatus read() override {
    TwoFingerStatus s;
    s.active = get("ACT") == 1;
    s.go = get("GTO") == 1;
    s.stage = static_cast<TwoFingerStatus::Stage>(get("STA", 3));
    s.fault = get("FLT", 15);
    s.request = get("PRE");
    s.object = static_cast<TwoFingerStatus::Object>(get("OBJ", 3));
    s.position = get("POS");
    return s;
  }

  void write(const TwoFingerRequest& request) override {
    std::vector<GripperVariable> set{{"ACT", request.active ? 1 : 0}, {"GTO", request.go ? 1 : 0}};
    if (request.go) {
      set.emplace_back("SPE", request.speed);
      set.emplace_back("FOR", request.force);
      set.emplace_back("POS", request.position);
    }
    ask(set_text(set), [](const std::string& answer) { return is_gripper_ack(answer); });
  }

  [[nodiscard]] const std::string& name() const override { return name_; }

 private:
  int get(const std::string& variable, int max = 255) {
    std::optional<int> value;
    ask(get_text(variable), [&](const std::string& answer) {
      value = parse_gripper_answer(answer, variable);
      return value && *value <= max;
    });
    return *value;
  }

  /// Sends a line until its answer is the right one. After anything else the connection is made anew: a late
  /// answer must not be taken for the next one.
  template <class IsRight>
  void ask(const std::string& line, const IsRight& is_right) {
    std::string problem, remedy;
    for (int attempt = 0; attempt < options_.attempts; ++attempt) {
      try {
        const std::string answer = exchange(line);
        if (is_right(answer)) return;
        problem = "answers '" + line.substr(0, line.size() - 1) + "' with '" + printable(answer) + "'";
        remedy = answer.rfind('?', 0) == 0
                     ? "see on the pendant (Installation, URCaps, Gripper) that the gripper is connected"
                     : "is this the port of Robotiq's URCap (63352), and a 2-finger gripper or Hand-E?";
      } catch (const DeviceError& error) {
        problem = error.what();
        remedy = "see that the robot runs, Robotiq's URCap is installed and its gripper is connected";
      }
      stream_.reset();
    }
    throw DeviceError(name_, problem, remedy);
  }

  std::string exchange(const std::string& line) {
    const Deadline deadline = Deadline::in(options_.reply_timeout).or_interrupt();
    if (!stream_)
      stream_ = std::make_unique<TcpStream>(
          TcpStream::connect(peer_, Deadline::in(kConnectTimeout).or_interrupt()));
    stream_->discard_input();
    if (const IoResult sent = stream_->write_all(line, deadline); !sent) lost(sent.status);
    std::string answer;
    while (is_gripper_text(answer) && answer.find('\n') == std::string::npos) {
      std::array<std::uint8_t, 64> part;
      const Deadline next = answer.empty() ? deadline : Deadline::in(options_.quiet).or_in(deadline.left());
      const IoResult got = stream_->read_some(part, next);
      answer.append(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(got.bytes));
      if (got) continue;
      if (got.status == IoStatus::kTimeOut && !answer.empty()) return answer;
      lost(got.status);
    }
    return answer;
  }

  [[noreturn]] void lost(IoStatus status) const {
    throw DeviceError(to_text(peer_),
                      status == IoStatus::kClosed ? "the connection was closed"
                                                  : concat("no answer within ", options_.reply_timeout, " s"),
                      "try again");
  }

  static std::string printable(const std::string& answer) {
    std::string text;
    for (const char c : answer.substr(0, kMaxGripperLine)) text += c >= ' ' && c <= '~' ? c : '.';
    return text;
  }

  ModbusOptions options_;
  Endpoint peer_;
  std::string name_;
  std::unique_ptr<TcpStream> stream_;
};

}  // namespace

std::unique_ptr<TwoFingerLink> make_urcap_link(const TwoFingerOptions& options) {
  return std::make_unique<UrCapLink>(options);
}

}  // namespace stonestack::hardware
