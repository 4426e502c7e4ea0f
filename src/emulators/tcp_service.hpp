#pragma once
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <thread>

#include "core/socket.hpp"

namespace stonestack::emulators {

/// For devices whose clients may be waited for; the simulated UR controller, which hears all of its own
/// between two control steps, has ServerPort. Accepts TCP clients and serves each in a thread of its own.
/// `serve` returns when its stream is closed; destroying the service shuts all streams and waits for the
/// threads.
class TcpService {
 public:
  using Serve = std::function<void(TcpStream&)>;
  /// Listens at once; more than `max_clients` at a time are sent away. Throws as TcpListener does.
  TcpService(const ListenOptions& options, Serve serve, int max_clients = 16);
  ~TcpService();
  TcpService(const TcpService&) = delete;
  TcpService& operator=(const TcpService&) = delete;

  [[nodiscard]] const Endpoint& endpoint() const { return listener_.endpoint(); }
  /// Clients that are connected now.
  [[nodiscard]] int clients();
  /// Ends every connection; new ones are welcome.
  void drop_clients();

 private:
  struct Client {
    explicit Client(TcpStream accepted) : stream(std::move(accepted)) {}
    TcpStream stream;
    bool done = false;
    std::thread thread;
  };
  void accept_clients();
  void admit(TcpStream stream);
  void run(Client& client);
  void sweep();

  TcpListener listener_;
  Serve serve_;
  int max_clients_;
  std::mutex mutex_;  // of the list and the `done` marks
  std::list<Client> clients_;
  std::thread acceptor_;
};

}  // namespace stonestack::emulators
