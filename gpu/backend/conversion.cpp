#include "edge_mcl/gpu/backend/conversion.h"

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/image/edge_field.h"
#include "edge_mcl/core/image/edge_thresholds.h"
#include "edge_mcl/core/image/image_edges.h"

namespace edge_mcl::gpu {

namespace {

constexpr double kViewMargin = 1e-3;  // rad; far larger than the rounding of mayBeInView

}  // namespace

Camera cameraOf(const CameraModel& camera) {
  Camera c{};
  c.fx = static_cast<float>(camera.fx);
  c.fy = static_cast<float>(camera.fy);
  c.cx = static_cast<float>(camera.cx);
  c.cy = static_cast<float>(camera.cy);
  c.last_x = static_cast<float>(camera.width - 1);
  c.last_y = static_cast<float>(camera.height - 1);
  c.max_radius2 = static_cast<float>(camera.maxPlaneRadius2());
  c.min_depth = static_cast<float>(CameraModel::kMinDepth);
  c.view_sin = static_cast<float>(std::sin(std::min(M_PI, camera.view.angle + kViewMargin)));
  c.view_cos = static_cast<float>(std::cos(std::min(M_PI, camera.view.angle + kViewMargin)));
  c.distortion = static_cast<int32_t>(camera.distortion);
  for (int i = 0; i < 8; ++i) c.k[i] = static_cast<float>(camera.coefficients[i]);
  return c;
}

Table tableOf(const ScoreTable& table) {
  return {table.width(),      table.height(), table.bins(),
          table.hasIgnored(), table.scale(),  table.offset()};
}

Rule ruleOf(const LikelihoodFrame& frame) {
  const LikelihoodParameters& p = frame.params;
  return {p.model == LikelihoodModel::kPaper, static_cast<float>(1 / p.line_saturation),
          p.border_fade > 0 ? static_cast<float>(1 / p.border_fade) : 1e9f,
          static_cast<float>(spacingScale(frame))};
}

Combination combinationOf(const LikelihoodParameters& params) {
  return {params.scale, params.line_correlation, std::log(params.alpha), params.k};
}

Particle particleOf(const edge_mcl::Pose& T_map_camera, uint32_t cell) {
  Particle p{};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) p.rotation[3 * r + c] = T_map_camera.linear()(r, c);
    p.position[r] = T_map_camera.translation()[r];
  }
  p.cell = cell;
  return p;
}

Table tableOf(const Picture& picture) {
  return {picture.grey().cols,       picture.grey().rows,       picture.params().orientation_bins,
          !picture.ignore().empty(), picture.levels()->scale(), picture.levels()->offset()};
}

bool canMakeTables(const ImageParameters& params) {
  return !params.straight_segments && params.orientation_bins <= kMostBins &&
         blurWeights(params.blur_sigma).size() <= kMostBlurRadius + 1;
}

TableRecipe recipeOf(int width, int height, const ImageParameters& params,
                     const ScoreLevels& levels) {
  static_assert(kClutterCell == EdgeField::kClutterCell && kBlurUnit == 64);
  const SearchGeometry search(params);
  const std::vector<int> blur = blurWeights(params.blur_sigma);
  TableRecipe recipe;
  PictureWork& w = recipe.work;
  w.width = width;
  w.height = height;
  w.bins = search.bins();
  w.levels = static_cast<int32_t>(levels.levels());
  w.entries = static_cast<int32_t>(levels.entries());
  w.window_cells = EdgeField::windowCells(params);
  w.cell_columns = (width + kClutterCell - 1) / kClutterCell;
  w.cell_rows = (height + kClutterCell - 1) / kClutterCell;
  w.longest = std::max(width, height);
  w.blur_radius = static_cast<int32_t>(blur.size()) - 1;
  w.gradient_scale = EdgeImage::kGradientScale;
  std::copy(blur.begin(), blur.end(), w.blur);
  w.sine = static_cast<float>(std::sin(params.orientation_tolerance_deg * M_PI / 180));
  w.edge_share = params.edge_share;
  w.noise_factor = params.noise_factor;
  w.hysteresis = params.hysteresis;
  w.least_threshold = EdgeImage::kLeastThreshold;
  static_assert(kSquareLevels == EdgeThresholds::kLevels);
  w.tile = EdgeThresholds::tileOf(params);
  w.tile_columns = w.tile > 0 ? (width + w.tile - 1) / w.tile : 1;
  w.tile_rows = w.tile > 0 ? (height + w.tile - 1) / w.tile : 1;
  for (int b = 0; b < w.bins; ++b) {
    const SearchGeometry::Walk& walk = search.walk(b);
    recipe.directions.push_back({walk.du, walk.dv, walk.transposed, search.noEdge(b)});
    for (int row = 0; row < w.longest; ++row)
      recipe.shifts.push_back(static_cast<int32_t>(std::lround(walk.slope * row)));
    for (size_t level = 0; level < levels.levels(); ++level) {
      const uint8_t* codes = levels.codesOfLevel(b, level);
      recipe.level_codes.insert(recipe.level_codes.end(), codes, codes + levels.entries());
    }
  }
  recipe.level_borders = levels.borders();
  return recipe;
}

PictureData dataOf(const Picture& picture) {
  const cv::Mat &grey = picture.grey(), &ignore = picture.ignore();
  return {grey.data, grey.step, ignore.empty() ? nullptr : ignore.data,
          ignore.empty() ? 0 : static_cast<size_t>(ignore.step)};
}

}  // namespace edge_mcl::gpu
