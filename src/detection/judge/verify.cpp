#include "detection/judge/verify.hpp"

#include <algorithm>
#include <cmath>

#include "detection/hypotheses/refine.hpp"
#include "detection/judge/bend.hpp"
#include "detection/judge/contour.hpp"
#include "detection/judge/draw_model.hpp"
#include "detection/scene/seen_normal.hpp"
#include "detection/scene/supports.hpp"

namespace stonestack::detection {
namespace {

constexpr double kJustInFront =
    0.030;  // m: nearer than this in front of the model is a wrong pose, not a hider
constexpr double kJustInFrontWeight = 0.6;
constexpr double kCosineNone = 0.5;        // between normals: agrees not at all ...
constexpr double kCosineFull = 0.85;       // ... and fully: flat faces stand for curved stone
constexpr double kBeyondTolerated = 0.15;  // share: neighbours that touch
constexpr double kBeyondWeight = 1.0;
constexpr double kContourReach = 4.0;      // times the tolerance: so near the model's depth it is seen
constexpr double kGoesOnTolerated = 0.06;  // share of the outline: stones that lie flush
constexpr double kGoesOnWeight = 2.0;
constexpr double kBendTolerated = 0.75;  // of the model's bend: right poses show 0.82 and more of it
constexpr double kBendWeight = 1.0;
constexpr double kLittleBend = 0.05;   // variation of normals of a surface that is nearly flat
constexpr double kWithoutDepth = 0.3;  // of the drawn pixels: shadows, slopes, dark places
constexpr double kWithoutDepthWeight = 0.2;
constexpr double kFullBend = 0.1;  // variation of normals that holds a pose without an outline
constexpr double kHeld = 0.6;      // of what holds a pose: bend, or the outline as a share of it
constexpr double kLooseWeight = 0.5;
constexpr double kMinSeen = 0.10;           // of the drawn pixels must fit
constexpr double kBelowTableScale = 0.010;  // m below the tolerated depth that cost one full score

/// Pixels by the evidence they give.
struct Tally {
  double fits = 0, quality = 0, through = 0, just_in_front = 0, hidden = 0;
  double drawn = 0, area = 0;
  double without_depth = 0;  ///< share of the drawn pixels, in the view that shows most of the model
  BendTally bend;
  ContourTally contour;
};

/// A drawn pixel with an undrawn neighbour: the silhouette of 500 faces is a pixel or two off.
bool at_rim(const DrawnModel& drawn, int x, int y) {
  if (x == 0 || y == 0 || x + 1 == drawn.width || y + 1 == drawn.height) return true;
  const auto at = [&](int dx, int dy) {
    return drawn.z[static_cast<std::size_t>((y + dy) * drawn.width + x + dx)];
  };
  return at(-1, 0) == 0.0F || at(1, 0) == 0.0F || at(0, -1) == 0.0F || at(0, 1) == 0.0F;
}

int drawing_step(const DetectionModel& model, const Pose& T_C_O, const CameraIntrinsics& camera, int pixels) {
  const double z = std::max(0.05, (T_C_O * model.centre).z());
  const double in_view =
      0.25 * model.area * camera.fx * camera.fy / (z * z);  // Cauchy: mean shadow of a convex body
  return std::clamp(static_cast<int>(std::lround(std::sqrt(in_view / pixels))), 1, 16);
}

/// Depth [m] of the model's deepest vertex below what carries things there, as far as the vertex is known;
/// `tolerated` where it is less, or without a table.
double below_support(const DetectionModel& model, const Pose& T_C_O, const DetectionScene& scene,
                     double tolerated) {
  constexpr double kRounding = 1e-6;  // m
  const Eigen::Vector3d centre = T_C_O * model.centre;
  double deepest = tolerated;
  for (const auto& plane : planes_below(scene, centre)) {
    if (model.drawn_radius - plane.distance(centre) + kRounding <= tolerated) continue;
    // In O, where no vertex is transformed; exactly for those that this shows to be the deepest.
    const Eigen::Vector3d n_O = T_C_O.linear().transpose() * plane.normal;
    const double offset_O = plane.offset - plane.normal.dot(T_C_O.translation());
    for (std::size_t v = 0; v < model.drawn.vertices.size(); ++v) {
      const double known = 2.0 * model.sigma.drawn[v];
      if (offset_O - n_O.dot(model.drawn.vertices[v]) - known + kRounding < deepest) continue;
      deepest = std::max(deepest, -plane.distance(T_C_O * model.drawn.vertices[v]) - known);
    }
  }
  return deepest;
}

/// A drawn pixel against what was seen there.
struct ComparedPixel {
  PixelEvidence evidence = PixelEvidence::kNoDepth;
  double off = 0.0;    ///< distance from the model along its normal [m]
  double slope = 0.0;  ///< cosine between the line of sight and the normal
};

ComparedPixel compare_pixel(const DepthImage& depth, int u, int v, double z, const Eigen::Vector3d& normal_C,
                            double tolerance) {
  ComparedPixel out;
  const double seen = depth.at(u, v);
  if (seen <= 0) return out;
  const double dz = seen - z;
  out.slope = -normal_C.dot(deproject(depth.camera, u, v));
  out.off = std::abs(dz) * out.slope;
  if (out.off < tolerance && std::abs(dz) < 4.0 * tolerance)
    out.evidence = PixelEvidence::kFits;
  else if (dz > 0)
    out.evidence = PixelEvidence::kSeenThrough;
  else
    out.evidence = dz > -kJustInFront ? PixelEvidence::kInFront : PixelEvidence::kHidden;
  return out;
}

/// Adds one drawn pixel with a depth to the tally; true if it fits.
/// @param sigma of the model's surface there [m]
bool count_pixel(const DepthImage& depth, int u, int v, double z, const Eigen::Vector3d& normal_C,
                 double sigma, const VerifyOptions& options, Tally& tally) {
  const double tolerance = widened(options.tolerance, sigma);
  const double weight = evidence_weight(options.tolerance, sigma);
  const ComparedPixel pixel = compare_pixel(depth, u, v, z, normal_C, tolerance);
  if (pixel.evidence == PixelEvidence::kSeenThrough) tally.through += weight;
  if (pixel.evidence == PixelEvidence::kInFront) tally.just_in_front += weight;
  if (pixel.evidence == PixelEvidence::kHidden) tally.hidden += weight;
  if (pixel.evidence != PixelEvidence::kFits) return false;
  const double ratio = pixel.off / tolerance;
  const Eigen::Vector3d seen = seen_normal(depth, u, v);
  const double agree =
      seen.isZero() ? 1.0
                    : std::clamp((seen.dot(normal_C) - kCosineNone) / (kCosineFull - kCosineNone), 0.0, 1.0);
  if (!seen.isZero()) tally.bend.add(normal_C, seen, weight);
  tally.fits += weight;
  tally.quality += weight * (1.0 - ratio * ratio) *
                   (agree + (1.0 - weight) * (1.0 - agree));  // a guess has a guessed normal
  tally.area += weight * z * z / (depth.camera.fx * depth.camera.fy * std::max(pixel.slope, 0.1));
  return true;
}

/// Of the seen points at or just off the model's surface, the share that is off.
double share_beyond(const DetectionModel& model, const Pose& T_C_O, const SurfacePoints& seen,
                    std::span<const int> around, const VerifyOptions& options) {
  const Eigen::Isometry3f T = T_C_O.inverse().cast<float>();
  const auto centre = model.centre.cast<float>().eval();
  const auto far = static_cast<float>(kBesideModel);
  const auto reach = static_cast<float>(model.radius + kBesideModel);
  double at = 0, off = 0;
  for (const int i : around) {
    const Eigen::Vector3f q = T * seen.points[static_cast<std::size_t>(i)];
    if ((q - centre).squaredNorm() > reach * reach) continue;
    const int k = model.field.nearest(q);
    if (k < 0) continue;
    const ModelSample& nearest = model.samples[static_cast<std::size_t>(k)];
    const float d = (q - nearest.p).norm();
    if (!(d < far)) continue;
    const double sigma = nearest.sigma;
    const auto near = static_cast<float>(1.5 * widened(options.tolerance, sigma));
    (d < near ? at : off) += evidence_weight(options.tolerance, sigma);
  }
  return at + off > 0 ? off / (at + off) : 0.0;
}

/// Compares one view with the model drawn into it.
void tally_view(const DetectionModel& model, const Pose& T_V_O, const SeenView& view, int index,
                const VerifyOptions& options, Tally& tally, Verdict& verdict) {
  const CameraIntrinsics& camera = view.depth.camera;
  const int step = drawing_step(model, T_V_O, camera, options.drawn_pixels);
  const DrawnModel drawn = draw_model(model.drawn, model.drawn_normals, T_V_O, camera, step);
  const double area_before = tally.area, drawn_before = tally.drawn;
  double without_depth = 0;
  for (int y = 0; y < drawn.height; ++y)
    for (int x = 0; x < drawn.width; ++x) {
      const auto i = static_cast<std::size_t>(y * drawn.width + x);
      if (drawn.z[i] == 0.0F || at_rim(drawn, x, y)) continue;
      const int u = drawn.u0 + x * step, v = drawn.v0 + y * step;
      const auto pixel = static_cast<std::size_t>(v * camera.width + u);
      if (!view.explained.empty() && view.explained[pixel] != 0) continue;
      const double sigma =
          sigma_of_face(model.sigma.drawn, model.drawn.faces[static_cast<std::size_t>(drawn.face[i])]);
      const double weight = evidence_weight(options.tolerance, sigma);
      tally.drawn += weight;
      if (view.depth.z[pixel] <= 0) {
        without_depth += weight;
        continue;
      }
      const bool fits =
          count_pixel(view.depth, u, v, drawn.z[i], drawn_normal(drawn, camera, x, y), sigma, options, tally);
      if (fits && options.keep_pixels) verdict.pixels.push_back({index, static_cast<int>(pixel), step});
    }
  if (options.contour) {
    std::vector<double> weights;  // of the faces
    for (const auto& face : model.drawn.faces)
      weights.push_back(evidence_weight(options.tolerance, sigma_of_face(model.sigma.drawn, face)));
    const ContourTally contour = compare_contour(view, drawn, kContourReach * options.tolerance, weights);
    tally.contour.all += contour.all;
    tally.contour.seen += contour.seen, tally.contour.goes_on += contour.goes_on;
  }
  tally.bend.end_view();
  const double visible = std::min(1.0, (tally.area - area_before) * step * step / model.area);
  if (visible <= verdict.visible) return;
  verdict.visible = visible;
  tally.without_depth = without_depth / (tally.drawn - drawn_before);
}

double total(const ScoreLosses& lost) {
  return lost.misfit + lost.seen_through + lost.in_front + lost.hidden + lost.beside + lost.outline +
         lost.below + lost.bend + lost.without_depth + lost.loose;
}

/// Sum of what holds a pose in place: normals that vary, and an outline that is seen to end.
double holding(const Tally& tally) {
  const ContourTally& contour = tally.contour;
  const double ends = contour.all > 0 ? (contour.seen - contour.goes_on) / contour.all : 0.0;
  return tally.bend.variation() / kFullBend + ends;
}

}  // namespace

Verdict verify_pose(const DetectionModel& model, const Pose& T_C_O, const DetectionScene& scene,
                    const VerifyOptions& options) {
  PointsAround points(model, scene.surface);
  return verify_pose(model, T_C_O, scene, options, points.of(T_C_O, kBesideModel));
}

Verdict verify_pose(const DetectionModel& model, const Pose& T_C_O, const DetectionScene& scene,
                    const VerifyOptions& options, std::span<const int> around) {
  Verdict verdict;
  Tally tally;
  for (std::size_t i = 0; i < scene.views.size(); ++i)
    tally_view(model, scene.views[i].T_C_V.inverse() * T_C_O, scene.views[i], static_cast<int>(i), options,
               tally, verdict);
  if (tally.fits < std::max(10.0, kMinSeen * tally.drawn)) return {};
  const double seen = tally.fits + tally.through + tally.just_in_front;
  const double beyond = share_beyond(model, T_C_O, scene.surface, around, options);
  const double goes_on = tally.contour.seen > 0 ? tally.contour.goes_on / tally.contour.seen : 0.0;
  const double below = below_support(model, T_C_O, scene, options.below_table);
  ScoreLosses& lost = verdict.lost;
  lost.misfit = (tally.fits - tally.quality) / seen;
  lost.seen_through = 2.0 * tally.through / seen;  // it does not fit, and it contradicts
  lost.in_front = (1.0 + kJustInFrontWeight) * tally.just_in_front / seen;
  lost.hidden = options.hidden_weight * tally.hidden / seen;
  lost.beside = kBeyondWeight * std::max(0.0, beyond - kBeyondTolerated);
  lost.outline = kGoesOnWeight * std::max(0.0, goes_on - kGoesOnTolerated);
  lost.below = std::max(0.0, below - options.below_table) / kBelowTableScale;
  const double variation = tally.bend.variation();
  lost.bend = kBendWeight * variation / (variation + kLittleBend) *
              std::max(0.0, kBendTolerated - tally.bend.agreement());
  lost.without_depth = kWithoutDepthWeight * std::max(0.0, tally.without_depth - kWithoutDepth);
  if (options.contour) lost.loose = kLooseWeight * std::max(0.0, kHeld - holding(tally));
  verdict.score = 1.0 - total(lost);
  verdict.inlier_ratio = tally.fits / (seen + tally.hidden);
  return verdict;
}

std::vector<PixelEvidence> pixel_evidence(const DetectionModel& model, const Pose& T_C_O,
                                          const DetectionScene& scene, double tolerance) {
  const SeenView& view = scene.views.front();
  const CameraIntrinsics& camera = view.depth.camera;
  std::vector<PixelEvidence> evidence(view.depth.z.size(), PixelEvidence::kNone);
  const DrawnModel drawn =
      draw_model(model.drawn, model.drawn_normals, view.T_C_V.inverse() * T_C_O, camera, 1);
  for (int y = 0; y < drawn.height; ++y)
    for (int x = 0; x < drawn.width; ++x) {
      const auto i = static_cast<std::size_t>(y * drawn.width + x);
      if (drawn.z[i] == 0.0F) continue;
      const int u = drawn.u0 + x, v = drawn.v0 + y;
      const double sigma =
          sigma_of_face(model.sigma.drawn, model.drawn.faces[static_cast<std::size_t>(drawn.face[i])]);
      evidence[static_cast<std::size_t>(v * camera.width + u)] =
          compare_pixel(view.depth, u, v, drawn.z[i], drawn_normal(drawn, camera, x, y),
                        widened(tolerance, sigma))
              .evidence;
    }
  return evidence;
}

}  // namespace stonestack::detection
