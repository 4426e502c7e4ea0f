#include "emulators/tcp_service.hpp"

#include <algorithm>
#include <chrono>
#include <exception>

#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::emulators {
namespace {
constexpr double kServiceTurn = 0.5;  // s between checks for threads that ended
constexpr double kServiceRest = 0.1;  // s until it tries again, out of sockets or threads
}  // namespace

TcpService::TcpService(const ListenOptions& options, Serve serve, int max_clients)
    : listener_(options), serve_(std::move(serve)), max_clients_(max_clients) {
  acceptor_ = std::thread([this] { accept_clients(); });
}

TcpService::~TcpService() {
  listener_.close();
  acceptor_.join();
  drop_clients();
  for (auto& client : clients_) client.thread.join();
}

int TcpService::clients() {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(
      std::count_if(clients_.begin(), clients_.end(), [](const Client& client) { return !client.done; }));
}

void TcpService::drop_clients() {
  const std::lock_guard lock(mutex_);
  for (auto& client : clients_) client.stream.shut();
}

void TcpService::sweep() {
  const std::lock_guard lock(mutex_);
  clients_.remove_if([](Client& client) {
    if (client.done) client.thread.join();
    return client.done;
  });
}

void TcpService::accept_clients() {
  bool cannot_accept = false;
  while (!listener_.is_closed()) {
    try {
      auto stream = listener_.accept(Deadline::in(kServiceTurn));
      sweep();
      if (stream && clients() < max_clients_) admit(std::move(*stream));
      cannot_accept = false;
    } catch (const std::exception& problem) {  // those who are there go on
      if (!cannot_accept) log_warning(concat("simulated device: ", problem.what()));
      cannot_accept = true;
      std::this_thread::sleep_for(std::chrono::duration<double>(kServiceRest));
    }
  }
}

void TcpService::admit(TcpStream stream) {
  const std::lock_guard lock(mutex_);
  Client& client = clients_.emplace_back(std::move(stream));
  try {
    client.thread = std::thread([this, &client] { run(client); });
  } catch (...) {
    clients_.pop_back();
    throw;
  }
}

void TcpService::run(Client& client) {
  try {
    serve_(client.stream);
  } catch (const std::exception& problem) {
    log_warning(concat(to_text(endpoint()), ": client ", client.stream.name(), ": ", problem.what()));
  }
  client.stream.shut();
  const std::lock_guard lock(mutex_);
  client.done = true;
}

}  // namespace stonestack::emulators
