// StoneBench: fixed problems of stacking irregular stones, and one scorer for the answers of any planner. A
// problem names stones of a catalogue of generated limestones and asks for a tower, a wall or a bridge of
// them; an answer lists placements. Both engines judge it with exact placement.
#include "problems.hpp"

#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "geometry/json_file.hpp"
#include "geometry/pose_json.hpp"
#include "ode_witness.hpp"
#include "span_check.hpp"
#include "stone_draws.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/search/plan_wall.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "stonestack/stone/model_stone.hpp"

namespace stonestack::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kProblemsSchema = "stonestack.problems/1";
constexpr double kDeepest = 0.002;     // m that stones of an answer may overlap
constexpr double kSupportGap = 0.001;  // m: nearer is a contact
constexpr double kInTheWay = 0.002;    // m that a stone may reach into what is kept clear below a bridge
constexpr double kUnitNorm = 1e-3;     // by which the norm of a quaternion may be off

/// A problem: a tower of so many stones, a wall, or a bridge.
struct Problem {
  std::string name;
  int levels = 0;            ///< of a tower; else 0
  std::vector<int> courses;  ///< of a wall; else empty
  double span = 0.0;         ///< of a bridge [m], about the origin along x; else 0
  double friction = 0.3;
  std::vector<std::string> stones;

  [[nodiscard]] bool is_tower() const { return levels > 0; }
  [[nodiscard]] bool is_bridge() const { return span > 0.0; }
  [[nodiscard]] const char* kind() const { return is_tower() ? "tower" : is_bridge() ? "bridge" : "wall"; }
  /// Stones of a tower or a wall; a bridge takes as many as it needs.
  [[nodiscard]] int asked() const {
    int sum = levels;
    for (const int count : courses) sum += count;
    return sum;
  }
};

json to_json_entry(const Problem& problem) {
  json entry = {{"name", problem.name}, {"friction", problem.friction}, {"stones", problem.stones}};
  if (problem.is_tower())
    entry["levels"] = problem.levels;
  else if (problem.is_bridge())
    entry["span"] = problem.span;
  else
    entry["courses"] = problem.courses;
  return entry;
}

std::vector<Problem> read_problems(const std::string& folder) {
  const std::string path = folder + "/problems.json";
  std::vector<Problem> problems;
  try {
    const json file = read_json(path);
    if (file.at("schema") != kProblemsSchema)
      throw FileError(path, "is not of this version", concat("it must have the schema ", kProblemsSchema));
    for (const json& entry : file.at("problems")) {
      Problem problem;
      problem.name = entry.at("name").get<std::string>();
      problem.friction = entry.at("friction").get<double>();
      problem.stones = entry.at("stones").get<std::vector<std::string>>();
      if (entry.contains("courses")) problem.courses = entry.at("courses").get<std::vector<int>>();
      if (entry.contains("span")) problem.span = entry.at("span").get<double>();
      if (problem.courses.empty() && !entry.contains("span")) problem.levels = entry.at("levels").get<int>();
      if (!is_stone_name(problem.name) || (problem.asked() < 1 && !(problem.span > 0.0)) ||
          !(problem.friction > 0.0))
        throw FileError(path, concat("has the impossible problem '", problem.name, "'"),
                        "make it with `stonestack-bench problems`");
      problems.push_back(std::move(problem));
    }
  } catch (const json::exception& problem) {
    throw FileError(path, concat("is no list of problems: ", problem.what()),
                    "make it with `stonestack-bench problems`");
  }
  return problems;
}

/// Kinds of problems, in turn: what is asked for, how many stones there are beyond that, and the friction.
struct Kind {
  int levels;
  std::vector<int> courses;
  double span;
  int spare;
  double friction;
};
const std::vector<Kind>& kinds() {
  static const std::vector<Kind> list = {
      {4, {}, 0.0, 0, 0.1},  {0, {2, 1}, 0.0, 0, 0.3}, {4, {}, 0.0, 2, 0.3},  {0, {3, 2, 1}, 0.0, 0, 0.3},
      {0, {}, 0.08, 5, 0.3}, {6, {}, 0.0, 2, 0.5},     {0, {}, 0.12, 8, 0.5}, {0, {4, 3, 2, 1}, 0.0, 2, 0.3},
      {8, {}, 0.0, 2, 0.5},  {0, {}, 0.2, 10, 0.5}};
  return list;
}

struct ProblemsOptions {
  std::string out;
  int count = 100, pool = 60, seed = 1;
};

void write_problems(const ProblemsOptions& options, Results& results) {
  results.settings({{"count", options.count}, {"stones", options.pool}, {"seed", options.seed}});
  const std::string stones = options.out + "/stones";
  for (int number = 1; number <= options.pool; ++number) {
    throw_if_interrupted();
    write_stone(stones, model_limestone(static_cast<std::uint64_t>(options.seed), number).stone);
  }
  const Catalogue catalogue = read_catalogue(stones);
  Random random = Random::stream(static_cast<std::uint64_t>(options.seed), "problems");
  json list = json::array();
  std::map<std::string, int> counts;
  for (int k = 0; k < options.count; ++k) {
    const Kind& kind = kinds()[static_cast<std::size_t>(k) % kinds().size()];
    std::string number = std::to_string(k + 1);
    number.insert(0, number.size() < 3 ? 3 - number.size() : 0, '0');
    Problem problem{"", kind.levels, kind.courses, kind.span, kind.friction, {}};
    problem.name = concat(problem.kind(), "-", number);
    std::vector<std::size_t> order(catalogue.stones.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    random.shuffle(order.begin(), order.end());
    const auto wanted = static_cast<std::size_t>(problem.asked() + kind.spare);
    require(wanted <= order.size(), "problem ", problem.name, " needs ", wanted, " stones; give --stones ",
            wanted, " or more");
    for (std::size_t i = 0; i < wanted; ++i) problem.stones.push_back(catalogue.stones[order[i]].name);
    ++counts[problem.kind()];
    list.push_back(to_json_entry(problem));
  }
  write_file(options.out + "/problems.json",
             json{{"schema", kProblemsSchema}, {"seed", options.seed}, {"problems", list}}.dump(1) + "\n");
  results.table("problems", {{"kind"}, {"problems"}});
  for (const auto& [kind, count] : counts) results.row({kind, count});
}

/// Stones and shapes of a folder of problems.
struct Pool {
  Catalogue catalogue;
  ShapeList shapes;
};
Pool read_pool(const std::string& folder) {
  Pool pool;
  pool.catalogue = read_catalogue(folder + "/stones");
  pool.shapes = make_contact_shapes(pool.catalogue.stones);
  return pool;
}

/// Target of a wall or a bridge; below a bridge is kept clear as much as `read_wall_target` says.
WallTarget target_of(const Problem& problem) {
  if (problem.is_bridge()) return read_wall_target(concat("bridge:", problem.span));
  WallTarget target;
  target.courses = problem.courses;
  return target;
}

struct SolveOptions {
  std::string folder, out, method = "default";
  SearchOptions search = search_without_robot();
};

/// The placements of this library's planner, or of the paper's.
std::vector<Placement> solve_one(const SolveOptions& options, const Pool& pool, const Problem& problem) {
  SearchProblem search;
  search.shapes = &pool.shapes;
  for (const std::string& name : problem.stones)
    search.available.push_back({pool.catalogue.index(name), Pose::Identity()});
  SearchOptions of_problem = options.search;
  of_problem.method = options.method;
  of_problem.friction = problem.friction;
  if (problem.is_tower()) return plan_tower(search, problem.levels, of_problem).placements;
  if (options.method == "paper") return {};  // it knows neither walls nor bridges
  const WallTarget target = target_of(problem);
  std::vector<Placement> placements;
  for (const WallPlacement& next : plan_wall(search, target, of_problem).placements)
    placements.push_back(next.placement);
  return placements;
}

void solve_all(const SolveOptions& options, Results& results) {
  const Pool pool = read_pool(options.folder);
  results.settings({{"method", options.method}, {"seed", options.search.seed}});
  results.table("answers", {{"problem"}, {"asked"}, {"placed"}, {"cpu_s", 1}});
  for (const Problem& problem : read_problems(options.folder)) {
    const double start = processor_seconds();
    const std::vector<Placement> placements = solve_one(options, pool, problem);
    throw_if_interrupted();
    json list = json::array();
    for (const Placement& p : placements)
      list.push_back({{"stone", pool.catalogue[p.stone].name}, {"T_W_O", pose_json(p.T_W_O)}});
    write_file(concat(options.out, "/", problem.name, ".json"), json{{"placements", list}}.dump(1) + "\n");
    results.row({problem.name, problem.asked(), placements.size(), processor_seconds() - start});
  }
}

/// A planner's answer; `refused` says why it counts nothing.
struct Answer {
  Stack stones;
  std::string refused;
};

Pose pose_of(const json& entry) {
  const auto number = [&](const char* key) { return entry.at(key).get<double>(); };
  const Eigen::Quaterniond q(number("qw"), number("qx"), number("qy"), number("qz"));
  if (!(std::abs(q.norm() - 1.0) < kUnitNorm)) throw InvalidArgument("a quaternion is not of unit norm");
  Pose pose = Pose::Identity();
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() << number("x"), number("y"), number("z");
  if (!pose.translation().allFinite()) throw InvalidArgument("a position is not finite");
  return pose;
}

Answer read_answer(const std::string& path, const Problem& problem, const Pool& pool) {
  Answer answer;
  if (!fs::exists(path)) return {{}, "no answer"};
  try {
    const json file = read_json(path);
    for (const json& entry : file.at("placements")) {
      const auto name = entry.at("stone").get<std::string>();
      if (std::find(problem.stones.begin(), problem.stones.end(), name) == problem.stones.end())
        return {{}, name + " is not a stone of the problem"};
      const StoneIndex stone = pool.catalogue.index(name);
      for (const PlacedStone& placed : answer.stones.stones)
        if (placed.stone == stone) return {{}, name + " is placed twice"};
      answer.stones.stones.push_back({stone, pose_of(entry.at("T_W_O"))});
    }
  } catch (const json::exception& fault) {
    return {{}, concat("cannot be read: ", fault.what())};
  } catch (const Error& fault) {
    return {{}, fault.what()};
  }
  answer.refused = overlap_of(pool.shapes, answer.stones, kDeepest);
  if (answer.stones.stones.empty()) answer.refused = "holds no placements";
  return answer;
}

/// Course of each stone, from what it rests on: 0 on the table, else one more than the highest below it; -1:
/// in the air, or on a stone that comes later.
std::vector<int> courses_of(const Pool& pool, const Stack& stones) {
  std::vector<int> courses(stones.stones.size(), -1);
  std::vector<std::vector<int>> below(courses.size());
  for (const Contact& contact : geometric_contacts(pool.shapes, stones, kSupportGap)) {
    const bool up = contact.n_W.z() > 0.3, down = contact.n_W.z() < -0.3;
    if (up) below[static_cast<std::size_t>(contact.above)].push_back(contact.below);
    if (down && contact.below != kTable)
      below[static_cast<std::size_t>(contact.below)].push_back(contact.above);
  }
  for (std::size_t k = 0; k < courses.size(); ++k)
    for (const int support : below[k]) {
      if (support > static_cast<int>(k)) return std::vector<int>(courses.size(), -1);
      const int of_support = support == kTable ? -1 : courses[static_cast<std::size_t>(support)];
      courses[k] = std::max(courses[k], of_support + 1);
    }
  return courses;
}

/// Verdict on an answer.
struct Score {
  double score = 0.0;       ///< share of what was asked for
  int bullet = 0, ode = 0;  ///< stones that stay, from the first placed on
  std::string note;
};

Score score_one(const Problem& problem, const Pool& pool, const Answer& answer) {
  Score score;
  score.note = answer.refused;
  if (!answer.refused.empty()) return score;
  StandOptions stand;
  stand.friction = problem.friction;
  const StandVerdict in_bullet = judge_stack(pool.shapes, answer.stones, stand);
  OdeOptions in_ode;
  in_ode.friction = problem.friction;
  score.ode = stand_in_ode(pool.shapes, answer.stones, in_ode).standing;
  const auto placed = static_cast<int>(answer.stones.stones.size());
  score.bullet = !problem.is_tower() && in_bullet.stands ? placed : in_bullet.standing;
  if (score.bullet < placed) score.note = in_bullet.reason;
  if (problem.is_tower()) {
    const int height = std::min({score.bullet, score.ode, problem.levels});
    score.score = static_cast<double>(height) / problem.levels;
    return score;
  }
  if (std::min(score.bullet, score.ode) < placed) return score;  // walls and bridges stand whole or not
  if (problem.is_bridge()) {
    const Span span = target_of(problem).task->spans.front();
    const SpanCheck all = check_span(pool.shapes, answer.stones, Pose::Identity(), span);
    if (all.in_the_way >= kInTheWay) {
      score.note = "a stone stands in the gap";
      return score;
    }
    score.score = check_span(pool.shapes, bridging_stones(pool.shapes, answer.stones, Pose::Identity(), span),
                             Pose::Identity(), span)
                      .covered;
    if (score.score < 1.0)
      score.note = concat(std::lround(1e2 * score.score), " % of the gap is spanned from both sides");
    return score;
  }
  const std::vector<int> courses = courses_of(pool, answer.stones);
  int counted = 0;
  for (std::size_t k = 0; k < problem.courses.size(); ++k)
    counted += std::min(problem.courses[k],
                        static_cast<int>(std::count(courses.begin(), courses.end(), static_cast<int>(k))));
  score.score = static_cast<double>(counted) / problem.asked();
  if (counted < problem.asked()) score.note = concat(counted, " stones in their courses");
  return score;
}

struct ScoreOptions {
  std::string folder, answers;
};

void score_all(const ScoreOptions& options, Results& results) {
  if (!fs::is_directory(options.answers))
    throw FileError(options.answers, "is no folder", "give the folder of the answers, NAME.json each");
  const Pool pool = read_pool(options.folder);
  const std::vector<Problem> problems = read_problems(options.folder);
  results.settings({{"problems", problems.size()}});
  results.table("scores", {{"problem"}, {"score", 3}, {"in_bullet"}, {"in_ode"}, {"note"}});
  struct Sum {
    int problems = 0, whole = 0;
    double score = 0.0;
  };
  std::map<std::string, Sum> sums;
  for (const Problem& problem : problems) {
    throw_if_interrupted();
    const Answer answer = read_answer(concat(options.answers, "/", problem.name, ".json"), problem, pool);
    const Score score = score_one(problem, pool, answer);
    results.row({problem.name, score.score, score.bullet, score.ode, score.note});
    for (const std::string& kind : {std::string(problem.kind()), std::string("all")}) {
      Sum& sum = sums[kind];
      ++sum.problems;
      sum.whole += score.score >= 1.0 ? 1 : 0;
      sum.score += score.score;
    }
  }
  results.table("stonebench", {{"kind"}, {"problems"}, {"whole"}, {"mean_score", 3}});
  for (const auto& [kind, sum] : sums) results.row({kind, sum.problems, sum.whole, sum.score / sum.problems});
}

}  // namespace

void add_problems(CLI::App& app) {
  auto options = std::make_shared<ProblemsOptions>();
  CLI::App* sub = app.add_subcommand("problems", "StoneBench: write the problems and their stones");
  sub->add_option("--out", options->out, "Folder for problems.json and the catalogue stones/")->required();
  sub->add_option("--count", options->count, "Problems")->check(CLI::Range(1, 10000))->capture_default_str();
  sub->add_option("--stones", options->pool, "Limestones that they draw from")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_option("--seed", options->seed)->check(CLI::Range(0, 2147483647))->capture_default_str();
  sub->footer(
      "Examples:\n"
      "  stonestack-bench problems --out stonebench\n"
      "  stonestack-bench solve stonebench --out answers\n"
      "  stonestack-bench score stonebench answers\n"
      "docs/stonebench.md says how to enter with another planner.");
  measure_by(*sub, [options](Results& results) { write_problems(*options, results); });
}

void add_solve(CLI::App& app) {
  auto options = std::make_shared<SolveOptions>();
  CLI::App* sub = app.add_subcommand("solve", "StoneBench: answer the problems with this library");
  sub->add_option("FOLDER", options->folder, "Folder of the problems")->required();
  sub->add_option("--out", options->out, "Folder for the answers")->required();
  sub->add_option("--method", options->method, "default, or paper, which knows neither walls nor bridges")
      ->check(CLI::IsMember({"default", "paper"}))
      ->capture_default_str();
  sub->footer("Example:\n  stonestack-bench solve stonebench --out answers");
  measure_by(*sub, [options](Results& results) { solve_all(*options, results); });
}

void add_score(CLI::App& app) {
  auto options = std::make_shared<ScoreOptions>();
  CLI::App* sub = app.add_subcommand("score", "StoneBench: judge the answers of any planner in both engines");
  sub->add_option("FOLDER", options->folder, "Folder of the problems")->required();
  sub->add_option("ANSWERS", options->answers, "Folder of the answers, NAME.json each")->required();
  sub->footer("Example:\n  stonestack-bench score stonebench answers --json");
  measure_by(*sub, [options](Results& results) { score_all(*options, results); });
}

}  // namespace stonestack::bench
