#include "deal_parts.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <thread>

#include "deal.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::mpi {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

constexpr auto kPoll = std::chrono::milliseconds(20);
constexpr auto kPatience = std::chrono::seconds(30);  // for a program that was interrupted
constexpr std::size_t kMaxPart = 1U << 30U;           // bytes

std::string part_file(const BenchOrder& order, int number, const char* ending) {
  return concat(order.out, "/part-", number, "-of-", order.parts, ending);
}

/// A program in a process of its own, which ends when this one does.
class Child {
 public:
  /// @param log file of its output; empty: it writes where this process does
  Child(const Words& command, const std::string& log) {
    std::vector<char*> argv;
    for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    const pid_t parent = ::getpid();
    pid_ = ::fork();
    if (pid_ < 0) throw Error("no process can be started for " + command.front(), ExitCode::kUnreadable);
    if (pid_ > 0) return;
    // Only what may be called after a fork of a process with threads.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(127);
    if (!log.empty()) {
      const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
      if (file < 0) ::_exit(126);
      ::dup2(file, STDOUT_FILENO);
      ::dup2(file, STDERR_FILENO);
    }
    ::execv(argv.front(), argv.data());
    ::_exit(127);
  }
  ~Child() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Waits until it has ended; after Ctrl-C until it has kept what it did.
  /// @return its exit code, as a shell gives it
  int wait() {
    bool told = false;
    std::chrono::steady_clock::time_point last{};
    for (;;) {
      int status = 0;
      if (::waitpid(pid_, &status, WNOHANG) == pid_) {
        pid_ = 0;
        throw_if_interrupted();
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      }
      const auto now = std::chrono::steady_clock::now();
      if (interrupt_noted() && !told) {
        ::kill(pid_, SIGINT);
        told = true;
        last = now + kPatience;
      }
      if (told && now > last) throw_if_interrupted();
      std::this_thread::sleep_for(kPoll);
    }
  }

 private:
  pid_t pid_ = 0;
};

/// The last line of a log that says what went wrong.
std::string error_in(const std::string& log) {
  std::ifstream file(log);
  std::string line, found;
  while (std::getline(file, line))
    if (line.rfind("error", 0) == 0) found = line;
  return found.empty() ? "it says nothing" : found;
}

/// True if the part has performed all of its draws.
bool is_complete(const std::string& part) {
  if (!fs::exists(part)) return false;
  try {
    return nlohmann::json::parse(read_file(part, kMaxPart)).value("complete", false);
  } catch (const nlohmann::json::exception&) {
    throw FileError(part, "is no part of a benchmark", "remove it: it is performed anew");
  }
}

Perform performer(const BenchOrder& order, const std::string& host) {
  return [order, host](const std::string&, int number) {
    const std::string part = part_file(order, number, ".json"), log = part_file(order, number, ".log");
    Words command{order.program};
    command.insert(command.end(), order.arguments.begin(), order.arguments.end());
    for (const std::string& word :
         {std::string("--shard"), concat(number, '/', order.parts), std::string("--record"), part})
      command.push_back(word);
    if (fs::exists(part)) command.emplace_back("--continue");
    if (const int code = Child(command, log).wait(); code != 0)
      throw Error(concat("part ", number, " of ", order.parts, " ended with code ", code, ": ", error_in(log),
                         " (", log, ')'),
                  ExitCode::kUnreadable);
    return concat("part ", number, " of ", order.parts, ": performed on ", host);
  };
}

/// Numbers of the parts that are yet to be performed. Makes the folder.
std::vector<int> parts_to_perform(const BenchOrder& order) {
  std::error_code failed;
  fs::create_directories(order.out, failed);
  if (!fs::is_directory(order.out))
    throw FileError(order.out, "is no folder and cannot be made one", "name another one with --out");
  const std::string wanted = concat("-of-", order.parts, ".json");
  for (const auto& entry : fs::directory_iterator(order.out)) {
    const std::string name = entry.path().filename();
    if (name.rfind("part-", 0) != 0 || entry.path().extension() != ".json") continue;
    require(order.continues, order.out, " holds parts already; --continue goes on with them");
    require(name.size() > wanted.size() && name.ends_with(wanted), order.out, " holds ", name,
            ", which is none of ", order.parts, " parts: go on with the same --parts");
  }
  std::vector<int> numbers;
  for (int k = 1; k <= order.parts; ++k)
    if (!is_complete(part_file(order, k, ".json"))) numbers.push_back(k);
  return numbers;
}

void merge_parts(const BenchOrder& order) {
  Words command{order.program, order.arguments.front(), "--merge"};
  for (int k = 1; k <= order.parts; ++k) command.push_back(part_file(order, k, ".json"));
  if (!order.record.empty()) command.insert(command.end(), {"--record", order.record});
  if (order.json) command.emplace_back("--json");
  std::cout.flush();
  const int code = Child(command, "").wait();
  if (code != 0) throw Error(concat("the parts cannot be merged: code ", code), ExitCode::kUnreadable);
}

}  // namespace

std::string own_bench() {
  return (fs::read_symlink("/proc/self/exe").parent_path() / "stonestack-bench").string();
}

void deal_parts(const Ranks& ranks, const BenchOrder& order, bool quiet) {
  Dealer dealer(ranks);
  if (::access(order.program.c_str(), X_OK) != 0)
    throw FileError(order.program, "is no program",
                    "build it with `./dev bench --help`, or name it with --program");
  if (!order.record.empty()) require_writable(order.record);
  const std::vector<int> numbers = parts_to_perform(order);
  int complete = order.parts - static_cast<int>(numbers.size());
  if (!numbers.empty())
    dealer.deal(order.out, numbers, performer(order, ranks.host()), [&](const Words& lines) {
      for (const std::string& line : lines) {
        ++complete;
        if (!quiet)
          std::cerr << line << "; " << complete << " of " << order.parts << " are complete" << std::endl;
      }
    });
  throw_if_interrupted();
  merge_parts(order);
}

void perform_dealt_parts(const Ranks& ranks, const BenchOrder& order) {
  perform_dealt(ranks, performer(order, ranks.host()));
}

}  // namespace stonestack::mpi
