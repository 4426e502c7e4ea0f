#include "report/live_run.hpp"

#include <exception>
#include <utility>

#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/report/record_run.hpp"

namespace stonestack::report {
std::unique_ptr<LiveServer> make_live_server(const LiveView& view, std::string page) {
  if (!view.wanted) return nullptr;
  auto server = std::make_unique<LiveServer>(view.port, std::move(page), [] { note_interrupt(); });
  if (view.announce) view.announce(server->address(), server->stop_token());
  return server;
}

LiveRun::LiveRun(const LiveView& view, const RunReport& opened, const Catalogue& catalogue,
                 const RobotModel& robot, const CellLayout& layout)
    : catalogue_(catalogue), robot_(robot) {
  if (!view.wanted) return;
  so_far_ = opened;
  so_far_.result.world.layout = layout;
  std::string data = page_data(so_far_, catalogue, robot, "");
  data.insert(data.size() - 1, ",\"live\":true");
  shown_.stones = catalogue.stones.size();
  server_ = make_live_server(view, page_html("Tower", "The page of a run that is under way.", data));
}

Cell LiveRun::watched(const Cell& cell) {
  if (!server_) return cell;
  clock_ = &cell.clock;
  return devices_.emplace(cell, so_far_.result.timeline).cell();
}

template <class Work>
void LiveRun::attempt(const Work& work) {
  if (!server_) return;
  try {
    work();
  } catch (const std::exception& problem) {
    log_warning(concat("the live view ends: ", problem.what()));
    server_.reset();
  }
}

void LiveRun::hear(const Event& event) {
  attempt([&] {
    RunResult& result = so_far_.result;
    if (const auto* seen = std::get_if<Observed>(&event)) {
      result.world = seen->world;
      result.height = static_cast<int>(seen->world.stack.size());
    } else if (const auto* judged = std::get_if<PlacementJudged>(&event)) {
      result.placements.push_back(judged->record);
    } else if (const auto* ended = std::get_if<RunEnded>(&event)) {
      result.end = ended->end;
      result.ended = ended->reason;
    }
    result.events.push_back(event);
    result.timeline.event_time.push_back(clock_->now());
    if (!result.timeline.samples.empty())
      result.seconds.motion = result.timeline.samples.back().time - result.timeline.samples.front().time;
    server_->publish("add", page_changes(so_far_, catalogue_, robot_, shown_));
  });
}

void LiveRun::finish(const RunReport& report) {
  attempt([&] {
    server_->set_page(run_html(report, catalogue_, robot_));
    server_->publish("end", page_data(report, catalogue_, robot_, picture_uri(report)));
    server_->finish(kFarewell);
  });
}

}  // namespace stonestack::report
