#include "stonestack/core/log.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <atomic>
#include <iostream>
#include <mutex>

namespace stonestack::core {
namespace {

std::atomic<bool> progress_open{false};

spdlog::logger& sink() {
  static const auto logger = [] {
    auto made = std::make_shared<spdlog::logger>("stonestack",
                                                 std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
    made->set_pattern("%^%l%$: %v");
    return made;
  }();
  return *logger;
}

/// Ends an open progress line before an ordinary line is written.
void close_progress() {
  if (progress_open.exchange(false)) std::cerr << '\n';
}

void write(spdlog::level::level_enum level, std::string_view line) {
  if (!sink().should_log(level)) return;
  close_progress();
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
  static const bool terminal = isatty(STDERR_FILENO) != 0;
  if (!terminal) return log_info(line);
  if (!sink().should_log(spdlog::level::info)) return;
  std::cerr << "\r\x1b[2K" << line << std::flush;
  progress_open = true;
}

}  // namespace stonestack::core
