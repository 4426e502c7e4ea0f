#pragma once

namespace stonestack::modelling {

/// Why `model_object` is empty, for a person.
inline constexpr const char* kNoModel =
    "what was seen of it makes no model: it is too large for cells of this size, or views see through all of "
    "it";

}  // namespace stonestack::modelling
