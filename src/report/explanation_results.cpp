#include <algorithm>

#include "report/depth_picture.hpp"
#include "report/text.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::report {
namespace {

/// Colour of a pixel by what it says of the model; the legend stands in `explanation_text`.
Eigen::Vector3d colour_of(PixelEvidence evidence) {
  switch (evidence) {
    case PixelEvidence::kFits:
      return {0.20, 0.75, 0.25};
    case PixelEvidence::kSeenThrough:
      return {0.20, 0.40, 0.95};
    case PixelEvidence::kInFront:
      return {0.95, 0.55, 0.10};
    case PixelEvidence::kHidden:
      return {0.65, 0.35, 0.75};
    case PixelEvidence::kNoDepth:
      return {0.90, 0.85, 0.20};
    case PixelEvidence::kNone:
      break;
  }
  return Eigen::Vector3d::Zero();
}

}  // namespace

std::string explanation_text(const std::vector<Explanation>& explanations, const Catalogue& catalogue) {
  std::string text;
  for (const Explanation& e : explanations)
    text += concat(name_of(catalogue, e.stone), ": ", e.stage, ": ", e.text, "\n");
  const bool drawn = std::any_of(explanations.begin(), explanations.end(),
                                 [](const Explanation& e) { return !e.evidence.empty(); });
  if (drawn)
    text +=
        "in the pictures: green fits, blue is seen through, orange lies in front, violet is hidden, "
        "yellow has no depth\n";
  return text;
}

void draw_explanation(const std::string& path, const DepthImage& image, const Explanation& explanation) {
  Picture picture;
  picture.width = image.camera.width, picture.height = image.camera.height;
  picture.rgb.assign(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) * 3,
                     0);
  const std::vector<double> brightness = brightness_of(image);
  for (int v = 0; v < picture.height; ++v)
    for (int u = 0; u < picture.width; ++u) {
      const auto i = static_cast<std::size_t>(v * picture.width + u);
      const PixelEvidence evidence =
          i < explanation.evidence.size() ? explanation.evidence[i] : PixelEvidence::kNone;
      set_pixel(picture, u, v,
                evidence == PixelEvidence::kNone
                    ? Eigen::Vector3d(Eigen::Vector3d::Constant(0.6 * brightness[i]))
                    : Eigen::Vector3d((0.4 + brightness[i]) * colour_of(evidence)));
    }
  write_png(path, picture);
}

}  // namespace stonestack::report
