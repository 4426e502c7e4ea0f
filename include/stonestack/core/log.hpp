#pragma once
#include <string>
#include <string_view>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

/// One log sink for the whole process: stderr, so that stdout stays data.
namespace stonestack::core {

/// Severity of a log line, rising; kOff logs nothing.
enum class LogLevel { kDebug, kInfo, kWarning, kError, kOff };

/// Lines below `level` are dropped. Default: kInfo.
void set_log_level(LogLevel level);
/// Logs a line at the level kDebug.
void log_debug(std::string_view line);
/// Logs a line at the level kInfo.
void log_info(std::string_view line);
/// Something is odd and the user may want to act; work goes on.
void log_warning(std::string_view line);
/// Logs a line at the level kError.
void log_error(std::string_view line);
/// Progress of long work: overwritten in place on a terminal, one line a change elsewhere.
void log_progress(std::string_view line);
/// Erases the progress line, if one stands on the terminal. Call before anything else is printed; the lines
/// above do so by themselves.
void clear_progress();

}  // namespace stonestack::core

#pragma GCC visibility pop
