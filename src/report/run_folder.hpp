#pragma once
#include <string>

#include "report/record_folder.hpp"

/// Private to report/: where runs and experiments write their records.
namespace stonestack::report {

/// "runs/20261121-143000-seed1": `kind`, the time and the seed.
[[nodiscard]] std::string stamped_name(const std::string& kind, int seed);

/// The folder for one run: `out`, or, where that is empty, a new one below runs/. What a run that was killed
/// has left in it is put aside, so that the same command can be started again; a journal without a line is
/// written over. Throws InvalidArgument where a run that ended is in it, and FileError.
[[nodiscard]] RecordFolder take_run_folder(const std::string& out, int seed);

}  // namespace stonestack::report
