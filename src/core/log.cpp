#include "stonestack/core/log.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <iostream>
#include <mutex>
#include <string_view>

namespace stonestack::core {
namespace {

std::atomic<bool> progress_open{false};

/// Colours on a terminal, unless the user asked for none (https://no-color.org).
spdlog::color_mode colours() {
  const char* none = std::getenv("NO_COLOR");
  return none != nullptr && *none != '\0' ? spdlog::color_mode::never : spdlog::color_mode::automatic;
}

/// A terminal on which a line can be written over.
bool can_overwrite() {
  const char* kind = std::getenv("TERM");
  return isatty(STDERR_FILENO) != 0 && kind != nullptr && std::string_view(kind) != "dumb";
}

/// The line as far as it fits a terminal: one that wraps cannot be written over.
std::string_view fitting(std::string_view line) {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col < 2) return line;
  return line.substr(0, size.ws_col - 1U);
}

spdlog::logger& sink() {
  static const auto logger = [] {
    auto made = std::make_shared<spdlog::logger>(
        "stonestack", std::make_shared<spdlog::sinks::stderr_color_sink_mt>(colours()));
    made->set_pattern("%^%l%$: %v");
    return made;
  }();
  return *logger;
}

void write(spdlog::level::level_enum level, std::string_view line) {
  if (!sink().should_log(level)) return;
  clear_progress();
  sink().log(level, "{}", line);
}

}  // namespace

void set_log_level(LogLevel level) {
  static constexpr spdlog::level::level_enum kLevels[] = {
      spdlog::level::debug, spdlog::level::info, spdlog::level::warn, spdlog::level::err, spdlog::level::off};
  sink().set_level(kLevels[static_cast<int>(level)]);
}

void log_debug(std::string_view line) {
  write(spdlog::level::debug, line);
}
void log_info(std::string_view line) {
  write(spdlog::level::info, line);
}
void log_warning(std::string_view line) {
  write(spdlog::level::warn, line);
}
void log_error(std::string_view line) {
  write(spdlog::level::err, line);
}

void log_progress(std::string_view line) {
  static const bool overwrites = can_overwrite();
  if (!overwrites) return log_info(line);
  if (!sink().should_log(spdlog::level::info)) return;
  std::cerr << "\r\x1b[2K" << fitting(line) << std::flush;
  progress_open = true;
}

void clear_progress() {
  if (progress_open.exchange(false)) std::cerr << "\r\x1b[2K" << std::flush;
}

}  // namespace stonestack::core
