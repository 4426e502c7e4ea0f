#include "report/live_server.hpp"

#include <httplib.h>
#include <signal.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "stonestack/core/error.hpp"

namespace stonestack::report {
namespace {

constexpr int kMaxStreams = 16;            // each holds a thread
constexpr std::size_t kThreads = 24;       // leaves some for pages and the stop
constexpr int kSendBuffer = 256 * 1024;    // bytes: a client that does not read is noticed
constexpr time_t kPatience = 2;            // s, for a client that neither reads nor writes
constexpr std::chrono::seconds kPulse{2};  // a comment that shows whether the client is still there

/// The policy of the page: its own scripts and styles, nothing from elsewhere, in no frame.
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:; connect-src "
    "'self'; "
    "form-action 'none'; base-uri 'none'; frame-ancestors 'none'";

std::string make_token() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    throw Error("no random numbers for the stop token of the live view", ExitCode::kInternal);
  static constexpr const char* kDigits = "0123456789abcdef";
  std::string token;
  for (const unsigned char byte : bytes) (token += kDigits[byte >> 4U]) += kDigits[byte & 15U];
  return token;
}

/// Compares in a time that does not depend on where they differ.
bool same_secret(const std::string& given, const std::string& secret) {
  unsigned difference = given.size() == secret.size() ? 0U : 1U;
  for (std::size_t i = 0; i < secret.size(); ++i)
    difference |= static_cast<unsigned char>(i < given.size() ? given[i] : '\0') ^
                  static_cast<unsigned char>(secret[i]);
  return difference == 0U;
}

/// True for a name of this machine with or without a port: an SSH tunnel has another one.
bool is_this_machine(std::string host) {
  const std::size_t colon = host.find(':', host.starts_with('[') ? host.find(']') : 0);
  host = host.substr(0, colon);
  std::transform(host.begin(), host.end(), host.begin(), [](unsigned char c) { return std::tolower(c); });
  return host == "localhost" || host == "127.0.0.1" || host == "[::1]";
}

/// Host of "http://HOST:PORT".
std::string host_of(const std::string& origin) {
  const std::size_t slashes = origin.find("://");
  return slashes == std::string::npos ? "" : origin.substr(slashes + 3);
}

/// Number of the first message that a client has not seen: that of its header or its query.
std::size_t first_wanted(const httplib::Request& request) {
  const std::string last = request.get_header_value("Last-Event-ID");
  if (last.empty() || last.size() > 9 || last.find_first_not_of("0123456789") != std::string::npos) return 0;
  return std::stoul(last) + 1;
}

/// Signals go to the threads of the program: while one lives, threads that are started block them.
class BlockedSignals {
 public:
  BlockedSignals() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~BlockedSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

 private:
  sigset_t before_{};
};

/// The library ignores SIGPIPE in the whole process: what it was before comes back.
class KeptPipeSignal {
 public:
  KeptPipeSignal() { sigaction(SIGPIPE, nullptr, &before_); }
  ~KeptPipeSignal() { sigaction(SIGPIPE, &before_, nullptr); }
  KeptPipeSignal(const KeptPipeSignal&) = delete;
  KeptPipeSignal& operator=(const KeptPipeSignal&) = delete;

 private:
  struct sigaction before_ {};
};

}  // namespace

struct LiveServer::State {
  std::unique_ptr<httplib::Server> server;
  std::thread thread;
  std::string token = make_token();
  int port = 0;
  std::function<void()> stop;

  mutable std::mutex mutex;
  std::condition_variable changed;
  std::shared_ptr<const std::string> page;
  std::vector<std::shared_ptr<const std::string>> messages;  // null: replaced by a later one
  int clients = 0;
  bool ended = false;    // no message follows
  bool closing = false;  // nobody waits any more

  void serve_page(httplib::Response& response) const {
    std::shared_ptr<const std::string> now;
    {
      const std::lock_guard lock(mutex);
      now = page;
    }
    response.set_content(*now, "text/html; charset=utf-8");
  }

  void serve_events(const httplib::Request& request, httplib::Response& response) {
    {
      const std::lock_guard lock(mutex);
      if (clients >= kMaxStreams || closing) {
        response.status = 503;
        response.set_content("too many viewers\n", "text/plain");
        return;
      }
      ++clients;
    }
    const auto next = std::make_shared<std::size_t>(first_wanted(request));
    response.set_chunked_content_provider(
        "text/event-stream",
        [this, next](std::size_t, httplib::DataSink& sink) { return send_next(*next, sink); },
        [this](bool) {
          const std::lock_guard lock(mutex);
          --clients;
          changed.notify_all();
        });
  }

  /// Sends one message, or a sign of life; false for a client that does not take it.
  bool send_next(std::size_t& next, httplib::DataSink& sink) {
    static const std::string kAlive = ":\n\n";
    std::shared_ptr<const std::string> message;
    {
      std::unique_lock lock(mutex);
      changed.wait_for(lock, kPulse, [&] { return closing || ended || next < messages.size(); });
      while (next < messages.size() && !messages[next]) ++next;
      if (closing || (ended && next >= messages.size())) {
        lock.unlock();
        sink.done();
        return true;
      }
      if (next < messages.size()) message = messages[next];
    }
    const std::string& text = message ? *message : kAlive;
    if (!sink.write(text.data(), text.size())) return false;
    if (message) ++next;
    return true;
  }

  void serve_stop(const httplib::Request& request, httplib::Response& response) const {
    const std::string origin = request.get_header_value("Origin");
    if ((!origin.empty() && !is_this_machine(host_of(origin))) ||
        !same_secret(request.get_header_value("X-Stop-Token"), token)) {
      response.status = 403;
      response.set_content("the stop token is the one that was printed beside the address\n", "text/plain");
      return;
    }
    response.set_content("stopping\n", "text/plain");
    stop();
  }

  void set_up() {
    server->new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
    server->set_keep_alive_max_count(1);  // an idle connection would hold a thread
    server->set_read_timeout(kPatience);
    server->set_write_timeout(kPatience);
    server->set_keep_alive_timeout(kPatience);
    server->set_payload_max_length(1024);
    server->set_tcp_nodelay(true);
    server->set_socket_options(
        [](int socket) {  // connections inherit them; no SO_REUSEPORT: nobody shares the port
          const int yes = 1;
          const timeval patience{kPatience, 0};
          ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
          ::setsockopt(socket, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
          ::setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &kSendBuffer, sizeof kSendBuffer);
        });
    server->set_default_headers({{"Content-Security-Policy", kPolicy},
                                 {"X-Content-Type-Options", "nosniff"},
                                 {"Referrer-Policy", "no-referrer"},
                                 {"Cache-Control", "no-store"}});
    server->set_pre_routing_handler([](const httplib::Request& request, httplib::Response& response) {
      if (request.get_header_value_count("Host") == 1 && is_this_machine(request.get_header_value("Host")))
        return httplib::Server::HandlerResponse::Unhandled;
      response.status = 403;
      response.set_content("the live view answers to localhost and 127.0.0.1 only\n", "text/plain");
      return httplib::Server::HandlerResponse::Handled;
    });
    server->Get("/", [this](const httplib::Request&, httplib::Response& response) { serve_page(response); });
    server->Get("/events", [this](const httplib::Request& request, httplib::Response& response) {
      serve_events(request, response);
    });
    server->Post("/stop", [this](const httplib::Request& request, httplib::Response& response) {
      serve_stop(request, response);
    });
  }
};

LiveServer::LiveServer(int port, std::string page, std::function<void()> stop)
    : state_(std::make_unique<State>()) {
  State& state = *state_;
  {
    const KeptPipeSignal kept;
    state.server = std::make_unique<httplib::Server>();
  }
  state.page = std::make_shared<const std::string>(std::move(page));
  state.stop = std::move(stop);
  state.set_up();
  if (port == 0) {
    state.port = state.server->bind_to_any_port("127.0.0.1");
    if (state.port <= 0) throw Error("the live view finds no free port on 127.0.0.1", ExitCode::kUnreadable);
  } else {
    require(state.server->bind_to_port("127.0.0.1", port), "port ", port,
            " is taken: name another one for the live view, or 0 for any");
    state.port = port;
  }
  const BlockedSignals blocked;
  state.thread = std::thread([&state] { state.server->listen_after_bind(); });
  while (!state.server->is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

LiveServer::~LiveServer() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->closing = true;
  }
  state_->changed.notify_all();
  state_->server->stop();
  state_->thread.join();
}

std::string LiveServer::address() const {
  return concat("http://127.0.0.1:", state_->port, "/");
}

const std::string& LiveServer::stop_token() const {
  return state_->token;
}

int LiveServer::clients() const {
  const std::lock_guard lock(state_->mutex);
  return state_->clients;
}

void LiveServer::set_page(std::string page) {
  auto next = std::make_shared<const std::string>(std::move(page));
  const std::lock_guard lock(state_->mutex);
  state_->page = std::move(next);
}

void LiveServer::publish(const std::string& event, const std::string& data, bool replaces) {
  {
    const std::lock_guard lock(state_->mutex);
    auto& messages = state_->messages;
    if (replaces)
      for (auto& message : messages) message.reset();
    messages.push_back(std::make_shared<const std::string>(
        concat("id: ", messages.size(), "\nevent: ", event, "\ndata: ", data, "\n\n")));
  }
  state_->changed.notify_all();
}

void LiveServer::finish(double seconds) {
  std::unique_lock lock(state_->mutex);
  state_->ended = true;
  state_->changed.notify_all();
  state_->changed.wait_for(lock, std::chrono::duration<double>(seconds),
                           [&] { return state_->clients == 0; });
}

}  // namespace stonestack::report
