#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "stonestack/experiment/experiment.hpp"

/// Private to report/: stones that nobody scanned, as they were modelled before a run.
namespace stonestack::report {

/// As `modelling` in stonestack.run/1.
[[nodiscard]] nlohmann::json modelling_entry(const ModellingReport& made);
/// Table for a person, lengths in mm.
[[nodiscard]] std::string modelling_text(const ModellingReport& made);

}  // namespace stonestack::report
