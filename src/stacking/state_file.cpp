#include "stacking/state_file.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include "geometry/pose_json.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::stacking {
namespace {

using nlohmann::json;

constexpr const char* kSchema = "stonestack.state/1";
constexpr std::size_t kMaxFile = std::size_t{1} << 26;
/// Names of ExecutionResult::Status, in its order.
constexpr std::array<std::string_view, 6> kStatuses{"released", "not_picked", "lost",
                                                    "stopped",  "unknown",    "taken_back"};

// Poses and vectors.

json vector_json(const Eigen::Vector3d& p) {
  return {{"x", p.x()}, {"y", p.y()}, {"z", p.z()}};
}
json vector_json(const Eigen::Vector2d& p) {
  return {{"x", p.x()}, {"y", p.y()}};
}
Eigen::Vector3d vector3_of(const json& j) {
  return {j.at("x").get<double>(), j.at("y").get<double>(), j.at("z").get<double>()};
}
Eigen::Vector2d vector2_of(const json& j) {
  return {j.at("x").get<double>(), j.at("y").get<double>()};
}
Pose pose_of(const json& j) {
  const Eigen::Quaterniond q(j.at("qw").get<double>(), j.at("qx").get<double>(), j.at("qy").get<double>(),
                             j.at("qz").get<double>());
  require(std::abs(q.norm() - 1.0) < 1e-3, "a quaternion has the length ", q.norm(), ", not 1");
  return make_pose(vector3_of(j), q.normalized());
}
template <class T, class F>
json list_json(const std::vector<T>& list, const F& one) {
  json array = json::array();
  for (const T& item : list) array.push_back(one(item));
  return array;
}
template <class F>
auto list_of(const json& j, const F& one) {
  std::vector<decltype(one(j))> list;
  for (const json& item : j) list.push_back(one(item));
  return list;
}

std::string text(Route route) {
  return route == Route::kReorienting ? "reorienting" : "direct";
}
Route route_of(const json& j) {
  return j.get<std::string>() == "reorienting" ? Route::kReorienting : Route::kDirect;
}

// Everything that names stones.

struct Writer {
  const Catalogue& catalogue;

  [[nodiscard]] const std::string& name(StoneIndex stone) const { return catalogue[stone].name; }
  [[nodiscard]] json placed(const PlacedStone& s) const {
    return {{"stone", name(s.stone)}, {"T_W_O", pose_json(s.T_W_O)}};
  }
  [[nodiscard]] json placed_list(const std::vector<PlacedStone>& list) const {
    return list_json(list, [&](const PlacedStone& s) { return placed(s); });
  }
  [[nodiscard]] json estimates(const std::vector<StoneEstimate>& list) const {
    return list_json(list, [&](const StoneEstimate& s) {
      return json{{"stone", name(s.stone)},
                  {"T_W_O_seen", pose_json(s.T_W_O_seen)},
                  {"T_W_O_at_rest", pose_json(s.T_W_O_at_rest)}};
    });
  }
  [[nodiscard]] json placement(const Placement& p) const {
    json j{{"stone", name(p.stone)},
           {"T_W_O", pose_json(p.T_W_O)},
           {"cost", p.cost},
           {"terms", p.terms},
           {"predicted_success", p.predicted_success},
           {"expected_height", p.expected_height},
           {"then", placed_list(p.then)}};
    if (!p.then_compared.empty())
      j["then_compared"] = list_json(p.then_compared, [&](const auto& list) { return alternatives(list); });
    return j;
  }
  [[nodiscard]] json alternatives(const std::vector<Alternative>& list) const {
    return list_json(list, [&](const Alternative& a) {
      return json{{"stone", name(a.stone)},
                  {"T_W_O", pose_json(a.T_W_O)},
                  {"cost", a.cost},
                  {"terms", a.terms},
                  {"predicted_success", a.predicted_success},
                  {"expected_height", a.expected_height},
                  {"why_not", a.why_not}};
    });
  }
  [[nodiscard]] json placements(const std::vector<Placement>& list) const {
    return list_json(list, [&](const Placement& p) { return placement(p); });
  }
  template <class T, class F>
  [[nodiscard]] json by_stone(const std::map<StoneIndex, T>& map, const F& one) const {
    json object = json::object();
    for (const auto& [stone, value] : map) object[name(stone)] = one(value);
    return object;
  }
  [[nodiscard]] json stones(const std::set<StoneIndex>& set) const {
    json array = json::array();
    for (const StoneIndex stone : set) array.push_back(name(stone));
    return array;
  }
  [[nodiscard]] json record(const PlacementRecord& r) const {
    return {{"stone", r.stone},
            {"planned", placement(r.planned)},
            {"T_W_O_measured", r.T_W_O_measured ? pose_json(*r.T_W_O_measured) : json(nullptr)},
            {"T_W_O_at_rest", r.T_W_O_at_rest ? pose_json(*r.T_W_O_at_rest) : json(nullptr)},
            {"outcome", to_text(r.outcome)},
            {"note", r.note},
            {"level", r.level},
            {"course", r.course},
            {"p_W_aim", vector_json(r.p_W_aim)}};
  }
  [[nodiscard]] json attempt(const Attempt& a) const {
    json j{{"action", name_of(a.action)},
           {"status", kStatuses[static_cast<std::size_t>(a.done.status)]},
           {"reason", a.done.reason},
           {"contact_force", a.done.contact_force},
           {"placement", placement(a.placement)},
           {"T_O_T", pose_json(a.T_O_T)},
           {"p_W_aim", vector_json(a.p_W_aim)},
           {"below", placed_list(a.below)},
           {"course", a.course},
           {"expected_stack", estimates(a.expected_stack)},
           {"expected_loose", estimates(a.expected_loose)}};
    if (a.done.friction) j["friction"] = *a.done.friction;
    if (a.done.weight) j["weight"] = *a.done.weight;
    return j;
  }
  [[nodiscard]] json wall(const WallPlanned& wall) const {
    return {{"T_W_V", pose_json(wall.T_W_V)},
            {"course", by_stone(wall.course, [](int course) { return course; })}};
  }
  [[nodiscard]] json search(const SearchOutcome& s) const {
    json j{{"found", placements(s.found.best)},
           {"reason", s.found.reason},
           {"friction_level", s.friction_level},
           {"route", text(s.route)},
           {"graspable", stones({s.graspable.begin(), s.graspable.end()})},
           {"refused", s.refused},
           {"refusals", s.refusals}};
    if (!s.found.others.empty()) j["others"] = alternatives(s.found.others);
    if (s.wall) j["wall"] = wall(*s.wall);
    if (s.dead_end)
      j["dead_end"] = {{"end", static_cast<int>(s.dead_end->end)}, {"reason", s.dead_end->reason}};
    if (s.expected_unstacked) j["expected_unstacked"] = *s.expected_unstacked;
    return j;
  }
};

struct Reader {
  const Catalogue& catalogue;

  [[nodiscard]] StoneIndex stone(const json& j) const { return catalogue.index(j.get<std::string>()); }
  [[nodiscard]] PlacedStone placed(const json& j) const {
    return {stone(j.at("stone")), pose_of(j.at("T_W_O"))};
  }
  [[nodiscard]] std::vector<PlacedStone> placed_list(const json& j) const {
    return list_of(j, [&](const json& item) { return placed(item); });
  }
  [[nodiscard]] std::vector<StoneEstimate> estimates(const json& j) const {
    return list_of(j, [&](const json& s) {
      return StoneEstimate{stone(s.at("stone")), pose_of(s.at("T_W_O_seen")), pose_of(s.at("T_W_O_at_rest"))};
    });
  }
  [[nodiscard]] Placement placement(const json& j) const {
    Placement p;
    p.stone = stone(j.at("stone"));
    p.T_W_O = pose_of(j.at("T_W_O"));
    p.cost = j.at("cost").get<double>();
    p.terms = j.at("terms").get<std::map<std::string, double>>();
    p.predicted_success = j.at("predicted_success").get<double>();
    p.expected_height = j.at("expected_height").get<double>();
    p.then = placed_list(j.at("then"));
    if (j.contains("then_compared"))
      p.then_compared = list_of(j.at("then_compared"), [&](const json& list) { return alternatives(list); });
    return p;
  }
  [[nodiscard]] std::vector<Alternative> alternatives(const json& j) const {
    return list_of(j, [&](const json& a) {
      return Alternative{stone(a.at("stone")),
                         pose_of(a.at("T_W_O")),
                         a.at("cost").get<double>(),
                         a.at("terms").get<std::map<std::string, double>>(),
                         a.at("predicted_success").get<double>(),
                         a.at("expected_height").get<double>(),
                         a.at("why_not").get<std::string>()};
    });
  }
  template <class F>
  [[nodiscard]] auto by_stone(const json& j, const F& one) const {
    std::map<StoneIndex, decltype(one(j))> map;
    for (const auto& [name, value] : j.items()) map[catalogue.index(name)] = one(value);
    return map;
  }
  [[nodiscard]] std::set<StoneIndex> stones(const json& j) const {
    std::set<StoneIndex> set;
    for (const json& item : j) set.insert(stone(item));
    return set;
  }
  [[nodiscard]] PlacementRecord record(const json& j) const {
    using Outcome = PlacementRecord::Outcome;
    PlacementRecord r;
    r.stone = j.at("stone").get<std::string>();
    r.planned = placement(j.at("planned"));
    if (!j.at("T_W_O_measured").is_null()) r.T_W_O_measured = pose_of(j.at("T_W_O_measured"));
    if (!j.at("T_W_O_at_rest").is_null()) r.T_W_O_at_rest = pose_of(j.at("T_W_O_at_rest"));
    const auto outcome = j.at("outcome").get<std::string>();
    bool known = false;
    for (const Outcome one :
         {Outcome::kPlaced, Outcome::kMoved, Outcome::kFallen, Outcome::kNotPicked, Outcome::kDropped,
          Outcome::kLost, Outcome::kUnstacked, Outcome::kReoriented, Outcome::kPushed})
      if (to_text(one) == outcome) {
        r.outcome = one;
        known = true;
      }
    require(known, "no outcome is called '", outcome, "'");
    r.note = j.at("note").get<std::string>();
    r.level = j.at("level").get<int>();
    r.course = j.value("course", 0);
    r.p_W_aim = vector3_of(j.at("p_W_aim"));
    return r;
  }
  [[nodiscard]] Attempt attempt(const json& j) const {
    Attempt a;
    const auto action = j.at("action").get<std::string>();
    for (const Action& one :
         {Action(Place{}), Action(Reorient{}), Action(Unstack{}), Action(ClearBase{}), Action(Push{})})
      if (name_of(one) == action) a.action = one;
    require(name_of(a.action) == action, "no stone is brought anywhere by '", action, "'");
    const auto status = std::find(kStatuses.begin(), kStatuses.end(), j.at("status").get<std::string>());
    require(status != kStatuses.end(), "no status is called ", j.at("status"));
    a.done.status = static_cast<ExecutionResult::Status>(status - kStatuses.begin());
    a.done.reason = j.at("reason").get<std::string>();
    a.done.contact_force = j.at("contact_force").get<double>();
    if (j.contains("friction")) a.done.friction = j.at("friction").get<double>();
    if (j.contains("weight")) a.done.weight = j.at("weight").get<double>();
    a.placement = placement(j.at("placement"));
    a.T_O_T = pose_of(j.at("T_O_T"));
    a.p_W_aim = vector3_of(j.at("p_W_aim"));
    a.below = placed_list(j.at("below"));
    a.course = j.at("course").get<int>();
    a.expected_stack = estimates(j.at("expected_stack"));
    a.expected_loose = estimates(j.at("expected_loose"));
    return a;
  }
  [[nodiscard]] WallPlanned wall(const json& j) const {
    return {pose_of(j.at("T_W_V")),
            by_stone(j.at("course"), [](const json& course) { return course.get<int>(); })};
  }
  [[nodiscard]] SearchOutcome search(const json& j) const {
    SearchOutcome s;
    s.found.best = list_of(j.at("found"), [&](const json& p) { return placement(p); });
    if (j.contains("others")) s.found.others = alternatives(j.at("others"));
    s.found.reason = j.at("reason").get<std::string>();
    s.friction_level = j.at("friction_level").get<std::size_t>();
    s.route = route_of(j.at("route"));
    const std::set<StoneIndex> graspable = stones(j.at("graspable"));
    s.graspable.assign(graspable.begin(), graspable.end());
    s.refused = j.at("refused").get<int>();
    s.refusals = j.at("refusals").get<std::string>();
    if (j.contains("wall")) s.wall = wall(j.at("wall"));
    if (j.contains("dead_end"))
      s.dead_end = Stop{static_cast<RunEnd>(j.at("dead_end").at("end").get<int>()),
                        j.at("dead_end").at("reason").get<std::string>()};
    if (j.contains("expected_unstacked"))
      s.expected_unstacked = j.at("expected_unstacked").get<std::vector<double>>();
    return s;
  }
};

// The parts of a state.

CellLayout layout_of(const json& j) {
  CellLayout layout;
  layout.T_W_R = pose_of(j.at("T_W_R"));
  layout.T_F_T = pose_of(j.at("T_F_T"));
  layout.T_T_C = pose_of(j.at("T_T_C"));
  layout.sensor_mass = j.at("sensor_mass").get<double>();
  layout.camera_mass = j.at("camera_mass").get<double>();
  layout.linkage = j.value("linkage", layout.linkage);
  layout.gripper = j.value("hand", layout.gripper);
  layout.site = vector2_of(j.at("site"));
  layout.field_centre = vector2_of(j.at("field_centre"));
  layout.field_size = vector2_of(j.at("field_size"));
  for (const json& o : j.at("obstacles")) {
    Obstacle obstacle;
    obstacle.name = o.at("name").get<std::string>();
    obstacle.T_W_O = pose_of(o.at("T_W_O"));
    for (const json& piece : o.at("pieces")) {
      Mesh mesh;
      for (const json& v : piece.at("vertices"))
        mesh.vertices.emplace_back(v.at(0).get<double>(), v.at(1).get<double>(), v.at(2).get<double>());
      for (const json& t : piece.at("faces"))
        mesh.faces.emplace_back(t.at(0).get<int>(), t.at(1).get<int>(), t.at(2).get<int>());
      obstacle.pieces.push_back(std::move(mesh));
    }
    layout.obstacles.push_back(std::move(obstacle));
  }
  for (const json& p : j.at("paddings")) {
    PairPadding padding;
    padding.a = p.at("a").get<std::string>();
    padding.b = p.at("b").get<std::string>();
    padding.m = p.at("m").get<double>();
    layout.paddings.push_back(padding);
  }
  return layout;
}

json memory_json(const RunMemory& m, const Writer& w) {
  const auto poses = [](const std::vector<Pose>& list) {
    return list_json(list, [](const Pose& pose) { return pose_json(pose); });
  };
  const auto vectors = [](const std::vector<Eigen::Vector3d>& list) {
    return list_json(list, [](const Eigen::Vector3d& v) { return vector_json(v); });
  };
  json j{{"friction", {{"frictions", m.friction.frictions}, {"weights", m.friction.weights}}},
         {"friction_measured", m.friction_measured},
         {"records", list_json(m.records, [&](const PlacementRecord& r) { return w.record(r); })},
         {"actions", m.actions},
         {"failures", m.failures},
         {"unstacked", m.unstacked},
         {"reoriented", m.reoriented},
         {"cleared", m.cleared},
         {"pushed", m.pushed},
         {"failed_grasps", w.by_stone(m.failed_grasps, poses)},
         {"no_pick", w.by_stone(m.no_pick, poses)},
         {"toppled", w.by_stone(m.toppled, vectors)},
         {"given_up", w.placed_list(m.given_up)},
         {"refused", w.placed_list(m.refused)},
         {"last_seen", w.by_stone(m.last_seen, [](const Eigen::Vector3d& p) { return vector_json(p); })},
         {"out_of_sight", w.stones(m.out_of_sight)},
         {"awaited", w.stones(m.awaited)},
         {"disproved", w.stones(m.disproved)},
         {"too_light", w.stones(m.too_light)},
         {"modelled_anew", m.modelled_anew},
         {"p_W_objects", list_json(m.p_W_objects, [](const Eigen::Vector2d& p) { return vector_json(p); })},
         {"sought_where_it_was", w.stones(m.sought_where_it_was)},
         {"sought_beside_site", m.sought_beside_site},
         {"not_pushed", w.stones(m.not_pushed)},
         {"stray_stays", m.stray_stays},
         {"stack_stays", m.stack_stays}};
  if (m.plan)
    j["plan"] = {{"placement", w.placement(m.plan->placement)},
                 {"stack_before", m.plan->stack_before},
                 {"friction_level", m.plan->friction_level},
                 {"route", text(m.plan->route)},
                 {"compared", w.alternatives(m.plan->compared)}};
  if (m.wall) j["wall"] = w.wall(*m.wall);
  if (m.failure) j["failure"] = {{"end", static_cast<int>(m.failure->end)}, {"reason", m.failure->reason}};
  if (m.unstacking) {
    j["unstacking"] = {{"remaining", m.unstacking->remaining},
                       {"tried", m.unstacking->tried},
                       {"down_to", m.unstacking->down_to}};
    if (m.unstacking->freed) j["unstacking"]["freed"] = w.placed(*m.unstacking->freed);
  }
  if (m.search) j["search"] = w.search(*m.search);
  if (m.attempt) j["attempt"] = w.attempt(*m.attempt);
  return j;
}

RunMemory memory_of(const json& j, const Reader& r) {
  const auto poses = [](const json& list) { return list_of(list, pose_of); };
  const auto vectors = [](const json& list) { return list_of(list, vector3_of); };
  RunMemory m;
  m.friction.frictions = j.at("friction").at("frictions").get<std::vector<double>>();
  m.friction.weights = j.at("friction").at("weights").get<std::vector<double>>();
  require(!m.friction.frictions.empty() && m.friction.weights.size() == m.friction.frictions.size(),
          "friction needs as many weights as frictions");
  m.friction_measured = j.value("friction_measured", false);
  m.records = list_of(j.at("records"), [&](const json& record) { return r.record(record); });
  m.actions = j.at("actions").get<int>();
  m.failures = j.at("failures").get<int>();
  m.unstacked = j.at("unstacked").get<int>();
  m.reoriented = j.at("reoriented").get<int>();
  m.cleared = j.at("cleared").get<int>();
  m.pushed = j.value("pushed", 0);
  m.failed_grasps = r.by_stone(j.at("failed_grasps"), poses);
  m.no_pick = r.by_stone(j.at("no_pick"), poses);
  m.toppled = r.by_stone(j.at("toppled"), vectors);
  m.given_up = r.placed_list(j.at("given_up"));
  m.refused = r.placed_list(j.at("refused"));
  m.last_seen = r.by_stone(j.at("last_seen"), vector3_of);
  m.out_of_sight = r.stones(j.at("out_of_sight"));
  if (j.contains("awaited")) m.awaited = r.stones(j.at("awaited"));
  if (j.contains("disproved")) m.disproved = r.stones(j.at("disproved"));
  if (j.contains("too_light")) m.too_light = r.stones(j.at("too_light"));
  m.modelled_anew = j.value("modelled_anew", 0);
  if (j.contains("p_W_objects"))
    m.p_W_objects = list_of(j.at("p_W_objects"), [](const json& p) { return vector2_of(p); });
  m.sought_where_it_was = r.stones(j.at("sought_where_it_was"));
  if (j.contains("not_pushed")) m.not_pushed = r.stones(j.at("not_pushed"));
  m.sought_beside_site = j.at("sought_beside_site").get<int>();
  m.stray_stays = j.at("stray_stays").get<bool>();
  m.stack_stays = j.at("stack_stays").get<bool>();
  if (j.contains("plan")) {
    m.plan = FollowedPlan{
        r.placement(j.at("plan").at("placement")), j.at("plan").at("stack_before").get<std::size_t>(),
        j.at("plan").at("friction_level").get<std::size_t>(), route_of(j.at("plan").at("route"))};
    if (j.at("plan").contains("compared")) m.plan->compared = r.alternatives(j.at("plan").at("compared"));
  }
  if (j.contains("wall")) m.wall = r.wall(j.at("wall"));
  if (j.contains("failure"))
    m.failure = Failure{static_cast<RunEnd>(j.at("failure").at("end").get<int>()),
                        j.at("failure").at("reason").get<std::string>()};
  if (j.contains("unstacking")) {
    const json& u = j.at("unstacking");
    m.unstacking = Unstacking{u.at("remaining").get<int>(), u.at("tried").get<int>(),
                              u.at("down_to").get<std::size_t>(), std::nullopt};
    if (u.contains("freed")) m.unstacking->freed = r.placed(u.at("freed"));
  }
  if (j.contains("search")) m.search = r.search(j.at("search"));
  if (j.contains("attempt")) m.attempt = r.attempt(j.at("attempt"));
  return m;
}

/// The path; empty for the stones that come with stonestack, wherever they are.
std::string catalogue_name(const std::string& path) {
  try {
    return path == data_path("stones") ? "" : path;
  } catch (const FileError&) {
    return path;
  }
}

/// Reads and checks the file; what is wrong with it becomes a FileError.
template <class F>
auto read_as(const std::string& path, const F& read) {
  try {
    const json j = json::parse(read_file(path, kMaxFile));
    require(j.at("schema").get<std::string>() == kSchema, "its schema is not ", kSchema);
    return read(j);
  } catch (const json::exception& problem) {
    throw FileError(path, concat("is no state: ", problem.what()), "give a file that run.save_states wrote");
  } catch (const InvalidArgument& problem) {
    throw FileError(path, concat("is no state: ", problem.what()),
                    "give a file that run.save_states wrote, and the catalogue of that run");
  }
}

}  // namespace

json changed_fields_json(const FieldList& list, const FieldList& usual) {
  json changed = json::object();
  for (std::size_t k = 0; k < list.size(); ++k)
    std::visit(
        [&](const auto* value) {
          using Value = std::remove_const_t<std::remove_pointer_t<decltype(value)>>;
          if (*value != *std::get<Value*>(usual[k].value)) changed[list[k].name] = *value;
        },
        list[k].value);
  return changed;
}

json layout_json(const CellLayout& layout) {
  return {{"T_W_R", pose_json(layout.T_W_R)},
          {"T_F_T", pose_json(layout.T_F_T)},
          {"T_T_C", pose_json(layout.T_T_C)},
          {"sensor_mass", layout.sensor_mass},
          {"camera_mass", layout.camera_mass},
          {"linkage", layout.linkage},
          {"hand", layout.gripper},
          {"site", vector_json(layout.site)},
          {"field_centre", vector_json(layout.field_centre)},
          {"field_size", vector_json(layout.field_size)},
          {"obstacles",
           list_json(layout.obstacles,
                     [](const Obstacle& o) {
                       return json{{"name", o.name},
                                   {"T_W_O", pose_json(o.T_W_O)},
                                   {"pieces", list_json(o.pieces, [](const Mesh& mesh) {
                                      return json{{"vertices", list_json(mesh.vertices,
                                                                         [](const Eigen::Vector3d& v) {
                                                                           return json{v.x(), v.y(), v.z()};
                                                                         })},
                                                  {"faces", list_json(mesh.faces, [](const auto& t) {
                                                     return json{t[0], t[1], t[2]};
                                                   })}};
                                    })}};
                     })},
          {"paddings", list_json(layout.paddings, [](const PairPadding& p) {
             return json{{"a", p.a}, {"b", p.b}, {"m", p.m}};
           })}};
}

json state_json(const WorldEstimate& world, const RunMemory& memory, const Models& models,
                const BuildOptions& options) {
  const Writer writer{*models.catalogue};
  constexpr const char* kSites[] = {"unseen", "free", "occupied"};
  BuildOptions copy = options, usual;
  return {{"schema", kSchema},
          {"catalogue", catalogue_name(models.catalogue->path)},
          {"robot", models.robot->name},
          {"options", changed_fields_json(fields(copy), fields(usual))},
          {"layout", layout_json(world.layout)},
          {"world",
           {{"site", kSites[static_cast<int>(world.site)]},
            {"stack", writer.estimates(world.stack)},
            {"loose", writer.estimates(world.loose)}}},
          {"memory", memory_json(memory, writer)}};
}

void write_state(const std::string& path, const WorldEstimate& world, const RunMemory& memory,
                 const Models& models, const BuildOptions& options) {
  write_file(path, state_json(world, memory, models, options).dump(1) + "\n");
}

State state_of(const json& j, const Catalogue& catalogue) {
  require(j.at("schema").get<std::string>() == kSchema, "its schema is not ", kSchema);
  const Reader reader{catalogue};
  State state;
  state.catalogue = j.at("catalogue").get<std::string>();
  state.robot = j.at("robot").get<std::string>();
  const FieldList list = fields(state.options);
  for (const auto& [name, value] : j.at("options").items())
    set_field(list, concat(name, "=", value.is_string() ? value.get<std::string>() : value.dump()));
  const json& world = j.at("world");
  const auto site = world.at("site").get<std::string>();
  state.world.site = site == "free"       ? SiteStatus::kFree
                     : site == "occupied" ? SiteStatus::kOccupied
                                          : SiteStatus::kUnseen;
  state.world.layout = layout_of(j.at("layout"));
  state.world.stack = reader.estimates(world.at("stack"));
  state.world.loose = reader.estimates(world.at("loose"));
  state.memory = memory_of(j.at("memory"), reader);
  return state;
}

StateHeader read_state_header(const std::string& path) {
  return read_as(path, [](const json& j) {
    return StateHeader{j.at("catalogue").get<std::string>(), j.at("robot").get<std::string>()};
  });
}

State read_state(const std::string& path, const Catalogue& catalogue) {
  return read_as(path, [&](const json& j) { return state_of(j, catalogue); });
}

std::string decision_json(const Decision& decision, const Catalogue& catalogue) {
  const Writer w{catalogue};
  json action{{"kind", name_of(decision.action)}};
  json alternatives = json::array();
  const auto candidates = [&](const std::vector<Placement>& list) {
    if (list.empty()) return;
    action["placement"] = w.placement(list.front());
    for (auto other = list.begin() + 1; other != list.end(); ++other)
      alternatives.push_back(w.placement(*other));
  };
  const auto places = [&](const std::vector<Pose>& list) {
    if (list.empty()) return;
    action["T_W_O_down"] = pose_json(list.front());
    for (auto other = list.begin() + 1; other != list.end(); ++other)
      alternatives.push_back(pose_json(*other));
  };
  if (const auto* place = std::get_if<Place>(&decision.action)) candidates(place->candidates);
  if (const auto* reorient = std::get_if<Reorient>(&decision.action)) candidates(reorient->candidates);
  if (const auto* unstack = std::get_if<Unstack>(&decision.action)) {
    action["stone"] = w.name(unstack->top.stone);
    places(unstack->T_W_O_down);
  }
  if (const auto* clear = std::get_if<ClearBase>(&decision.action)) {
    action["stone"] = w.name(clear->stray.stone);
    action["level"] = clear->level + 1;
    places(clear->T_W_O_down);
  }
  if (const auto* push = std::get_if<Push>(&decision.action)) {
    action["stone"] = w.name(push->stone.stone);
    for (const Eigen::Vector2d& shift : push->p_W_shifts) {
      const json p{shift.x(), shift.y()};
      if (action.contains("p_W_shift"))
        alternatives.push_back(p);
      else
        action["p_W_shift"] = p;
    }
  }
  if (const auto* view = std::get_if<LookAgain>(&decision.action)) {
    action["stone"] = w.name(view->stone);
    action["p_W_target"] = vector_json(view->p_W_target);
  }
  if (const auto* model = std::get_if<ModelAnew>(&decision.action)) {
    action["lost"] = w.stones({model->lost.begin(), model->lost.end()});
    action["in_sight"] = model->in_sight;
  }
  if (const auto* stop = std::get_if<Stop>(&decision.action)) action["reason"] = stop->reason;
  json why = json::array();
  for (const Event& event : decision.why)
    if (const std::string line = to_text(event, catalogue); !line.empty()) why.push_back(line);
  return json{{"schema", "stonestack.decision/1"},
              {"action", action},
              {"alternatives", alternatives},
              {"why", why}}
             .dump(2) +
         "\n";
}

}  // namespace stonestack::stacking
