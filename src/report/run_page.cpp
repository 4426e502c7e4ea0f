#include "report/run_page.hpp"
#include "report/link_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/constants.hpp"
#include "motion/grasp/finger_reach.hpp"
#include "report/base64.hpp"
#include "report/modelling_results.hpp"
#include "report/picture.hpp"
#include "report/text.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/experiment/simulated_run.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/physics/stack.hpp"
#include "stonestack/report/record_run.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

constexpr double kSamePoint = 0.003;  // m: contacts of one pair that are drawn as one
constexpr std::size_t kShown = 6;     // placements of a decision: the chosen one beside the next five
const std::array<const char*, 4> kTerms{"area", "kinetic_energy", "distance", "normal"};  // of eq. (2)
const std::array<const char*, 7> kWallTerms{"course",   "joint_cover", "fill",   "off_height",
                                            "off_axis", "worth",       "urgency"};

double rounded(double value, double unit = 1e-5) {
  return std::round(value / unit) * unit;
}

}  // namespace

json numbers(const Eigen::Vector3d& v) {
  return {rounded(v.x()), rounded(v.y()), rounded(v.z())};
}

json numbers(const Pose& pose) {
  const Eigen::Quaterniond q(pose.linear());
  const Eigen::Vector3d& p = pose.translation();
  return {rounded(p.x()), rounded(p.y()), rounded(p.z()), rounded(q.x()),
          rounded(q.y()), rounded(q.z()), rounded(q.w())};
}

namespace {

template <class Number>
std::string packed(const std::vector<Number>& values) {
  return base64({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number)});
}

json stone_entry(const Stone& stone) {
  std::vector<float> vertices;
  std::vector<std::uint16_t> faces;
  for (const Eigen::Vector3d& v : stone.mesh.vertices)
    for (int i = 0; i < 3; ++i) vertices.push_back(static_cast<float>(v[i]));
  for (const Eigen::Vector3i& face : stone.mesh.faces)
    for (int i = 0; i < 3; ++i) faces.push_back(static_cast<std::uint16_t>(face[i]));
  return {{"name", stone.name}, {"vertices", packed(vertices)}, {"faces", packed(faces)}};
}

}  // namespace

json robot_entry(const RobotModel& robot, const CellLayout& layout) {
  constexpr double kReachStep = 0.005;  // m of opening
  const GripperModel gripper = stacking::gripper_of(layout);
  json joints = json::array(), shapes = json::array(), boxes = json::array(), reach = json::array();
  for (double opening = 0.0; opening <= gripper.max_opening + 1e-9; opening += kReachStep)
    reach.push_back(rounded(tip_advance(gripper, opening)));
  for (const Pose& T_parent_joint : robot.T_parent_joint) joints.push_back(numbers(T_parent_joint));
  for (const LinkShape& shape : link_shapes(robot)) {
    json profile = json::array();
    for (const Eigen::Vector2d& at : shape.profile) profile.push_back({rounded(at.x()), rounded(at.y())});
    shapes.push_back({{"link", shape.link},
                      {"p", numbers(shape.p)},
                      {"axis", numbers(shape.n_axis)},
                      {"lid", shape.lid},
                      {"profile", std::move(profile)}});
  }
  for (const GripperBox& box : gripper.boxes)
    boxes.push_back({{"size", numbers(box.size)},
                     {"centre", numbers(box.p_T_centre)},
                     {"side", box.finger_side},
                     {"spread", box.spread},
                     {"advance", box.advance},
                     {"camera", box.camera}});
  return {{"T_W_R", numbers(layout.T_W_R)},    {"T_parent_joint", joints}, {"T_6_F", numbers(robot.T_6_F)},
          {"T_F_T", numbers(layout.T_F_T)},    {"shapes", shapes},         {"boxes", boxes},
          {"spacing", gripper.finger_spacing}, {"reach", reach},           {"reach_step", kReachStep}};
}

namespace {

/// Contacts of a resting tower or wall with their forces: impulses of the settled world, scaled so that the
/// table carries the weight. Thrust lines as segments: from the centre of mass of each stone to the centre of
/// pressure on each of those below it, and on to the centre of mass of that one.
json tower_entry(const ShapeList& shapes, const RestingStack& resting) {
  json contacts = json::array(), centres = json::array(), thrust = json::array();
  const StackStatics statics = stack_statics(shapes, *resting.stack, resting.friction);
  struct Point {
    Contact contact;
    double impulse = 0.0;
  };
  std::vector<Point> points;
  double weight = 0.0, on_table = 0.0;
  for (const StaticBody& body : statics.bodies) {
    weight += body.mass * kGravity;
    centres.push_back(numbers(body.p_W_com));
  }
  for (const Contact& contact : statics.contacts) {
    if (contact.below == kTable) on_table += contact.impulse * contact.n_W.z();
    const auto same = std::find_if(points.begin(), points.end(), [&](const Point& p) {
      return p.contact.below == contact.below && p.contact.above == contact.above &&
             (p.contact.p_W - contact.p_W).norm() < kSamePoint;
    });
    if (same != points.end())
      same->impulse += contact.impulse;
    else
      points.push_back({contact, contact.impulse});
  }
  const double scale = on_table > 0.0 ? weight / on_table : 0.0;
  std::map<std::pair<int, int>, std::pair<Eigen::Vector3d, double>>
      pressure;  // by the stones below and above
  for (const Point& point : points) {
    const double force = scale * point.impulse;
    contacts.push_back({{"p", numbers(point.contact.p_W)}, {"f", numbers(force * point.contact.n_W)}});
    auto& [sum, total] =
        pressure.try_emplace({point.contact.below, point.contact.above}, Eigen::Vector3d::Zero(), 0.0)
            .first->second;
    sum += force * point.contact.p_W;
    total += force;
  }
  for (const auto& [pair, load] : pressure) {
    if (!(load.second > 0.0)) continue;
    const json centre = numbers(load.first / load.second);
    thrust.push_back({centres[static_cast<std::size_t>(pair.second)], centre});
    if (pair.first != kTable) thrust.push_back({centre, centres[static_cast<std::size_t>(pair.first)]});
  }
  return {{"contacts", contacts}, {"centres", centres}, {"thrust", thrust}};
}

/// Time from the first sample on.
class Times {
 public:
  explicit Times(const Timeline& timeline) : timeline_(timeline) {
    if (!timeline.samples.empty()) zero_ = timeline.samples.front().time;
  }
  [[nodiscard]] double of(double time) const { return std::max(0.0, rounded(time - zero_, 1e-3)); }
  [[nodiscard]] double of_event(std::size_t index) const {
    return index < timeline_.event_time.size() ? of(timeline_.event_time[index]) : 0.0;
  }

 private:
  const Timeline& timeline_;
  double zero_ = 0.0;
};

/// Samples from `from` on.
std::string packed_samples(const Timeline& timeline, const Times& times, std::size_t& from) {
  std::vector<float> flat;
  for (; from < timeline.samples.size(); ++from) {
    const MotionSample& s = timeline.samples[from];
    flat.push_back(static_cast<float>(times.of(s.time)));
    for (int i = 0; i < 6; ++i) flat.push_back(static_cast<float>(s.q[i]));
    for (const double value : {s.opening, s.spacing, s.force, s.holds ? 1.0 : 0.0})
      flat.push_back(static_cast<float>(value));
  }
  return packed(flat);
}

/// From grasp to release: the stone nearest to the tool when the fingers closed moves with it.
json carries(const RunReport& report, const RobotModel& robot, const Times& times) {
  json list = json::array();
  const auto& samples = report.result.timeline.samples;
  const CellLayout& layout = report.result.world.layout;
  const WorldEstimate* seen = nullptr;
  std::size_t next_event = 0;
  const auto& events = report.result.events;
  json open;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    for (; next_event < events.size() && times.of_event(next_event) <= times.of(samples[i].time);
         ++next_event)
      if (const auto* observed = std::get_if<Observed>(&events[next_event])) seen = &observed->world;
    const bool held = i > 0 && samples[i - 1].holds;
    if (samples[i].holds && !held && seen != nullptr) {
      const Pose T_W_T = layout.T_W_R * forward(robot, samples[i].q) * layout.T_F_T;
      const StoneEstimate* nearest = nullptr;
      const auto distance = [&](const StoneEstimate& s) {
        return (s.T_W_O_seen.translation() - T_W_T.translation()).norm();
      };
      for (const auto* stones : {&seen->loose, &seen->stack})
        for (const StoneEstimate& stone : *stones)
          if (nearest == nullptr || distance(stone) < distance(*nearest)) nearest = &stone;
      if (nearest != nullptr)
        open = {{"begin", times.of(samples[i].time)},
                {"stone", nearest->stone},
                {"T_T_O", numbers(T_W_T.inverse() * nearest->T_W_O_seen)}};
    }
    if (!open.is_null() && (!samples[i].holds || i + 1 == samples.size())) {
      open["end"] = times.of(samples[i].time);
      list.push_back(open);
      open = nullptr;
    }
  }
  return list;
}

/// A number of a placement; null where 0 says that nobody tried.
json tried(double value) {
  return value > 0.0 ? json(value) : json(nullptr);
}

json term_or_null(const std::map<std::string, double>& terms, const std::string& name) {
  const auto found = terms.find(name);
  return found == terms.end() ? json(nullptr) : json(found->second);
}

template <class P>
json compared_entry(const P& p, bool chosen) {
  return {{"stone", p.stone},
          {"T_W_O", numbers(p.T_W_O)},
          {"cost", p.terms.empty() ? json(nullptr) : json(p.cost)},
          {"predicted", tried(p.predicted_success)},
          {"terms", p.terms},
          {"expected", tried(p.expected_height)},
          {"chosen", chosen},
          {"support", json::array()},
          {"why_not", ""},
          {"margin", term_or_null(p.terms, "margin")}};
}

json candidate_entry(const Placement& p, bool chosen) {
  json entry = compared_entry(p, chosen);
  for (const Eigen::Vector3d& corner : p.support.corners_W) entry["support"].push_back(numbers(corner));
  return entry;
}

json candidate_entry(const Alternative& a) {
  json entry = compared_entry(a, false);
  entry["why_not"] = a.why_not;
  return entry;
}

/// Title of a decision, and the placement that it is about.
struct ActionTitle {
  const Catalogue& catalogue;
  const Placement* chosen = nullptr;

  [[nodiscard]] const std::string& name(StoneIndex stone) const { return catalogue[stone].name; }
  std::string operator()(const Place& a) {
    if (!a.candidates.empty()) chosen = &a.candidates.front();
    return chosen == nullptr ? "place" : "place " + name(chosen->stone);
  }
  std::string operator()(const Reorient& a) {
    if (!a.candidates.empty()) chosen = &a.candidates.front();
    return chosen == nullptr ? "reorient" : "reorient " + name(chosen->stone);
  }
  std::string operator()(const Unstack& a) { return "unstack " + name(a.top.stone); }
  std::string operator()(const ClearBase& a) { return "clear the base of " + name(a.stray.stone); }
  std::string operator()(const Push& a) { return "push " + name(a.stone.stone); }
  std::string operator()(const LookAgain& a) { return "look again for " + name(a.stone); }
  std::string operator()(const ModelAnew& a) {
    return a.in_sight ? "model " + name(a.lost.front()) + " as it stands" : "model what is not recognised";
  }
  std::string operator()(const Stop&) { return "stop"; }
};

bool same_placement(const Placement& a, const Placement& b) {
  return a.stone == b.stone && a.T_W_O.isApprox(b.T_W_O, 1e-9);
}

/// Stones that a placement and what is to follow it take, in order.
std::vector<StoneIndex> stones_of_plan(const Placement& chosen) {
  std::vector<StoneIndex> stones{chosen.stone};
  for (const PlacedStone& next : chosen.then) stones.push_back(next.stone);
  return stones;
}

/// Is a placement the next of an earlier plan, or its first once more?
bool goes_on_with(const std::vector<StoneIndex>& planned, const Placement& chosen) {
  const std::vector<StoneIndex> now = stones_of_plan(chosen);
  return !planned.empty() &&
         (now == planned || std::equal(now.begin(), now.end(), planned.begin() + 1, planned.end()));
}

/// Where a placement stood among those that the search offered.
std::string reason_of(const Placement& chosen, const std::vector<Placement>& offered, std::size_t compared,
                      bool follows) {
  if (offered.size() < 2)
    return format(
        "%s%zu other%s; %.2f stones are expected to stand in the end, with %zu more to follow",
        follows ? "next in the plan that was made before, when it was compared with " : "compared with ",
        compared - 1, compared == 2 ? "" : "s", chosen.expected_height, chosen.then.size());
  const auto place = std::find_if(offered.begin(), offered.end(),
                                  [&](const Placement& p) { return same_placement(p, chosen); });
  const std::string number =
      place == offered.end() ? "not among" : concat("number ", place - offered.begin() + 1, " of");
  return format(
      "%s the %zu placements that the search offered; %.2f stones are expected to stand in the end, "
      "with %zu more to follow; the longest plans are tried first",
      number.c_str(), offered.size(), chosen.expected_height, chosen.then.size());
}

/// Terms that are shown for candidates: those of a wall or bridge that any of them has, else those of eq.
/// (2).
json terms_of(const json& candidates) {
  json names = json::array();
  for (const char* name : kWallTerms)
    if (std::any_of(candidates.begin(), candidates.end(),
                    [&](const json& c) { return c["terms"].contains(name); }))
      names.push_back(name);
  return names.empty() ? json(kTerms) : names;
}

json decision_entry(const ActionChosen& chosen, const Catalogue& catalogue, double time, PagePosition& from) {
  ActionTitle title{catalogue};
  const std::string text = std::visit(title, chosen.action);
  json candidates = json::array();
  const bool listed =
      title.chosen != nullptr && std::any_of(chosen.offered.begin(), chosen.offered.end(),
                                             [&](const auto& p) { return same_placement(p, *title.chosen); });
  if (title.chosen != nullptr && !listed) candidates.push_back(candidate_entry(*title.chosen, true));
  if (title.chosen != nullptr) {
    for (const Placement& p : chosen.offered) {
      const bool is_chosen = same_placement(p, *title.chosen);
      if (is_chosen || candidates.size() < kShown) candidates.push_back(candidate_entry(p, is_chosen));
    }
    for (const Alternative& other : chosen.others)
      if (candidates.size() < kShown) candidates.push_back(candidate_entry(other));
  }
  json reasons = from.why;
  if (title.chosen != nullptr && candidates.size() > 1)
    reasons.push_back(reason_of(*title.chosen, chosen.offered, candidates.size(),
                                goes_on_with(from.planned, *title.chosen)));
  if (title.chosen != nullptr) from.planned = stones_of_plan(*title.chosen);
  if (const auto* stop = std::get_if<Stop>(&chosen.action)) reasons.push_back(stop->reason);
  return {{"t", time},
          {"title", text},
          {"why", reasons},
          {"candidates", candidates},
          {"terms", terms_of(candidates)}};
}

/// Stones as they were seen, with the standard deviations of their poses (mm along x, y, z; deg), and the
/// cloud (millimetres, packed).
json view_entry(const Observed& observed, double time) {
  json stones = json::array(), sigmas = json::array();
  for (const auto* list : {&observed.world.stack, &observed.world.loose})
    for (const StoneEstimate& s : *list) {
      stones.push_back({s.stone, numbers(s.T_W_O_seen)});
      const Eigen::Vector3d mm = 1e3 * s.sigma.translation_W;
      sigmas.push_back({rounded(mm.x(), 1e-3), rounded(mm.y(), 1e-3), rounded(mm.z(), 1e-3),
                        rounded(s.sigma.turn * 57.295779513082321, 1e-3)});
    }
  std::vector<std::int16_t> cloud;
  for (const Eigen::Vector3f& p_W : observed.cloud_W)
    for (int i = 0; i < 3; ++i)
      cloud.push_back(static_cast<std::int16_t>(std::lround(std::clamp(1e3F * p_W[i], -32e3F, 32e3F))));
  return {{"t", time}, {"stones", stones}, {"sigmas", sigmas}, {"cloud", packed(cloud)}};
}

/// Adds events from `from` on, in order of time: views of the stones, resting towers, decisions, log lines.
void add_events(json& page, const RunReport& report, const Catalogue& catalogue, const Times& times,
                PagePosition& from) {
  json views = json::array(), towers = json::array(), decisions = json::array(), events = json::array();
  std::vector<std::string>& why = from.why;
  for (std::size_t& i = from.events; i < report.result.events.size(); ++i) {
    const Event& event = report.result.events[i];
    const double time = times.of_event(i);
    const std::string text = to_text(event, catalogue);
    if (!text.empty()) events.push_back({{"t", time}, {"text", text}});
    if (const auto* observed = std::get_if<Observed>(&event)) {
      views.push_back(view_entry(*observed, time));
      const auto& resting = observed->world.resting;
      const auto whole = std::find_if(resting.begin(), resting.end(), [](const RestingStack& r) {
        return r.stack && !r.stack->stones.empty();
      });
      json tower =
          whole == resting.end()
              ? json{{"contacts", json::array()}, {"centres", json::array()}, {"thrust", json::array()}}
              : tower_entry(shapes_for_output(catalogue.stones), *whole);
      tower["t"] = time;
      towers.push_back(tower);
      why.clear();
    } else if (const auto* chosen = std::get_if<ActionChosen>(&event)) {
      decisions.push_back(decision_entry(*chosen, catalogue, time, from));
      why.clear();
    } else if (!text.empty()) {
      why.push_back(text);
    }
  }
  page["views"] = views;
  page["towers"] = towers;
  page["decisions"] = decisions;
  page["events"] = events;
}

json placement_rows(const RunReport& report) {
  json rows = json::array();
  const auto text = [](const Pose& pose) {
    const Eigen::Vector3d p = 1000.0 * pose.translation();
    return format("%.0f, %.0f, %.0f", p.x(), p.y(), p.z());
  };
  for (const PlacementRecord& r : report.result.placements) {
    std::string off;
    if (r.T_W_O_measured) {
      const Pose difference = r.planned.T_W_O.inverse() * *r.T_W_O_measured;
      off = format("%.1f mm, %.1f deg",
                   1000.0 * (r.planned.T_W_O.translation() - r.T_W_O_measured->translation()).norm(),
                   Eigen::AngleAxisd(difference.linear()).angle() * 57.295779513082321);
    }
    rows.push_back({{"level", r.level},
                    {"stone", r.stone},
                    {"outcome", to_text(r.outcome)},
                    {"predicted", r.planned.predicted_success},
                    {"cost", r.planned.cost},
                    {"terms", r.planned.terms},
                    {"planned", text(r.planned.T_W_O)},
                    {"measured", r.T_W_O_measured ? text(*r.T_W_O_measured) : "not seen"},
                    {"off", off},
                    {"note", r.note}});
  }
  return rows;
}

/// Names and values of the lines "name: value  # description" that `write_fields` writes.
std::map<std::string, std::string> option_values(const std::string& text) {
  std::map<std::string, std::string> values;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos)
      values[line.substr(0, colon)] = line.substr(colon + 2, line.find("  #", colon) - colon - 2);
  }
  return values;
}

/// Options that differ from their defaults: name, value, default.
json changed_options(const std::string& yaml) {
  SimulatedRun defaults;
  const auto usual = option_values(write_fields(fields(defaults)));
  json rows = json::array();
  for (const auto& [name, value] : option_values(yaml)) {
    const auto known = usual.find(name);
    if (known == usual.end() || known->second != value)
      rows.push_back({name, value, known == usual.end() ? "" : known->second});
  }
  return rows;
}

json truth_facts(const TruthReport& truth) {
  json engines = json::array();
  for (const EngineVerdict& verdict : truth.engines) engines.push_back({verdict.engine, verdict.height});
  return {{"height", truth.height},
          {"stands", truth.stands},
          {"seconds", truth.seconds},
          {"engines", engines},
          {"disagree", engines_disagree(truth)}};
}

/// The paper's figure 5 of one run.
std::string cost_figure(const RunReport& report) {
  Experiment alone;
  alone.per_run = std::max(1, report.result.height);
  ExperimentRun& run =
      alone.runs.emplace_back();  // without events and motion, which the figure does not show
  run.report.seed = report.seed;
  run.report.truth = report.truth;
  run.report.result.height = report.result.height;
  run.report.result.placements = report.result.placements;
  return figure5_svg(alone);
}

/// Values that a run changes as it goes on.
json values_of(const RunReport& report, const RobotModel& robot, const Times& times) {
  const RunResult& result = report.result;
  return {{"title", run_title(report)},
          {"height", result.height},
          {"paper_height", paper_height(report)},
          {"ended", to_text(result.end)},
          {"truth", report.truth ? truth_facts(*report.truth) : json(nullptr)},
          {"seconds",
           {{"detection", result.seconds.detection},
            {"search", result.seconds.search},
            {"planning", result.seconds.planning},
            {"motion", result.seconds.motion},
            {"beside_motion", result.seconds.beside_motion}}},
          {"robot_model", robot_entry(robot, result.world.layout)},
          {"carries", carries(report, robot, times)},
          {"placements", placement_rows(report)},
          {"figure5", cost_figure(report)}};
}

json changes_of(const RunReport& report, const Catalogue& catalogue, const RobotModel& robot,
                PagePosition& from) {
  const Times times(report.result.timeline);
  json page = json::object();
  const json values = values_of(report, robot, times);
  for (const auto& [name, value] : values.items()) {
    std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
    if (std::string& known = from.values[name]; known != text) {
      page[name] = value;
      known = std::move(text);
    }
  }
  if (from.stones != catalogue.stones.size()) {
    page["stones"] = json::array();
    for (const Stone& stone : catalogue.stones) page["stones"].push_back(stone_entry(stone));
    from.stones = catalogue.stones.size();
  }
  page["samples"] = packed_samples(report.result.timeline, times, from.samples);
  add_events(page, report, catalogue, times, from);
  return page;
}

}  // namespace

std::string one_line(const json& page) {
  return page.dump(-1, ' ', false, json::error_handler_t::replace);
}

std::string page_changes(const RunReport& report, const Catalogue& catalogue, const RobotModel& robot,
                         PagePosition& from) {
  return one_line(changes_of(report, catalogue, robot, from));
}

std::string page_data(const RunReport& report, const Catalogue& catalogue, const RobotModel& robot,
                      const std::string& picture) {
  const RunResult& result = report.result;
  const CellLayout& layout = result.world.layout;
  PagePosition begin;
  json page = changes_of(report, catalogue, robot, begin);
  page.update(json{
      {"robot", report.robot},
      {"seed", report.seed},
      {"cell", cell_text(report)},
      {"version", report.version},
      {"catalogue", report.catalogue},
      {"present", report.present.empty() ? static_cast<std::size_t>(result.height) : report.present.size()},
      {"site", {layout.site.x(), layout.site.y()}},
      {"field",
       {{"centre", {layout.field_centre.x(), layout.field_centre.y()}},
        {"size", {layout.field_size.x(), layout.field_size.y()}}}},
      {"terms", kTerms},
      {"changed", changed_options(report.options_text)},
      {"options", report.options_text},
      {"picture", picture}});
  if (report.modelling) page["modelling"] = modelling_entry(*report.modelling);
  return one_line(page);
}

}  // namespace stonestack::report
