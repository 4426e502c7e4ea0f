#pragma once
#include <functional>
#include <string>
#include <string_view>

#include "stonestack/core/rooms.hpp"

namespace stonestack::stacking {

/// Append-only record of a run, one JSON object a line (JSONL): what was intended is on the disk before
/// anything moves. A default-made journal records nothing.
class Journal {
 public:
  Journal() = default;
  /// Opens or makes the file and continues its numbering; a torn last line is cut off.
  /// @throws FileError
  explicit Journal(const std::string& path);
  ~Journal();
  Journal(Journal&& other) noexcept;
  Journal& operator=(Journal&& other) noexcept;

  /// Appends {"seq", "time", "kind", "data", "arm", "crc"} in one write and waits until it is on the disk.
  /// `data_json` is a JSON value; `arm_json` likewise, or empty for a line without "arm".
  /// @throws FileError when the disk refuses.
  void record(const std::string& kind, const std::string& data_json, const std::string& arm_json = {});
  /// Sets where the state of the arm comes from that goes with each step; empty: nowhere.
  void watch_arm(std::function<std::string()> arm_json) { arm_json_ = std::move(arm_json); }
  /// State of the arm as JSON; empty where nobody watches it.
  [[nodiscard]] std::string arm() const { return arm_json_ ? arm_json_() : std::string(); }
  /// Number of lines that it has.
  [[nodiscard]] long lines() const { return next_; }
  /// Keeps the name of the step that begins, for who asks before it.
  void begin_step(const std::string& name) { step_ = name; }
  /// Name of the step that began last; empty before the first.
  [[nodiscard]] const std::string& step() const { return step_; }

 private:
  std::string path_;
  int descriptor_ = -1;
  long next_ = 0;
  std::string step_;
  std::function<std::string()> arm_json_;
};

/// Is a line of a journal not as it was written? Lines of earlier versions have no checksum.
[[nodiscard]] bool is_damaged(std::string_view line);

}  // namespace stonestack::stacking
