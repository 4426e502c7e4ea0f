#pragma once
#include <memory>
#include <optional>
#include <string>

#include "report/live_server.hpp"
#include "report/run_page.hpp"
#include "stacking/recorded_devices.hpp"
#include "stonestack/report/record_run.hpp"

/// Private to report/: the report of a run while it goes on.
namespace stonestack::report {

/// Starts a server and announces it; none if `view` does not want one. A stop counts as Ctrl-C.
[[nodiscard]] std::unique_ptr<LiveServer> make_live_server(const LiveView& view, std::string page);

/// Page of a run that is under way. Does nothing if `view` does not want it.
class LiveRun {
 public:
  /// `opened`: what is known before anything is done.
  LiveRun(const LiveView& view, const RunReport& opened, const Catalogue& catalogue, const RobotModel& robot,
          const CellLayout& layout);
  /// Devices whose motion the page shows; valid as long as this object.
  [[nodiscard]] Cell watched(const Cell& cell);
  /// Adds an event, and the motion before it.
  void hear(const Event& event);
  /// Makes the page what the report is, and waits a moment for clients to receive it.
  void finish(const RunReport& report);

 private:
  /// Does something for the page; a failure ends the live view and not the run.
  template <class Work>
  void attempt(const Work& work);

  const Catalogue& catalogue_;
  const RobotModel& robot_;
  RunReport so_far_;
  PagePosition shown_;
  std::unique_ptr<LiveServer> server_;
  std::optional<RecordedDevices> devices_;
  const Clock* clock_ = nullptr;
};

}  // namespace stonestack::report
