#include "edge_mcl/viewer/headless_view.h"

#include <mrpt/img/CImage.h>
#include <mrpt/opengl/CFBORender.h>

#include "edge_mcl/core/error.h"

namespace edge_mcl {

struct HeadlessView::Renderer {
  mrpt::opengl::CFBORender buffer;
  cv::Size size;
  mrpt::img::CImage picture;

  explicit Renderer(const cv::Size& s)
      : buffer(static_cast<unsigned>(s.width), static_cast<unsigned>(s.height)), size(s) {}
};

HeadlessView::HeadlessView(const LocalizationMap* map, const ViewParameters& params)
    : map_(map), params_(params), space_(map, params) {
  params_.validate();
}

HeadlessView::~HeadlessView() = default;

cv::Mat HeadlessView::draw(const ViewMoment& moment, const HistoryView& history) {
  const cv::Size size(params_.width, params_.height);
  const ViewLayout layout = layoutOf(size, moment.image.size());
  space_.update(moment, history);
  cv::Mat picture(size, CV_8UC3);
  try {
    if (!renderer_ || renderer_->size != layout.space.size())
      renderer_ = std::make_unique<Renderer>(layout.space.size());
    renderer_->buffer.setCamera(*space_.scene(), space_.camera());
    renderer_->buffer.render_RGB(*space_.scene(), renderer_->picture);
  } catch (const std::exception& e) {
    throw Error(std::string("nothing can be rendered here (is EGL installed?): ") + e.what());
  }
  renderer_->picture.asCvMat<cv::Mat>(mrpt::img::SHALLOW_COPY).copyTo(picture(layout.space));
  drawLegend(moment, layout.legend.size()).copyTo(picture(layout.legend));
  drawStrips(moment, history, params_.strip_seconds, layout.strips.size())
      .copyTo(picture(layout.strips));
  drawEdgePanel(moment, map_, params_, layout.edges.size()).copyTo(picture(layout.edges));
  drawMaskPanel(moment, layout.masks.size()).copyTo(picture(layout.masks));
  return picture;
}

}  // namespace edge_mcl
