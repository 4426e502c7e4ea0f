#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "stacking/journal.hpp"
#include "stacking/model_field.hpp"
#include "stacking/plan_motion.hpp"
#include "stacking/state_file.hpp"

/// Private to stacking/: what a run keeps in its folder, so that another process can go on with it.
namespace stonestack::stacking {

/// File, within a run's folder, of where the run stands.
inline constexpr const char* kResumeFile = "/resume.json";

/// Kind and data of a line of the journal.
using JournalLine = std::pair<std::string, std::string>;

/// Where a run stood when its program ended.
struct ResumePoint {
  std::optional<State> state;              ///< empty: nothing was observed yet
  std::optional<PickAndPlacePlan> motion;  ///< that had begun, of the attempt in `state`
  StageSeconds seconds;
  long lines = 0;                    ///< of the journal, before `learned`
  std::vector<JournalLine> learned;  ///< from the last observation; some may be missing in the journal
};

/// Reads a folder's resume.json. @throws FileError for a file that is missing, damaged or of another version.
[[nodiscard]] ResumePoint read_resume_point(const std::string& folder, const Catalogue& catalogue);

/// Appends what was learned and is not in the journal yet, so that each line is there once.
void complete_journal(Journal& journal, const ResumePoint& point);

/// Replaces resume.json, on the disk before anything moves. What an observation taught goes into it before it
/// goes into the journal: a process that ends between the two loses nothing, and doubles nothing.
class ResumeWriter {
 public:
  /// `folder` empty: nothing is kept. The others must outlive it.
  ResumeWriter(std::string folder, const Models& models, const BuildOptions& options,
               const StageSeconds& seconds, const Journal* journal)
      : folder_(std::move(folder)),
        models_(models),
        options_(options),
        seconds_(seconds),
        journal_(journal) {}

  /// The run begins: nothing is observed.
  void begin() const;
  /// Nothing moves; the journal is still to hear what was learned.
  void observed(const WorldEstimate& world, const RunMemory& memory, const std::vector<Event>& learned) const;
  /// An action is about to be carried out; `memory` remembers it, with an end that nobody knows.
  void acting(const WorldEstimate& world, const RunMemory& memory, const MotionPlan& plan) const;

 private:
  void write(const nlohmann::json& content) const;

  std::string folder_;
  const Models& models_;
  const BuildOptions& options_;
  const StageSeconds& seconds_;
  const Journal* journal_;
};

/// `build_tower`, which keeps in `folder` what a process needs to go on with the run; `resumes`: goes on with
/// it. Then it asks the gripper first, takes a stone that is held back to where it was picked, and observes.
/// @param modelled with `options.unseen` and this hook, what no stone explains is modelled when a stone is
/// out of sight, and added to the stones of the run: `catalogue` itself stays as it is.
/// @throws FileError for a folder whose run cannot go on
[[nodiscard]] RunResult build_resumable(Cell& cell, const Catalogue& catalogue, const RobotModel& robot,
                                        const BuildOptions& options, const BuildHooks& hooks,
                                        const std::string& folder, bool resumes,
                                        const ModelledHook& modelled = {});

}  // namespace stonestack::stacking
