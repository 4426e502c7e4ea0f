#pragma once
#include <functional>
#include <string>

#include "stacking/check_hand_eye.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/stacking/check_cell.hpp"

/// Private to stacking/.
namespace stonestack::stacking {

/// Runs the checks of a cell in order and keeps what each found.
class Examination {
 public:
  /// `on_check` hears of each check; empty: nobody does.
  explicit Examination(std::function<void(const CellCheck&)> on_check = {})
      : on_check_(std::move(on_check)) {}

  /// `view` returns what it found, or throws with what is wrong.
  template <class SearchView>
  void check(const std::string& device, const std::string& step, const SearchView& view) {
    throw_if_interrupted();
    CellCheck done{device, step, CellCheck::Verdict::kPassed, ""};
    try {
      const Found found{view()};
      done.text = found.text;
      if (found.to_do) done.verdict = CellCheck::Verdict::kNote;
    } catch (const Interrupted&) {
      throw;
    } catch (const Error& problem) {
      done.verdict = CellCheck::Verdict::kFailed;
      done.text = problem.what();
    }
    if (on_check_) on_check_(done);
    report_.checks.push_back(done);
  }
  [[nodiscard]] const CellReport& report() const { return report_; }

 private:
  std::function<void(const CellCheck&)> on_check_;
  CellReport report_;
};

}  // namespace stonestack::stacking
