#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/json_file.hpp"
#include "report/depth_picture.hpp"
#include "report/text.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

constexpr double kSureObject = 0.8;  // confidence from which on no warning is given

json coordinates_json(const Eigen::Vector3d& p) {
  return json{{"x", p.x()}, {"y", p.y()}, {"z", p.z()}};
}

/// Digits, 3 x 5 pixels, rows from the top, the left column in the highest bit.
constexpr std::array<std::array<int, 5>, 10> kDigits{{{7, 5, 5, 5, 7},
                                                      {2, 6, 2, 2, 7},
                                                      {7, 1, 7, 4, 7},
                                                      {7, 1, 7, 1, 7},
                                                      {5, 5, 7, 1, 1},
                                                      {7, 4, 7, 1, 7},
                                                      {7, 4, 7, 5, 7},
                                                      {7, 1, 1, 1, 1},
                                                      {7, 5, 7, 5, 7},
                                                      {7, 5, 7, 1, 7}}};
constexpr int kDigitScale = 3;  // px of the picture a pixel of a digit

/// Colours that differ much from one number to the next: hues a golden angle apart.
Eigen::Vector3d colour_of(int object) {
  const double hue = 6.0 * std::fmod(0.61803398875 * object, 1.0);
  const auto part = [hue](double shift) {
    const double h = std::fmod(hue + shift, 6.0);
    return std::clamp(std::abs(h - 3.0) - 1.0, 0.0, 1.0);
  };
  return Eigen::Vector3d(0.25, 0.25, 0.25) + 0.75 * Eigen::Vector3d(part(0.0), part(4.0), part(2.0));
}

/// White digits on black, the middle at (x, y).
void write_number(Picture& picture, int x, int y, int number) {
  const std::string digits = std::to_string(number);
  const int width = static_cast<int>(digits.size()) * 4 + 1, height = 7;
  const int x0 = x - width * kDigitScale / 2, y0 = y - height * kDigitScale / 2;
  for (int v = 0; v < height * kDigitScale; ++v)
    for (int u = 0; u < width * kDigitScale; ++u) {
      const int row = v / kDigitScale - 1, column = u / kDigitScale - 1;
      bool ink = false;
      if (row >= 0 && row < 5 && column >= 0 && column % 4 < 3) {
        const auto& digit =
            kDigits[static_cast<std::size_t>(digits[static_cast<std::size_t>(column / 4)] - '0')];
        ink = (digit[static_cast<std::size_t>(row)] >> (2 - column % 4) & 1) != 0;
      }
      set_pixel(picture, x0 + u, y0 + v, Eigen::Vector3d::Constant(ink ? 1.0 : 0.0));
    }
}

/// Pixel of the object that is nearest to the middle of its pixels; empty without any.
std::optional<std::array<int, 2>> middle_of(const std::vector<int>& labels, int width, int object) {
  double su = 0, sv = 0;
  int count = 0;
  const int size = static_cast<int>(labels.size());
  for (int i = 0; i < size; ++i)
    if (labels[static_cast<std::size_t>(i)] == object) su += i % width, sv += i / width, ++count;
  if (count == 0) return std::nullopt;
  std::array<int, 2> best{};
  double nearest = 1e18;
  for (int i = 0; i < size; ++i) {
    if (labels[static_cast<std::size_t>(i)] != object) continue;
    const double d = std::hypot(i % width - su / count, i / width - sv / count);
    if (d < nearest) nearest = d, best = {i % width, i / width};
  }
  return best;
}

/// Draws a view from column `left` on.
void draw_view(Picture& picture, int left, const DepthImage& image, const std::vector<int>& labels,
               int objects) {
  const int width = image.camera.width;
  const std::vector<double> brightness = brightness_of(image);
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < width; ++u) {
      const auto i = static_cast<std::size_t>(v * width + u);
      const double grey = brightness[i];
      if (!(grey > 0)) continue;
      Eigen::Vector3d colour = Eigen::Vector3d::Constant(0.6 * grey);
      if (labels[i] > 0) {
        const bool rim =
            (u + 1 < width && labels[i + 1] != labels[i]) ||
            (v + 1 < image.camera.height && labels[i + static_cast<std::size_t>(width)] != labels[i]);
        colour = rim ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                     : Eigen::Vector3d((0.4 + grey) * colour_of(labels[i]));
      }
      set_pixel(picture, left + u, v, colour);
    }
  for (int k = 1; k <= objects; ++k)
    if (const auto middle = middle_of(labels, width, k))
      write_number(picture, left + (*middle)[0], (*middle)[1], k);
}

}  // namespace

std::string segmentation_json(const Segmentation& result, const std::optional<Pose>& T_W_C) {
  json list = json::array();
  for (const SegmentedObject& object : result.objects) {
    json entry = {{"object", list.size() + 1},
                  {"confidence", object.confidence},
                  {"p_C_middle", coordinates_json(object.p_C_middle)},
                  {"length_m", object.size.x()},
                  {"width_m", object.size.y()},
                  {"height_m", object.size.z()},
                  {"pixels", object.pixels},
                  {"views", object.views},
                  {"cut_off", object.cut_off}};
    if (T_W_C) entry["p_W_middle"] = coordinates_json(*T_W_C * object.p_C_middle);
    list.push_back(std::move(entry));
  }
  json out = {{"schema", "stonestack.segment/1"}, {"objects", list}, {"note", result.note}};
  if (result.table_C)
    out["table_C"] = {{"normal", coordinates_json(result.table_C->normal)},
                      {"offset_m", result.table_C->offset}};
  return document(out);
}

std::string segmentation_table(const Segmentation& result, const SceneView& view) {
  std::string text = format("%6s %10s %7s %9s %8s %9s   middle in the %s frame (m)\n", "object", "confidence",
                            "pixels", "length cm", "width cm", "height cm", view.world ? "world" : "camera");
  for (std::size_t k = 0; k < result.objects.size(); ++k) {
    const SegmentedObject& object = result.objects[k];
    const Eigen::Vector3d p =
        view.world ? Eigen::Vector3d(*view.T_W_C * object.p_C_middle) : object.p_C_middle;
    text += format("%6zu %10.2f %7d %9.1f %8.1f %9.1f   %7.4f %7.4f %7.4f%s\n", k + 1, object.confidence,
                   object.pixels, 100.0 * object.size.x(), 100.0 * object.size.y(), 100.0 * object.size.z(),
                   p.x(), p.y(), p.z(), object.cut_off ? "  cut off by the border of the image" : "");
  }
  return text;
}

std::vector<std::string> segmentation_warnings(const Segmentation& result) {
  std::vector<std::string> warnings;
  for (std::size_t k = 0; k < result.objects.size(); ++k)
    if (const double confidence = result.objects[k].confidence; confidence < kSureObject)
      warnings.push_back(
          format("object %zu has a confidence of %.2f: it may be several, or a part of one; look at "
                 "it from another side, too",
                 k + 1, confidence));
  return warnings;
}

void write_segmentation(const std::string& folder, const Segmentation& result,
                        const std::vector<SceneView>& views) {
  for (std::size_t k = 0; k < result.objects.size(); ++k)
    write_cloud(concat(folder, "/object_", k + 1, ".ply"), result.objects[k].cloud_C);
  for (std::size_t v = 0; v < result.labels.size(); ++v) {
    DepthImage image{views[v].image.camera, {}};  // a count is an object's number
    image.z.assign(result.labels[v].begin(), result.labels[v].end());
    write_depth_png(concat(folder, "/labels_", v + 1, ".png"), image, 1.0);
  }
}

void draw_segmentation(const std::string& path, const Segmentation& result,
                       const std::vector<SceneView>& views) {
  Picture picture;
  for (const SceneView& view : views) {
    picture.width += view.image.camera.width;
    picture.height = std::max(picture.height, view.image.camera.height);
  }
  picture.rgb.assign(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height) * 3,
                     0);
  int left = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const std::vector<int> none(views[v].image.z.size(), 0);
    draw_view(picture, left, views[v].image, v < result.labels.size() ? result.labels[v] : none,
              static_cast<int>(result.objects.size()));
    left += views[v].image.camera.width;
  }
  write_png(path, picture);
}

}  // namespace stonestack::report
