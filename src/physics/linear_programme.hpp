#pragma once
#include <span>
#include <vector>

struct glp_prob;

namespace stonestack::physics {

/// Linear programme with equality rows, maximise g'x subject to A x = b and 0 <= x <= upper, solved by the
/// primal simplex method (GLPK). Errors inside GLPK, which aborts the process by default, become a solve that
/// fails. GLPK keeps one environment for each thread: use a programme on the thread that made it.
class LinearProgramme {
 public:
  /// Rows of A with their right-hand side; no columns yet.
  explicit LinearProgramme(std::span<const double> right_hand_side);
  ~LinearProgramme();
  LinearProgramme(const LinearProgramme&) = delete;
  LinearProgramme& operator=(const LinearProgramme&) = delete;

  /// Nonzero coefficient of a column.
  struct Entry {
    int row = 0;
    double value = 0.0;
  };
  /// Appends a column with 0 <= x; each row at most once. @return its index.
  int add_column(std::span<const Entry> entries);
  /// Replaces the coefficients of a column.
  void set_column(int column, std::span<const Entry> entries);
  /// 0 <= x <= upper.
  void set_upper(int column, double upper);
  /// Coefficient of the objective, which is maximised.
  void set_gain(int column, double gain);

  /// How a basic solution divides rows and columns, to start from again.
  struct Basis {
    std::vector<int> rows, columns;
  };
  [[nodiscard]] Basis basis() const;
  void set_basis(const Basis& basis);

  /// Solves from the present basis; where that fails numerically, once more from the slack basis.
  /// @return true if an optimal solution within `tolerance` of the bounds was found. False if there is none,
  /// or if the solver failed.
  [[nodiscard]] bool solve(double tolerance);
  /// Value of a column in the solution.
  [[nodiscard]] double value(int column) const;
  /// Multiplier of a row in the solution: gain of the objective for each unit of its right-hand side.
  [[nodiscard]] double multiplier(int row) const;
  /// Did GLPK report an error of its own? The programme is unusable then, and `solve` returns false.
  [[nodiscard]] bool broken() const;

 private:
  glp_prob* problem_ = nullptr;
  long environment_ = 0;  ///< in which `problem_` was allocated

  template <typename Call>
  void guarded(const Call& call);
};

}  // namespace stonestack::physics
