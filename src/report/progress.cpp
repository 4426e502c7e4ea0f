#include <unistd.h>

#include <cmath>
#include <mutex>

#include "report/text.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::report {
namespace {

std::string duration_text(double seconds) {
  if (seconds < 99.5) return format("%.0f s", seconds);
  if (seconds < 99.5 * 60.0) return format("%.0f min", seconds / 60.0);
  return format("%.1f h", seconds / 3600.0);
}

/// True if work has come further than when this was asked last.
bool has_moved(const Progress& progress) {
  static std::mutex mutex;
  static std::string last;
  const std::lock_guard lock(mutex);
  const std::string now = concat(progress.what, ' ', progress.done);
  const bool moved = now != last;
  last = now;
  return moved;
}

}  // namespace

std::string progress_text(const Progress& progress) {
  std::string text = concat(progress.what, ": ", progress.done);
  if (progress.total > 0.0) text += concat(" of ", progress.total);
  text += " " + progress.unit;
  if (!progress.best.empty()) text += ", " + progress.best;
  const double rest = progress.total - progress.done;
  if (progress.done > 0.0 && rest > 0.0)
    text += ", about " + duration_text(progress.seconds / progress.done * rest) + " left";
  return text;
}

void show_progress(const Progress& progress) {
  if (::isatty(STDERR_FILENO) != 0 || has_moved(progress)) log_progress(progress_text(progress));
}

}  // namespace stonestack::report
