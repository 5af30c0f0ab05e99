#include "edge_mcl/viewer/output/headless_view.h"

#include <mrpt/img/CImage.h>
#include <mrpt/opengl/CFBORender.h>

#include <algorithm>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

struct HeadlessView::Renderer {
  mrpt::opengl::CFBORender buffer;
  mrpt::img::CImage picture;

  explicit Renderer(const cv::Size& s)
      : buffer(static_cast<unsigned>(s.width), static_cast<unsigned>(s.height)) {}
};

namespace {

/// Returns the message of an MRPT exception without the place where it was thrown.
std::string messageOf(const std::exception& e) {
  std::string text = e.what();
  const std::string label = "Message:";
  const size_t at = text.find(label);
  if (at != std::string::npos) text.erase(0, at + label.size());
  text.erase(0, std::min(text.size(), text.find_first_not_of(" \n")));
  return text.substr(0, text.find('\n'));
}

}  // namespace

HeadlessView::HeadlessView(const LocalizationMap* map, const ViewParameters& params)
    : map_(map), params_(params), space_(map, params) {
  params_.validate();
}

HeadlessView::~HeadlessView() = default;

void HeadlessView::setMap(const LocalizationMap* map) {
  map_ = map;
  space_.setMap(map);
}

cv::Mat HeadlessView::draw(const ViewMoment& moment, const HistoryView& history) {
  const cv::Size size(params_.width, params_.height);
  space_.update(moment, history);
  cv::Mat picture(size, CV_8UC3);
  try {
    if (!renderer_) {
      layout_ = layoutOf(size, moment.image.size());
      renderer_ = std::make_unique<Renderer>(layout_.space.size());
    }
    renderer_->buffer.setCamera(*space_.scene(), space_.camera());
    renderer_->buffer.render_RGB(*space_.scene(), renderer_->picture);
  } catch (const std::exception& e) {
    throw InputError("nothing can be rendered here (is EGL installed?): " + messageOf(e));
  }
  renderer_->picture.asCvMat<cv::Mat>(mrpt::img::SHALLOW_COPY).copyTo(picture(layout_.space));
  drawLegend(moment, layout_.legend.size()).copyTo(picture(layout_.legend));
  drawStrips(moment, history, params_.strip_seconds, layout_.strips.size())
      .copyTo(picture(layout_.strips));
  drawEdgePanel(moment, map_, params_, layout_.edges.size()).copyTo(picture(layout_.edges));
  drawMaskPanel(moment, layout_.masks.size()).copyTo(picture(layout_.masks));
  return picture;
}

}  // namespace edge_mcl
