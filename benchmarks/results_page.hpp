#pragma once
#include <string>

#include "rooms.hpp"

namespace stonestack::bench {

/// Writes the page of results (docs/results.md) from its records, the files `*.json` of `folder` in the order
/// of their names. Schema stonestack.results/1, one file a section:
///
///     {"schema": "stonestack.results/1", "section": TITLE, "note": TEXT,
///      "rows": [{"what": TEXT, "figure": "{NAME}, {NAME}", "values": {NAME: VALUE}, "command": TEXT, "seed": NUMBER,
///                "version": TEXT}]}
///
/// A VALUE is {"value": NUMBER, "of": NUMBER, "min": NUMBER, "max": NUMBER, "decimals": NUMBER, "unit":
/// TEXT}. Only "value" is required; it and "of" may also be {"record": FILE, "at": POINTER}, a JSON pointer
/// into what a benchmark wrote with --record (FILE is relative to `folder`). The marks "min" and "max" limit
/// the value, or "min" its share of "of". A figure outside its marks is printed bold.
/// @return Markdown.
/// @throws FileError if there is no record, or if one is not as described.
[[nodiscard]] std::string results_page(const std::string& folder);

}  // namespace stonestack::bench
