#pragma once
#include <compare>
#include <concepts>
#include <cstddef>
#include <functional>
#include <iosfwd>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "stonestack/geometry/mesh.hpp"

#pragma GCC visibility push(default)

namespace stonestack::stone {

/// Index of a stone in a list that has the order of a catalogue: its stones, their contact shapes, their
/// models. A type of its own, because levels of a stack, bodies of a world, objects of a planning scene and
/// counts are plain integers, and the compiler is to refuse one in the place of the other. So integers are
/// converted explicitly only, in both directions. A conversion to std::size_t that is not explicit would
/// allow `list[stone]`, but also pass a stone as a count: `at(list, stone)` and `catalogue[stone]` do the
/// first without the second.
class StoneIndex {
 public:
  /// No stone: equal to kNoStone.
  constexpr StoneIndex() = default;
  /// Stone number `value` of the list, from 0.
  template <std::integral Integer>
  requires(!std::same_as<Integer, bool>) explicit constexpr StoneIndex(Integer value)
      : value_(static_cast<int>(value)) {}

  /// Number of the stone in the list, from 0; -1 for kNoStone.
  [[nodiscard]] constexpr int value() const { return value_; }
  /// True for a stone of a list of `count` stones.
  [[nodiscard]] constexpr bool is_within(std::size_t count) const {
    return value_ >= 0 && static_cast<std::size_t>(value_) < count;
  }

  /// True for the same number.
  friend constexpr bool operator==(StoneIndex, StoneIndex) = default;
  /// Order of the numbers; kNoStone comes first.
  friend constexpr auto operator<=>(StoneIndex, StoneIndex) = default;

  /// Writes the number.
  template <class Traits>
  friend std::basic_ostream<char, Traits>& operator<<(std::basic_ostream<char, Traits>& out,
                                                      StoneIndex stone) {
    return out << stone.value_;
  }
  /// Makes the number of a nlohmann::json, which finds this by name.
  template <class Json>
  friend void to_json(Json& json, StoneIndex stone) {
    json = stone.value_;
  }
  /// Reads the number of a nlohmann::json.
  template <class Json>
  friend void from_json(const Json& json, StoneIndex& stone) {
    stone.value_ = json.template get<int>();
  }

 private:
  int value_ = -1;
};

/// Index where there is no stone.
inline constexpr StoneIndex kNoStone{};

/// Index as a literal: `2_stone` is StoneIndex(2).
[[nodiscard]] consteval StoneIndex operator""_stone(unsigned long long value) {
  return StoneIndex(value);
}

/// Ends what asks a list of `count` stones for one that it has not.
/// @throws InvalidArgument with both numbers.
[[noreturn]] void throw_no_such_stone(StoneIndex stone, std::size_t count);

/// Element of a stone in a list that has the order of the catalogue.
/// @throws InvalidArgument for a stone that the list has not.
template <class List>
[[nodiscard]] constexpr decltype(auto) at(List& list, StoneIndex stone) {
  if (!stone.is_within(std::size(list))) throw_no_such_stone(stone, std::size(list));
  return list[static_cast<std::size_t>(stone.value())];
}

/// Indices of the first `count` stones, in order: of all stones with the size of a list.
[[nodiscard]] std::vector<StoneIndex> first_stones(std::size_t count);

/// How far one surface lies from another, metres.
struct Deviation {
  double median = 0.0;  ///< median distance [m]
  double worst = 0.0;   ///< largest distance [m]
};

/// How well the surface of a stone is known that was modelled from views.
struct SurfaceKnowledge {
  std::vector<double>
      sigma;  ///< a vertex of the scan each: standard deviation of its distance from the surface [m]
  std::vector<char> seen;  ///< a vertex each: 1 where a view showed it, 0 where it was completed
  /// Unit vectors in O that pointed up while the stone lay at rest on the table
  std::vector<Eigen::Vector3d> up_O_at_rest;
};

/// Model of a stone: its scan, measured once. Frame O: origin at the centre of mass
/// of the uniform scan, axes of the scanned file unless asked otherwise.
struct Stone {
  std::string name;                         ///< name of the stone and of its folder
  Mesh mesh;                                ///< at most 500 faces: detection, rough search (paper §4.1)
  Mesh scan;                                ///< full resolution: contact, verdict, the true world
  std::vector<Mesh> pieces;                 ///< convex pieces: motion's collision checks
  MassProperties mass;                      ///< in O
  double friction = 0.1;                    ///< stone on stone, what the planner assumes (paper §4.1)
  double density = 2600.0;                  ///< [kg/m^3]
  Pose T_O_file = Pose::Identity();         ///< where the scanned file's frame, scaled to metres, lies in O
  double scale = 1.0;                       ///< metres per unit of the scanned file
  std::string source;                       ///< file or generator with seed
  Deviation mesh_deviation;                 ///< of the reduced mesh from the scan, in both directions
  Deviation contact_deviation;              ///< of the surface that physics collides with from the scan
  std::optional<SurfaceKnowledge> surface;  ///< empty: the scan shows all of it as well as it is
};

/// A stone somewhere, by index into whatever list of stones the owner holds.
struct PlacedStone {
  StoneIndex stone = kNoStone;    ///< index into the owner's list
  Pose T_W_O = Pose::Identity();  ///< pose of the stone
};

}  // namespace stonestack::stone

/// Hash of the number, for unordered containers.
template <>
struct std::hash<stonestack::stone::StoneIndex> {
  /// Hash of the number.
  std::size_t operator()(stonestack::stone::StoneIndex stone) const noexcept {
    return std::hash<int>{}(stone.value());
  }
};

#pragma GCC visibility pop
