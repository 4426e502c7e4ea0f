#pragma once
#include "search/wall/placing.hpp"
#include "search/wall/span_state.hpp"

namespace stonestack::search {

/// Shapes of the supports of a task, and where they stand in its frame.
struct TaskSupports {
  ShapeList shapes;
  std::vector<Pose> T_V_O;
};
[[nodiscard]] TaskSupports make_supports(const SpanTask& task);

/// Plans how stones do a task, stone after stone: a beam search. Each stone reaches further out than what
/// stands, closes a span, weighs down what reaches out, or begins or raises a pier.
class SpanSearch {
 public:
  /// @param start the supports of the task, then what stands already
  SpanSearch(const SearchContext& context, const SpanTask& task, WallState start, Placing& placing);

  /// Puts the stones of an earlier plan first, as far as they hold.
  /// @param rest_only nothing is searched for
  void run(const std::vector<WallPlacement>& rest, bool rest_only);
  /// As far as it came.
  [[nodiscard]] const WallState& best() const { return best_.state; }
  [[nodiscard]] bool done() const { return done_; }
  [[nodiscard]] long candidates() const { return candidates_; }

 private:
  /// A structure of the beam.
  struct Node {
    WallState state;
    double value = 0.0;
    const Node* parent = nullptr;  ///< that it went on from, while the beam after it is chosen
  };
  /// A stone that was let down on a node.
  struct Child {
    const Node* parent = nullptr;
    Settled next;
    double value = 0.0;
  };
  /// A part of the structure, and the worth of stones there.
  struct Place;

  [[nodiscard]] std::vector<Place> places(const WallState& state) const;
  [[nodiscard]] std::vector<Child> children(const Node& node);
  /// Other stones that were let down on the same structure.
  [[nodiscard]] static std::vector<Alternative> compared_with(const std::vector<Child>& children,
                                                              std::size_t chosen);
  [[nodiscard]] std::vector<Node> next_beam(std::vector<Child> children, std::size_t width);
  /// A beam search with beams of `width` structures, from the start.
  void search(std::size_t width);
  [[nodiscard]] double value_of(const WallState& state) const;
  [[nodiscard]] double load_borne(const StackStatics& statics, const SpanEnd& end) const;
  [[nodiscard]] bool is_support(int stone) const;
  void keep(const Node& node);

  const SearchContext& context_;
  const SpanTask& task_;
  Placing& placing_;
  std::vector<WallStone> stones_;
  WallState start_;
  double length_ = 0.1, mass_ = 1.0;  // of a usual stone, m and kg
  Node best_;
  bool done_ = false;
  long candidates_ = 0;
};

}  // namespace stonestack::search
