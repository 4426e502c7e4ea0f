#include "kinematics/xml_guard.hpp"

#include "stonestack/core/error.hpp"

namespace stonestack::kinematics {
namespace {

constexpr int kDeepest = 64;
constexpr int kMaxTags = 20000;

[[noreturn]] void refuse(const std::string& path, const std::string& problem) {
  throw FileError(path, problem, "give a well-formed URDF");
}

/// Index just past `end`, which must follow `from`.
std::size_t past(const std::string& text, const std::string& end, std::size_t from, const std::string& path) {
  const std::size_t at = text.find(end, from);
  if (at == std::string::npos) refuse(path, concat("has no '", end, "' after byte ", from));
  return at + end.size();
}

/// Index of the '>' that ends the tag at `from`. A '<' inside a tag is never right, not even quoted: refusing
/// it here means that the real parser cannot see a structure other than the one counted.
std::size_t tag_end(const std::string& text, std::size_t from, const std::string& path) {
  char quote = 0;
  for (std::size_t i = from + 1; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '<') refuse(path, concat("has a '<' inside a tag at byte ", i));
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      return i;
    }
  }
  refuse(path, concat("has a tag without end at byte ", from));
}

}  // namespace

void guard_xml(const std::string& text, const std::string& path) {
  if (text.find('\0') != std::string::npos) refuse(path, "has a zero byte, so it is not XML");
  int depth = 0;
  int tags = 0;
  std::size_t at = text.find('<');
  if (at == std::string::npos) refuse(path, "has no XML tag");
  for (; at != std::string::npos; at = text.find('<', at)) {
    if (++tags > kMaxTags) refuse(path, concat("has more than ", kMaxTags, " XML tags"));
    if (text.compare(at, 4, "<!--") == 0) {
      at = past(text, "-->", at + 4, path);
    } else if (text.compare(at, 2, "<?") == 0) {
      at = past(text, "?>", at, path);
    } else if (text.compare(at, 2, "<!") == 0) {
      refuse(path, concat("has a document type or CDATA section at byte ", at));
    } else {
      const std::size_t end = tag_end(text, at, path);
      const bool closes = text.compare(at, 2, "</") == 0;
      const bool empty = text[end - 1] == '/';
      depth += closes ? -1 : (empty ? 0 : 1);
      if (depth > kDeepest) refuse(path, concat("nests XML tags deeper than ", kDeepest));
      if (depth < 0) refuse(path, concat("closes a tag that is not open at byte ", at));
      at = end + 1;
    }
  }
  if (depth != 0) refuse(path, concat("leaves ", depth, " XML tags open"));
}

}  // namespace stonestack::kinematics
