#pragma once
#include <string>

#include "stonestack/core/rooms.hpp"

/// Private to kinematics: what must hold before a DOM parser sees a file.
namespace stonestack::kinematics {

/// Refuses XML that nests deeper than 64, has more than 20,000 tags, a document type, CDATA, or is not
/// balanced. TinyXML takes quadratic time in the depth, so that 60 KB could keep it busy for minutes.
/// Throws FileError with `path`.
void guard_xml(const std::string& text, const std::string& path);

}  // namespace stonestack::kinematics
