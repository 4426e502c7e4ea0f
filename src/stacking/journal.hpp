#pragma once
#include <string>

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

  /// Appends {"seq", "kind", "data"} in one write and waits until it is on the disk. `data_json` is a JSON
  /// value.
  /// @throws FileError when the disk refuses.
  void record(const std::string& kind, const std::string& data_json);
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
};

}  // namespace stonestack::stacking
