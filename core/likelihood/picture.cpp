#include "edge_mcl/core/likelihood/picture.h"

#include <utility>

#include "edge_mcl/core/image/edge_field.h"
#include "edge_mcl/core/image/edge_pixels.h"
#include "edge_mcl/core/image/image_edges.h"

namespace edge_mcl {

Picture::Picture(cv::Mat grey, cv::Mat ignore, const ImageParameters& params,
                 std::shared_ptr<const ScoreLevels> levels)
    : grey_(std::move(grey)),
      ignore_(std::move(ignore)),
      params_(params),
      levels_(std::move(levels)) {}

std::shared_ptr<const ScoreTable> Picture::table() const {
  std::call_once(made_, [&] {
    const EdgeImage edges = findEdgesOf(grey_, ignore_, params_);
    table_ = std::make_shared<ScoreTable>(EdgeField(edges, EdgePixels(edges), params_), *levels_);
  });
  return table_;
}

}  // namespace edge_mcl
