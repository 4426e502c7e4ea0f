#include "physics/linear_programme.hpp"

#include <glpk.h>

#include <csetjmp>

namespace stonestack::physics {
namespace {

constexpr int kMaxIterations = 20000;  // a programme here takes a few hundred

extern "C" int discard(void*, const char*) {
  return 1;
}

/// GLPK's environment of this thread: memory of all its objects, freed when the thread ends.
class Environment {
 public:
  Environment() { open(); }
  ~Environment() { glp_free_env(); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;
  /// After an error in GLPK its environment may only be freed, with every object in it.
  void renew() {
    glp_free_env();
    open();
    ++count_;
  }
  [[nodiscard]] long count() const { return count_; }

 private:
  long count_ = 1;
  static void open() {
    glp_init_env();
    glp_term_hook(discard, nullptr);  // stdout is data
  }
};

Environment& environment() {
  thread_local Environment own;
  return own;
}

extern "C" void leave_glpk(void* escape) {
  std::longjmp(*static_cast<std::jmp_buf*>(escape), 1);
}

using Work = void (*)(const void*);
/// Runs `work`; false if GLPK reported an error. Nothing in `work` may need a destructor: longjmp skips it.
bool survives(Work work, const void* argument) {
  std::jmp_buf escape;
  if (setjmp(escape) != 0) return false;
  glp_error_hook(leave_glpk, &escape);
  work(argument);
  glp_error_hook(nullptr, nullptr);
  return true;
}

void write_column(glp_prob* problem, int column, std::span<const LinearProgramme::Entry> entries,
                  std::vector<int>* rows, std::vector<double>* values) {
  rows->assign(1, 0);  // GLPK counts from 1
  values->assign(1, 0.0);
  for (const auto& entry : entries) {
    rows->push_back(entry.row + 1);
    values->push_back(entry.value);
  }
  glp_set_mat_col(problem, column + 1, static_cast<int>(entries.size()), rows->data(), values->data());
}

/// Simplex from the present basis. @return true if it ended properly, whatever it found.
bool run_simplex(glp_prob* problem, double tolerance) {
  glp_smcp settings;
  glp_init_smcp(&settings);
  settings.msg_lev = GLP_MSG_OFF;
  settings.meth = GLP_PRIMAL;
  settings.tol_bnd = tolerance;
  settings.it_lim = kMaxIterations;
  return glp_simplex(problem, &settings) == 0;
}

}  // namespace

/// `call` must be trivially destructible as far as it owns; vectors are made outside of it.
template <typename Call>
void LinearProgramme::guarded(const Call& call) {
  if (broken()) return;
  const auto work = [](const void* argument) { (*static_cast<const Call*>(argument))(); };
  if (!survives(work, &call)) environment().renew();
}

LinearProgramme::LinearProgramme(std::span<const double> right_hand_side)
    : environment_(environment().count()) {
  guarded([&] {
    problem_ = glp_create_prob();
    glp_set_obj_dir(problem_, GLP_MAX);
    if (!right_hand_side.empty()) glp_add_rows(problem_, static_cast<int>(right_hand_side.size()));
    for (std::size_t i = 0; i < right_hand_side.size(); ++i)
      glp_set_row_bnds(problem_, static_cast<int>(i) + 1, GLP_FX, right_hand_side[i], right_hand_side[i]);
  });
}

LinearProgramme::~LinearProgramme() {
  guarded([this] { glp_delete_prob(problem_); });
}

bool LinearProgramme::broken() const {
  return environment_ != environment().count();
}

int LinearProgramme::add_column(std::span<const Entry> entries) {
  int column = -1;
  guarded([&] {
    column = glp_add_cols(problem_, 1) - 1;
    glp_set_col_bnds(problem_, column + 1, GLP_LO, 0.0, 0.0);
  });
  set_column(column, entries);
  return column;
}

void LinearProgramme::set_column(int column, std::span<const Entry> entries) {
  std::vector<int> rows;
  std::vector<double> values;
  guarded([&] { write_column(problem_, column, entries, &rows, &values); });
}

void LinearProgramme::set_upper(int column, double upper) {
  guarded([&] { glp_set_col_bnds(problem_, column + 1, upper > 0.0 ? GLP_DB : GLP_FX, 0.0, upper); });
}

void LinearProgramme::set_gain(int column, double gain) {
  guarded([&] { glp_set_obj_coef(problem_, column + 1, gain); });
}

LinearProgramme::Basis LinearProgramme::basis() const {
  Basis out;
  if (broken()) return out;
  for (int i = 1; i <= glp_get_num_rows(problem_); ++i) out.rows.push_back(glp_get_row_stat(problem_, i));
  for (int j = 1; j <= glp_get_num_cols(problem_); ++j) out.columns.push_back(glp_get_col_stat(problem_, j));
  return out;
}

void LinearProgramme::set_basis(const Basis& basis) {
  guarded([&] {
    for (std::size_t i = 0; i < basis.rows.size(); ++i)
      glp_set_row_stat(problem_, static_cast<int>(i) + 1, basis.rows[i]);
    for (std::size_t j = 0; j < basis.columns.size(); ++j)
      glp_set_col_stat(problem_, static_cast<int>(j) + 1, basis.columns[j]);
  });
}

bool LinearProgramme::solve(double tolerance) {
  bool optimal = false;
  guarded([&] {
    if (!run_simplex(problem_, tolerance)) {
      glp_std_basis(problem_);
      if (!run_simplex(problem_, tolerance)) return;
    }
    optimal = glp_get_status(problem_) == GLP_OPT;
  });
  return optimal && !broken();
}

double LinearProgramme::value(int column) const {
  return broken() ? 0.0 : glp_get_col_prim(problem_, column + 1);
}

double LinearProgramme::multiplier(int row) const {
  return broken() ? 0.0 : glp_get_row_dual(problem_, row + 1);
}

}  // namespace stonestack::physics
