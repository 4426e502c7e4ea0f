#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "protocol/ur_version.hpp"

/// Fields of RTDE: the types and every documented field. Sources: UR's RTDE guide and the tables of
/// its client library.
namespace stonestack::protocol {

/// In the order of the alternatives of RtdeValue.
enum class RtdeType {
  kBool,
  kUint8,
  kUint32,
  kUint64,
  kInt32,
  kDouble,
  kVector3d,
  kVector6d,
  kVector6Int32,
  kVector6Uint32
};

/// One value; `index()` is its RtdeType.
using RtdeValue = std::variant<bool, std::uint8_t, std::uint32_t, std::uint64_t, std::int32_t, double,
                               std::array<double, 3>, std::array<double, 6>, std::array<std::int32_t, 6>,
                               std::array<std::uint32_t, 6>>;

/// "VECTOR6D", as the wire names it.
[[nodiscard]] std::string_view rtde_type_name(RtdeType type);
/// Empty for anything else, NOT_FOUND and IN_USE among it.
[[nodiscard]] std::optional<RtdeType> rtde_type(std::string_view name);
/// Bytes on the wire; nothing is padded.
[[nodiscard]] std::size_t rtde_size(RtdeType type);
/// Zero of a type.
[[nodiscard]] RtdeValue rtde_zero(RtdeType type);

/// A documented field. Where a first version is known it is given; the zero version means "in every version
/// we know of".
struct RtdeField {
  std::string name;
  RtdeType type;
  UrVersion cb3;       ///< first PolyScope 3 that has it
  UrVersion e_series;  ///< first PolyScope 5 that has it
  [[nodiscard]] bool in(const UrVersion& version) const {
    return version >= (version.is_cb3() ? cb3 : e_series);
  }
};

/// Everything a controller can send; input registers can be read back, so they are here too.
[[nodiscard]] const std::vector<RtdeField>& rtde_outputs();
/// Everything a client may write.
[[nodiscard]] const std::vector<RtdeField>& rtde_inputs();
/// The field of that name, or null.
[[nodiscard]] const RtdeField* find_rtde_output(std::string_view name);
[[nodiscard]] const RtdeField* find_rtde_input(std::string_view name);

}  // namespace stonestack::protocol
