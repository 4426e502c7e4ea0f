#pragma once
#include <functional>
#include <string>
#include <vector>

#include "stonestack/hardware/cell_file.hpp"

#pragma GCC visibility push(default)

namespace stonestack::stacking {

/// Result of one check of a cell.
struct CellCheck {
  /// Result of one check.
  enum class Verdict {
    kPassed,
    kNote,    ///< passed, but there is something to know or to do before a run
    kFailed,  ///< `text` says what is wrong and what to do
  };
  std::string device;                  ///< "arm"
  std::string step;                    ///< "RTDE"
  Verdict verdict = Verdict::kPassed;  ///< result of the check
  std::string text;                    ///< what was found
};
/// "FAIL  arm, RTDE: UR RTDE at 192.168.1.2:30004: ..."
[[nodiscard]] std::string to_text(const CellCheck& check);

/// Checks of a cell, in order.
struct CellReport {
  std::vector<CellCheck> checks;  ///< checks in the order in which they were made
  /// Number of checks that failed.
  [[nodiscard]] int failed() const;
};
/// JSON text of schema stonestack.doctor/1.
[[nodiscard]] std::string cell_report_json(const CellReport& report);

/// Options of `check_cell`.
struct CellCheckOptions {
  int frames = 2;                                  ///< depth frames to take, at least 2
  std::function<void(const CellCheck&)> on_check;  ///< called after each check; empty: not called
};
/// Checks every device of a cell, step by step, and the hand-eye calibration by a view of the table. Moves
/// nothing.
/// @throws Interrupted
[[nodiscard]] CellReport check_cell(const CellConfig& cell, const CellCheckOptions& options = {});

}  // namespace stonestack::stacking

#pragma GCC visibility pop
