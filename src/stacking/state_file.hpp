#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "stacking/choose_action.hpp"

namespace stonestack::stacking {

/// All that a decision depends on.
struct State {
  std::string catalogue;  ///< path; empty: the stones that come with stonestack
  std::string robot;      ///< name or path
  WorldEstimate world;
  RunMemory memory;
  BuildOptions options;
};

/// Writes "stonestack.state/1" (JSON, named keys; stones by name, options that are not the default): what
/// `stonestack decide` reads. Not in it: views.
/// @throws FileError
void write_state(const std::string& path, const WorldEstimate& world, const RunMemory& memory,
                 const Models& models, const BuildOptions& options);

/// The content of such a file, for one that holds more.
[[nodiscard]] nlohmann::json state_json(const WorldEstimate& world, const RunMemory& memory,
                                        const Models& models, const BuildOptions& options);
/// A state by its content. @throws nlohmann::json::exception and InvalidArgument
[[nodiscard]] State state_of(const nlohmann::json& content, const Catalogue& catalogue);
/// Values of `list` that differ from those of `usual`, exactly; both list the same fields.
[[nodiscard]] nlohmann::json changed_fields_json(const FieldList& list, const FieldList& usual);
/// A layout as a state holds it.
[[nodiscard]] nlohmann::json layout_json(const CellLayout& layout);

/// Files that a state needs.
struct StateHeader {
  std::string catalogue;  ///< path; empty: the stones that come with stonestack
  std::string robot;      ///< name or path
};
/// @throws FileError when it cannot be read or is no state.
[[nodiscard]] StateHeader read_state_header(const std::string& path);
/// The state, with stones of that catalogue. @throws FileError that names what is missing or unknown.
[[nodiscard]] State read_state(const std::string& path, const Catalogue& catalogue);
/// A decision as "stonestack.decision/1": action, alternatives, why.
[[nodiscard]] std::string decision_json(const Decision& decision, const Catalogue& catalogue);
/// A decision for a person: the action with its alternatives, a line each, then why.
[[nodiscard]] std::string decision_text(const Decision& decision, const Catalogue& catalogue);

}  // namespace stonestack::stacking
