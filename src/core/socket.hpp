#pragma once
#include <optional>
#include <string>

#include "core/byte_stream.hpp"

/// TCP over IPv4. Loopback is the rule: a server listens elsewhere only on request.
namespace stonestack::core {

/// An IPv4 address ("127.0.0.1", "192.168.1.11") or "localhost", and a port. To connect it may also be a name
/// in the network ("ur10.lab.local"), which `TcpStream::connect` looks up.
struct Endpoint {
  std::string address = "127.0.0.1";
  int port = 0;
};
/// "address:port".
[[nodiscard]] std::string to_text(const Endpoint& endpoint);
/// True for 127.x.y.z and "localhost". Looks up no name.
/// @throws InvalidArgument for what is not an address.
[[nodiscard]] bool is_loopback(const std::string& address);

/// One TCP connection, with TCP_NODELAY and keep-alive (a dead peer is noticed after about half a minute).
class TcpStream : public ByteStream {
 public:
  using ByteStream::ByteStream;
  /// Throws DeviceError naming "address:port" when the peer refuses, does not answer before the deadline or
  /// cannot be reached, and when its name has no IPv4 address or is not looked up before the deadline;
  /// InvalidArgument for a bad port and for what is neither address nor name.
  [[nodiscard]] static TcpStream connect(const Endpoint& peer, Deadline deadline);
};

struct ListenOptions {
  std::string address = "127.0.0.1";  ///< any 127.x.y.z
  int port = 0;                       ///< 0: a free one, see TcpListener::endpoint
  bool allow_remote = false;          ///< other addresses than loopback
  int waiting = 16;                   ///< connections that may wait to be accepted
};

/// A listening socket.
class TcpListener {
 public:
  /// Throws InvalidArgument for an address that is not loopback unless `allow_remote`, DeviceError when the
  /// port is taken or needs rights that the process does not have.
  explicit TcpListener(const ListenOptions& options);
  /// The next connection; empty at the deadline and after `close`.
  [[nodiscard]] std::optional<TcpStream> accept(Deadline deadline);
  /// Wakes a waiting `accept`, for good. The port is free again when the listener is destroyed. Thread-safe.
  void close() noexcept;
  [[nodiscard]] bool is_closed() const;
  /// The address and the port that was really taken.
  [[nodiscard]] const Endpoint& endpoint() const { return endpoint_; }

 private:
  Descriptor socket_;
  Descriptor wake_;
  Endpoint endpoint_;
};

}  // namespace stonestack::core
