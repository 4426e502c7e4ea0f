#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::apps {
namespace {

struct ViewCommand {
  Loudness loudness;
  CellViewOrder order;
  std::string joints;
  bool json = false;
};

void view(ViewCommand& command) {
  command.loudness.apply();
  if (command.order.cell.empty()) command.order.cell = "loopback-ur10";
  if (!command.joints.empty()) {
    const std::vector<double> q = parse_numbers(command.joints, 6, "q1,q2,q3,q4,q5,q6 in rad");
    command.order.q_start = Eigen::Map<const Joints>(q.data());
  }
  const ShownCell shown = show_cell(command.order);
  std::cout << (command.json ? cell_view_json(shown) : cell_view_text(shown));
}

}  // namespace

void add_view(CLI::App& app) {
  const auto [sub, command] = add_subcommand<ViewCommand>(
      app, "view", "Show a cell in 3-D and check it, before anything is connected or moves", view);
  add_path(sub, "CELL", command.order.cell, "Cell file (default: the simulated loopback cell)");
  add_path(sub, "--out", command.order.out,
           "Page (.html), picture (.png), or a folder for both (default: CELL_view.html)");
  sub.add_option("--joints", command.joints,
                 "Where the arm stands, q1,q2,q3,q4,q5,q6 in rad (default: above the middle of the field)");
  sub.add_flag("--json", command.json, "Result as JSON on stdout");
  command.loudness.register_on(sub);
  sub.footer(
      "The page is one file for any browser: arm, obstacles, limits, reach and what the camera sees as "
      "layers,\n"
      "and the numbers of the cell file. A line that begins with FAIL names what a run would stumble over; "
      "the\n"
      "exit code is 0 all the same.\n"
      "Examples:\n"
      "  stonestack view my_lab.yaml\n"
      "  stonestack view my_lab.yaml --out cell.png --joints 0,-1.75,1.85,-1.67,-1.57,0\n"
      "  stonestack view loopback-ur10e --json");
}

}  // namespace stonestack::apps
