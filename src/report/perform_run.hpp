#pragma once
#include <string>
#include <vector>

#include "report/record_folder.hpp"
#include "stonestack/report/record_run.hpp"

/// Private to report/: one run of the loop with its record, once for `record_run` and often for
/// `record_experiment`.
namespace stonestack::report {

/// How a run is performed, beside its options.
struct RunMode {
  bool dry = false;            ///< plans the first step only and commands nothing
  BeforeMotion before_motion;  ///< empty: nobody is asked
  std::string save_catalogue;  ///< as in RunOrder
  std::string known;           ///< likewise
  bool only_model = false;     ///< likewise
  bool keeps = false;          ///< keeps in the folder what a resume needs
  bool resumes = false;        ///< goes on with the run that the folder holds
};

/// Builds a tower of the stones `present` (indices into the catalogue). With `file` the simulated devices are
/// served on sockets, and the loop uses the real backends.
[[nodiscard]] RecordedRun perform(const SimulatedRun& run, const Catalogue& catalogue,
                                  const RobotModel& robot, const std::vector<StoneIndex>& present,
                                  const RecordFolder& folder, const std::string& version,
                                  const SurvivalOptions* survival = nullptr, const CellFile* file = nullptr,
                                  const LiveView& view = {}, const RunMode& mode = {});
/// Performs a run with the devices of a real cell.
[[nodiscard]] RecordedRun perform_real(const SimulatedRun& run, const Catalogue& catalogue,
                                       const CellFile& file, const RecordFolder& folder,
                                       const std::string& version, const LiveView& view, const RunMode& mode);

}  // namespace stonestack::report
