#pragma once
#include <array>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "hardware/fake_server.hpp"
#include "protocol/hex.hpp"
#include "protocol/rtde_wire.hpp"

namespace stonestack::hardware {

/// Answers of a scripted RTDE controller: bytes by the request's letter. A request without an answer is met
/// with silence. Answers to the same letter are used one after the other, the last one for ever.
struct FakeRtdePlan {
  std::map<char, std::vector<std::string>> replies;
  std::string before_reply;  ///< sent before every reply
  bool byte_by_byte = false;
  /// The n-th data packet after START, or empty: no more, wait for the client to go.
  std::function<std::string(long)> data;
  bool drop_after_data = false;  ///< close when there is no more, instead of falling silent
};

/// Serves one connection after a plan; keeps every request for the test.
class FakeRtde {
 public:
  explicit FakeRtde(std::function<FakeRtdePlan(int)> plan_of)
      : plan_of_(std::move(plan_of)), server_([this](TcpStream& s, int n) { serve(s, plan_of_(n)); }) {}
  ~FakeRtde() { server_.stop(); }

  [[nodiscard]] Endpoint endpoint() const { return server_.endpoint(); }
  [[nodiscard]] int connections() const { return server_.connections(); }
  [[nodiscard]] std::vector<RtdePacket> requests(RtdeKind kind) {
    const std::lock_guard lock(mutex_);
    std::vector<RtdePacket> found;
    for (const RtdePacket& packet : requests_)
      if (packet.kind == kind) found.push_back(packet);
    return found;
  }

 private:
  static void write(TcpStream& stream, const std::string& bytes, bool byte_by_byte) {
    const std::size_t step = byte_by_byte ? 1 : bytes.size();
    for (std::size_t i = 0; i < bytes.size(); i += step)
      if (!stream.write_all(std::string_view(bytes).substr(i, step), Deadline::in(1.0)))
        throw DeviceError("fake RTDE", "client gone", "none");
  }

  void answer(TcpStream& stream, const FakeRtdePlan& plan, const RtdePacket& request,
              std::map<char, std::size_t>& used) {
    {
      const std::lock_guard lock(mutex_);
      requests_.push_back(request);
    }
    const char letter = static_cast<char>(request.kind);
    const auto replies = plan.replies.find(letter);
    if (replies == plan.replies.end()) return;
    const std::size_t n = std::min(used[letter]++, replies->second.size() - 1);
    write(stream, plan.before_reply + replies->second[n], plan.byte_by_byte);
  }

  void serve(TcpStream& stream, const FakeRtdePlan& plan) {
    std::map<char, std::size_t> used;
    RtdeStream parser;
    bool started = false;
    long sent = 0;
    while (!server_.ending()) {
      std::array<std::uint8_t, 4096> bytes{};
      const IoResult read = stream.read_some(bytes, Deadline::in(started ? 0.001 : 0.02));
      if (read.status == IoStatus::kClosed) return;
      parser.feed({reinterpret_cast<const char*>(bytes.data()), read.bytes});
      while (const auto request = parser.next()) {
        answer(stream, plan, *request, used);
        started = started || (request->kind == RtdeKind::kStart && plan.replies.count('S') > 0);
      }
      if (!started || !plan.data) continue;
      const std::string packet = plan.data(sent);
      if (packet.empty() && plan.drop_after_data) return;
      if (packet.empty()) continue;
      write(stream, packet, plan.byte_by_byte);
      ++sent;
    }
  }

  std::function<FakeRtdePlan(int)> plan_of_;
  std::mutex mutex_;
  std::vector<RtdePacket> requests_;
  FakeServer server_;
};

}  // namespace stonestack::hardware
