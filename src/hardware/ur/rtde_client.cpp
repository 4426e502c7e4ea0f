#include "hardware/ur/rtde_client.hpp"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "hardware/constants.hpp"
#include "hardware/ur/rtde_session.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::hardware {
namespace {

constexpr std::size_t kKeptTexts = 64;
constexpr int kRefusedInARow = 3;
constexpr double kLatest = 1e9;    // s: no controller has run for 30 years
constexpr double kRtdeTurn = 0.1;  // s between checks for Ctrl-C
constexpr double kRestart = 1.0;   // s that a controller's clock goes back only when it restarted

}  // namespace

RtdeSample::RtdeSample(std::shared_ptr<const std::vector<std::string>> names, std::vector<RtdeValue> values,
                       double host_time)
    : names_(std::move(names)), values_(std::move(values)), host_time_(host_time) {}

const RtdeValue* RtdeSample::find(std::string_view name) const {
  if (!names_) return nullptr;
  const auto it = std::find(names_->begin(), names_->end(), name);
  return it == names_->end() ? nullptr : &values_[static_cast<std::size_t>(it - names_->begin())];
}

struct RtdeClient::Link {
  Link(const Endpoint& at, RtdeRecipeFor recipe_for, const RtdeOptions& o)
      : controller(at), recipe(std::move(recipe_for)), options(o) {
    open_first();
    thread = std::thread([this] { run(); });
    wait_until_booted();
  }

  ~Link() { end(); }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  void end() {
    {
      const std::lock_guard lock(mutex);
      ending = true;
      if (session) session->shut();
    }
    changed.notify_all();
    if (thread.joinable()) thread.join();
  }

  [[nodiscard]] std::string name() const { return "UR RTDE at " + to_text(controller); }

  void open(bool interruptible = false) {
    auto made = std::make_shared<RtdeSession>(
        controller, recipe, options, [this](const RtdeText& text) { keep(text); }, interruptible);
    const std::lock_guard lock(mutex);
    session = std::move(made);
    first_of_session = true;
    session_packets = 0;
    refused_in_a_row = 0;
    problem.clear();
    ++counts.sessions;
  }

  /// The whole setup again and again: on IN_USE because the register may be freed, on others because the
  /// controller may be coming up.
  void open_first() {
    int in_use = 0, others = 0;
    for (;;) {
      try {
        return open(true);
      } catch (const RtdeInUse&) {
        if (++in_use >= options.in_use_attempts) throw;
      } catch (const DeviceError& error) {
        if (++others >= options.attempts) throw;
        log_debug(error.what());
      }
      for (const Deadline pause = Deadline::in(options.retry_pause).or_interrupt(); !pause.over();)
        std::this_thread::sleep_for(std::chrono::duration<double>(pause.turn()));
    }
  }

  void wait_until_booted() {
    std::unique_lock lock(mutex);
    const Deadline limit = Deadline::in(options.boot_timeout);
    while (!booted && !limit.over() && !interrupt_noted())
      changed.wait_for(lock, std::chrono::duration<double>(limit.or_in(kRtdeTurn).left()));
    if (booted) return;
    const std::string why = problem.empty() ? "no steady data" : problem;
    lock.unlock();
    end();
    throw_if_interrupted();
    throw DeviceError(name(), "not ready within its boot time-out: " + why,
                      "wait until the controller has booted, then try again");
  }

  void run() {
    while (!is_ending()) try {
        if (!session) open();
        read_until_lost();
      } catch (const std::exception& error) {  // whatever it is, the program outlives it
        lose(error.what());
      }
  }

  [[nodiscard]] bool is_ending() {
    const std::lock_guard lock(mutex);
    return ending;
  }

  void lose(const std::string& why) {
    std::unique_lock lock(mutex);
    problem = why;
    session.reset();
    if (!ending) log_debug("link lost, will be set up anew: " + why);
    changed.notify_all();
    changed.wait_for(lock, std::chrono::duration<double>(options.retry_pause), [this] { return ending; });
  }

  void read_until_lost() {
    const auto current = session;  // only this thread changes it
    while (!is_ending()) {
      long refused = 0;
      auto data = current->receive(Deadline::in(options.silent_after), refused);
      if (!data)
        throw DeviceError(name(), concat("no data for ", options.silent_after, " s"),
                          "look at the cable; the link is being set up anew");
      if (refused > 0)
        refuse("a packet that is not as set up or holds numbers that are not finite");
      else
        accept(*current, std::move(data->values));
    }
  }

  void refuse(const std::string& what) {
    const std::lock_guard lock(mutex);
    ++counts.refused;
    if (++refused_in_a_row >= kRefusedInARow)
      throw DeviceError(name(), concat(kRefusedInARow, " packets in a row refused, the last: ", what),
                        "look at the controller's state");
  }

  void accept(const RtdeSession& current, std::vector<RtdeValue> values) {
    const double time = std::get<double>(values.front());  // timestamp is always the first, and checked
    if (!(time >= 0.0 && time <= kLatest)) return refuse(concat("a timestamp of ", time, " s"));
    const bool restarted = first_of_session && time < last_time - kRestart;
    if (time <= last_time && !restarted)
      return refuse(concat("a timestamp that does not rise: ", time, " s"));
    const std::lock_guard lock(mutex);
    if (!first_of_session) {
      const double steps = std::round((time - last_time) * current.frequency);
      counts.skipped += std::max(0L, static_cast<long>(steps) - 1);
    }
    first_of_session = false;
    refused_in_a_row = 0;
    last_time = time;
    ++counts.accepted;
    ++session_packets;
    booted = booted || time > kBootedTime ||
             static_cast<double>(session_packets) >= kBootedData * current.frequency;
    newest = RtdeSample(current.outputs, std::move(values), host_seconds());
    have_sample = true;
    changed.notify_all();
  }

  void keep(const RtdeText& text) {
    log_debug(concat("controller: ", text.message));
    const std::lock_guard lock(mutex);
    texts.push_back(text);
    if (texts.size() > kKeptTexts) texts.pop_front();
  }

  const Endpoint controller;
  const RtdeRecipeFor recipe;
  const RtdeOptions options;
  std::thread thread;

  std::mutex mutex;  // guards what follows
  std::condition_variable changed;
  std::shared_ptr<RtdeSession> session;
  std::string problem;
  RtdeSample newest;
  bool have_sample = false, booted = false, ending = false, first_of_session = true;
  double last_time = -1.0;
  long session_packets = 0;
  int refused_in_a_row = 0;
  std::deque<RtdeText> texts;
  RtdeCounts counts;
};

RtdeClient::RtdeClient(const Endpoint& controller, RtdeRecipeFor recipe, const RtdeOptions& options)
    : link_(std::make_unique<Link>(controller, std::move(recipe), options)) {}

RtdeClient::~RtdeClient() = default;

namespace {

template <class Session>
const Session& require_up(const std::shared_ptr<Session>& session, const std::string& name,
                          const std::string& problem) {
  if (!session) throw DeviceError(name, "the link is down: " + problem, "it is being set up anew");
  return *session;
}

}  // namespace

UrVersion RtdeClient::version() const {
  const std::lock_guard lock(link_->mutex);
  return require_up(link_->session, link_->name(), link_->problem).version;
}

int RtdeClient::protocol() const {
  const std::lock_guard lock(link_->mutex);
  return require_up(link_->session, link_->name(), link_->problem).protocol;
}

std::vector<std::string> RtdeClient::missing() const {
  const std::lock_guard lock(link_->mutex);
  return require_up(link_->session, link_->name(), link_->problem).missing;
}

RtdeSample RtdeClient::sample() const {
  const std::lock_guard lock(link_->mutex);
  const double age = host_seconds() - link_->newest.host_time();
  if (link_->have_sample && age <= link_->options.stale_after) return link_->newest;
  throw DeviceError(link_->name(),
                    concat("the state is ", age, " s old, ", link_->options.stale_after, " s allowed",
                           link_->problem.empty() ? "" : "; ", link_->problem),
                    "nothing may move until the link is back");
}

std::optional<RtdeSample> RtdeClient::wait_for_next(Deadline deadline) const {
  std::unique_lock lock(link_->mutex);
  const long before = link_->counts.accepted;
  const auto limit = std::chrono::duration<double>(deadline.left());
  if (!link_->changed.wait_for(lock, limit, [&] { return link_->counts.accepted > before; })) return {};
  return link_->newest;
}

void RtdeClient::send(std::size_t recipe, const std::vector<RtdeValue>& values) {
  std::shared_ptr<RtdeSession> session;
  {
    const std::lock_guard lock(link_->mutex);
    require_up(link_->session, link_->name(), link_->problem);
    session = link_->session;
  }
  session->send(recipe, values);
}

std::vector<RtdeText> RtdeClient::take_texts() {
  const std::lock_guard lock(link_->mutex);
  std::vector<RtdeText> taken(link_->texts.begin(), link_->texts.end());
  link_->texts.clear();
  return taken;
}

RtdeCounts RtdeClient::counts() const {
  const std::lock_guard lock(link_->mutex);
  return link_->counts;
}

double RtdeClient::now() const {
  return host_seconds();
}

FieldList fields(RtdeOptions& o) {
  return {
      field("frequency", o.frequency, {0, 500}, "Hz", "of the states; 0: the control rate, 125 or 500"),
      field("connect_timeout", o.connect_timeout, {0.05, 60}, "s",
            "until the controller accepts a connection"),
      field("reply_timeout", o.reply_timeout, {0.05, 60}, "s", "until it answers a step of the setup"),
      field("stale_after", o.stale_after, {0.01, 5}, "s", "older states are refused"),
      field("silent_after", o.silent_after, {0.05, 30}, "s", "silence after which the link is set up again"),
      field("attempts", o.attempts, {1, 100}, "", "of the first connection"),
      field("retry_pause", o.retry_pause, {0.01, 30}, "s", "between attempts"),
      field("in_use_attempts", o.in_use_attempts, {1, 100}, "",
            "while registers are in use: a dying connection frees them late"),
      field("boot_timeout", o.boot_timeout, {0.1, 600}, "s", "until a controller that boots is ready"),
  };
}

}  // namespace stonestack::hardware
