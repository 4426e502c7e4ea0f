#pragma once
// `stonestack` as a user runs it: what every end-to-end test of the command starts from.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "rooms.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/geometry/pose.hpp"
#include "temporary_folder.hpp"

namespace stonestack {

using namespace report;  // with the rooms below it: the whole library
namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;

struct Outcome {
  int code = -1;
  std::string out;
  std::string err;
  [[nodiscard]] json data() const { return json::parse(out, nullptr, false); }
};

inline Pose pose_of(const json& t) {
  const auto number = [&](const char* key) { return t.at(key).get<double>(); };
  return make_pose(Eigen::Vector3d(number("x"), number("y"), number("z")),
                   Eigen::Quaterniond(number("qw"), number("qx"), number("qy"), number("qz")));
}

/// Starts the command, and Ctrl-C comes as soon as its messages show `line`; its exit code is printed.
inline std::string interrupted_at(const std::string& folder, const std::string& arguments,
                                  const std::string& line) {
  return concat("cd ", folder, " && { ", STONESTACK_BINARY, " ", arguments, " 2>err & pid=$!; ",
                "for i in $(seq 1200); do grep -q '", line, "' err && break; sleep 0.1; done; ",
                "kill -INT $pid; wait $pid; echo code $?; }");
}

/// `stonestack` as a user runs it, in a folder of its own.
class Commands : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        test::temporary_folder() + concat("commands_test_", ::getpid(), "_",
                                          testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] Outcome run(const std::string& arguments) const {
    return shell(concat("cd ", folder_, " && ", program_, " ", arguments, " 2>err"));
  }
  /// A shell command that leaves its messages in the file `err` of the folder.
  [[nodiscard]] Outcome shell(const std::string& command) const {
    Outcome outcome;
    FILE* pipe = ::popen(command.c_str(), "r");
    if (pipe == nullptr) return outcome;
    std::array<char, 4096> piece{};
    while (const std::size_t got = std::fread(piece.data(), 1, piece.size(), pipe))
      outcome.out.append(piece.data(), got);
    const int status = ::pclose(pipe);
    outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    outcome.err = read_file(folder_ + "/err", 1 << 20);
    return outcome;
  }
  /// Returns what a person sees who runs the command with these variables on a terminal; lines end in CR LF.
  [[nodiscard]] std::string on_terminal(const std::string& variables, const std::string& arguments) const {
    const std::string command =
        concat("cd ", folder_, " && env ", variables, " ", STONESTACK_BINARY, " ", arguments);
    int terminal = -1;
    const pid_t child = ::forkpty(&terminal, nullptr, nullptr, nullptr);
    if (child == 0) {
      ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
      ::_exit(127);
    }
    std::string shown;
    std::array<char, 4096> piece{};
    for (ssize_t got = 0; (got = ::read(terminal, piece.data(), piece.size())) > 0;)
      shown.append(piece.data(), static_cast<std::size_t>(got));  // ends with EIO when the child has left
    ::close(terminal);
    ::waitpid(child, nullptr, 0);
    return shown;
  }
  void write(const std::string& name, const std::string& text) const {
    write_file(folder_ + "/" + name, text);
  }
  /// The command fails with that code and one line that holds all of `parts`.
  void expect_refusal(const std::string& arguments, int code, const std::vector<std::string>& parts) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, code) << arguments << "\n" << outcome.err;
    for (const auto& part : parts) EXPECT_THAT(outcome.err, HasSubstr(part)) << arguments;
    EXPECT_LE(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 3) << outcome.err;
  }

  std::string folder_;
  std::string program_ = STONESTACK_BINARY;
};

}  // namespace stonestack
