#include "edge_mcl/viewer/scene/scene_view.h"

#include <mrpt/img/CImage.h>
#include <mrpt/opengl/CBox.h>
#include <mrpt/opengl/CEllipsoid3D.h>
#include <mrpt/opengl/CPointCloud.h>
#include <mrpt/opengl/CPointCloudColoured.h>
#include <mrpt/opengl/CSetOfLines.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <mrpt/opengl/CSetOfTriangles.h>
#include <mrpt/opengl/CSphere.h>
#include <mrpt/opengl/CTexturedPlane.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"
#include "edge_mcl/viewer/drawing/view_colors.h"

namespace edge_mcl {

using namespace mrpt::opengl;

namespace {

mrpt::img::TColor toColor(const cv::Scalar& bgr, uint8_t alpha = 255) {
  return {static_cast<uint8_t>(bgr[2]), static_cast<uint8_t>(bgr[1]), static_cast<uint8_t>(bgr[0]),
          alpha};
}

CSetOfLines::Ptr makeLines(const cv::Scalar& color, float width) {
  auto lines = CSetOfLines::Create();
  lines->setColor_u8(toColor(color));
  lines->setLineWidth(width);
  lines->enableAntiAliasing(false);
  return lines;
}

void setPath(const std::vector<Eigen::Vector3f>& path, CSetOfLines* lines) {
  lines->clear();
  for (size_t i = 1; i < path.size(); ++i)
    lines->appendLine(path[i - 1].x(), path[i - 1].y(), path[i - 1].z(), path[i].x(), path[i].y(),
                      path[i].z());
  lines->notifyChange();
}

/// Adds the way from a place to its next view, with an arrow that shows where the camera looks.
void addNextView(const Pose& from, const Pose& T_map_camera, CSetOfLines* lines) {
  const auto add = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    lines->appendLine(a.x(), a.y(), a.z(), b.x(), b.y(), b.z());
  };
  constexpr double kArrow = 0.6, kHead = 0.2;  // m
  const Eigen::Vector3d eye = T_map_camera.translation();
  const Eigen::Vector3d tip = T_map_camera * Eigen::Vector3d(0, 0, kArrow);
  add(from.translation(), eye);
  add(eye, tip);
  for (const double side : {-kHead, kHead})
    add(tip, T_map_camera * Eigen::Vector3d(side, 0, kArrow - kHead));
}

/// The edges of the box of an object that is not in the model; thin while it is out of view.
CBox::Ptr boxAround(const ObjectState& object) {
  const auto corner = [](const Eigen::Vector3d& p) {
    return mrpt::math::TPoint3D(p.x(), p.y(), p.z());
  };
  const float width = object.is_in_view ? 2.5F : 1.0F;
  auto box = CBox::Create(corner(object.box.min()), corner(object.box.max()), true, width);
  box->setBoxBorderColor(toColor(view_colors::kForeign));
  return box;
}

}  // namespace

struct SceneView::Objects {
  CSetOfTriangles::Ptr faces = CSetOfTriangles::Create();
  CSetOfLines::Ptr edges = makeLines({90, 90, 90}, 1);
  CPointCloudColoured::Ptr particles = CPointCloudColoured::Create();
  CPointCloud::Ptr depth = CPointCloud::Create();
  CEllipsoid3D::Ptr covariance = CEllipsoid3D::Create();
  CSetOfLines::Ptr path = makeLines(view_colors::kEstimate, 3);
  CSetOfLines::Ptr truth_path = makeLines(view_colors::kTruth, 2);
  CSetOfLines::Ptr frustum = makeLines(view_colors::kEstimate, 3);
  CTexturedPlane::Ptr picture = CTexturedPlane::Create();
  CSphere::Ptr truth = CSphere::Create();
  CSetOfObjects::Ptr clusters = CSetOfObjects::Create();
  CSetOfObjects::Ptr foreign = CSetOfObjects::Create();
  CSetOfLines::Ptr next_view = makeLines(view_colors::kNextView, 3);
};

SceneView::SceneView(const LocalizationMap* map, const ViewParameters& params)
    : params_(params), scene_(COpenGLScene::Create()), objects_(std::make_unique<Objects>()) {
  Objects& o = *objects_;
  o.faces->enableLight(false);  // ModelShape has already shaded them
  o.particles->setPointSize(3);
  o.depth->setPointSize(2);
  o.depth->setColor_u8(toColor(view_colors::kDepth));
  o.covariance->setQuantiles(3);
  o.covariance->setColor_u8(toColor(view_colors::kCovariance));
  o.covariance->enableDrawSolid3D(false);
  o.covariance->setLineWidth(1.5F);
  // Lines are drawn before faces. Smoothed lines would keep the background at their borders.
  o.covariance->enableAntiAliasing(false);
  o.picture->CRenderizableShaderTexturedTriangles::enableLight(false);
  o.picture->CRenderizableShaderTriangles::enableLight(false);
  o.truth->setColor_u8(toColor(view_colors::kTruth));
  o.truth->enableLight(false);
  for (const CRenderizable::Ptr& object : std::initializer_list<CRenderizable::Ptr>{
           o.faces, o.edges, o.depth, o.particles, o.covariance, o.truth_path, o.path, o.frustum,
           o.picture, o.truth, o.clusters, o.foreign, o.next_view})
    scene_->insert(object);
  scene_->getViewport()->enablePolygonNicest(false);
  scene_->getViewport()->setCustomBackgroundColor({0.84F, 0.84F, 0.84F, 1.0F});
  setMap(map);
}

SceneView::~SceneView() = default;

void SceneView::setMap(const LocalizationMap* map) {
  map_ = map;
  height_.reset();
  has_focus_ = false;
  if (map_ == nullptr) return;
  const Eigen::Vector3d low = map_->mesh().lowest.cast<double>();
  const Eigen::Vector3d high = map_->mesh().highest.cast<double>();
  focus_ = (low + high) / 2;
  distance_ = 1.3 * std::max(0.05, map_->mesh().diagonal());
}

bool SceneView::isSmall() const {
  constexpr double kRoom = 2;  // m
  return map_ != nullptr && map_->mesh().diagonal() < kRoom;
}

void SceneView::setParameters(const ViewParameters& params) {
  const bool other_style = params.model_style != params_.model_style;
  params_ = params;
  if (other_style && height_) showModel(*height_);
}

void SceneView::showModel(float height) {
  height_ = height;
  if (map_ == nullptr) return;
  shape_ = shapeBelow(map_->mesh(), map_->edges(), height);
  Objects& o = *objects_;
  o.faces->clearTriangles();
  o.edges->clear();
  const bool ghost = params_.model_style == "ghost";
  if (params_.model_style != "wireframe")
    for (const ModelShape::Triangle& t : shape_.triangles) {
      TTriangle triangle;
      for (size_t k = 0; k < 3; ++k)
        triangle.vertices[k].xyzrgba.pt = {t.corners[k].x(), t.corners[k].y(), t.corners[k].z()};
      triangle.setColor(
          mrpt::img::TColorf(t.color.x(), t.color.y(), t.color.z(), ghost ? 0.25F : 1.0F));
      triangle.computeNormals();
      o.faces->insertTriangle(triangle);
    }
  for (const auto& [from, to] : shape_.lines)
    o.edges->appendLine(from.x(), from.y(), from.z(), to.x(), to.y(), to.z());
  o.faces->notifyChange();
  o.edges->notifyChange();
}

void SceneView::cutFor(const ViewMoment& m) {
  if (map_ == nullptr) return;
  float height = map_->mesh().highest.z();
  if (!isSmall()) {
    constexpr float kWithoutPose = 2;  // m above the floor
    height = m.has_pose ? static_cast<float>((m.estimate.mean * m.T_base_camera).translation().z() +
                                             params_.cut_above)
                        : map_->mesh().lowest.z() + kWithoutPose;
    constexpr float kUnsteady =
        0.4F;  // m; the cut stays for smaller changes, because a moving cut is hard to look at
    if (height_ && std::abs(height - *height_) < kUnsteady) return;
  } else if (height_) {
    return;
  }
  showModel(height);
}

void SceneView::showCamera(const ViewMoment& m, const Pose& T_map_camera) {
  Objects& o = *objects_;
  const CameraModel& c = m.camera;
  const double depth = 0.1 * distance_;
  const double left = -c.cx / c.fx * depth, right = (c.width - c.cx) / c.fx * depth;
  const double top = -c.cy / c.fy * depth, bottom = (c.height - c.cy) / c.fy * depth;
  const Eigen::Vector3d corners[] = {
      {left, top, depth}, {right, top, depth}, {right, bottom, depth}, {left, bottom, depth}};
  const Eigen::Vector3d eye = T_map_camera.translation();
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector3d a = T_map_camera * corners[k], b = T_map_camera * corners[(k + 1) % 4];
    o.frustum->appendLine(eye.x(), eye.y(), eye.z(), a.x(), a.y(), a.z());
    o.frustum->appendLine(a.x(), a.y(), a.z(), b.x(), b.y(), b.z());
  }
  if (m.image.empty()) return;
  // The axes of the plane are x to the right and y up.
  Pose plane = T_map_camera * Eigen::Translation3d(0, 0, depth) *
               Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
  o.picture->setPose(toMrpt(plane));
  o.picture->setPlaneCorners(static_cast<float>(left), static_cast<float>(right),
                             static_cast<float>(-bottom), static_cast<float>(-top));
  o.picture->setVisibility(true);
  const double now =
      std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  if (now - picture_at_ < picture_period_) return;
  picture_at_ = now;
  cv::Mat small;
  constexpr int kWidth = 320;
  cv::resize(shownImage(m.image), small,
             {kWidth, std::max(1, kWidth * m.image.rows / m.image.cols)}, 0, 0, cv::INTER_AREA);
  if (small.channels() == 1) cv::cvtColor(small, small, cv::COLOR_GRAY2BGR);
  o.picture->assignImage(mrpt::img::CImage(small, mrpt::img::DEEP_COPY));
}

void SceneView::showPoses(const ViewMoment& m, const HistoryView& history) {
  Objects& o = *objects_;
  o.particles->clear();
  // The particles with the largest weights are drawn last, so that they lie on top.
  const bool weighted = m.weights.size() == m.particles.size();
  std::vector<size_t> order(m.particles.size());
  std::iota(order.begin(), order.end(), size_t{0});
  if (weighted)
    std::sort(order.begin(), order.end(),
              [&](size_t a, size_t b) { return m.weights[a] < m.weights[b]; });
  for (size_t i : order) {
    const Eigen::Vector3d p = m.particles[i].translation();
    const cv::Vec3b c = view_colors::ofWeight(weighted ? m.weights[i] : 1);
    o.particles->push_back(static_cast<float>(p.x()), static_cast<float>(p.y()),
                           static_cast<float>(p.z()), static_cast<float>(c[2]) / 255,
                           static_cast<float>(c[1]) / 255, static_cast<float>(c[0]) / 255, 1);
  }
  o.particles->markAllPointsAsNew();
  o.depth->clear();
  if (m.has_pose && params_.depth_points) {
    const Eigen::Isometry3f to_map = m.estimate.mean.cast<float>();
    for (const Eigen::Vector3f& point : m.depth_points) {
      const Eigen::Vector3f p = to_map * point;
      // The walls are cut at this height, so a point above it would float in the air.
      if (height_ && p.z() > *height_) continue;
      o.depth->insertPoint(p.x(), p.y(), p.z());
    }
  }
  setPath(history.path, o.path.get());
  setPath(history.truth_path, o.truth_path.get());
  o.truth->setVisibility(m.truth.has_value());
  if (m.truth) {
    o.truth->setRadius(static_cast<float>(0.006 * distance_));
    o.truth->setPose(toMrpt(*m.truth));
  }
  o.covariance->setVisibility(m.has_pose);
  if (m.has_pose) {
    const Eigen::Matrix3d rotation = m.estimate.mean.linear();
    const Eigen::Matrix3d in_map =
        rotation * m.estimate.covariance.topLeftCorner<3, 3>() * rotation.transpose();
    mrpt::math::CMatrixDouble33 covariance;
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) covariance(i, k) = in_map(i, k) + (i == k ? 1e-8 : 0);
    o.covariance->setCovMatrix(covariance);
    const Eigen::Vector3d p = m.estimate.mean.translation();
    o.covariance->setLocation(p.x(), p.y(), p.z());
  }
  o.clusters->clear();
  for (const PoseCluster& cluster : m.clusters) {
    const Eigen::Vector3d p = cluster.pose.translation();
    auto ball = CSphere::Create(
        static_cast<float>((0.008 + 0.02 * std::sqrt(cluster.probability)) * distance_));
    ball->setColor_u8(toColor(view_colors::kHypothesis));
    ball->enableLight(false);
    ball->setLocation(p.x(), p.y(), p.z());
    o.clusters->insert(ball);
  }
  o.foreign->clear();
  for (const ObjectState& object : m.foreign) o.foreign->insert(boxAround(object));
  o.next_view->clear();
  for (size_t i = 0; i < std::min(m.next_view.size(), m.clusters.size()); ++i)
    addNextView(m.clusters[i].pose, m.next_view[i] * m.T_base_camera, o.next_view.get());
  o.next_view->notifyChange();
}

double SceneView::distanceSeen(const ViewMoment& m, const Pose& T_map_camera) const {
  constexpr double kUnknown = 2;  // m
  if (map_ == nullptr || !m.has_camera) return kUnknown;
  const Pose to_camera = T_map_camera.inverse();
  std::vector<double> distances;
  for (const EdgeSegment& segment : map_->edges().segments) {
    const Eigen::Vector3d p = to_camera * segment.centre.cast<double>();
    Eigen::Vector2d pixel;
    if (m.camera.project(p, &pixel) && m.camera.contains(pixel)) distances.push_back(p.norm());
  }
  if (distances.empty()) return kUnknown;
  // The 30 % quantile, because the farther segments are usually behind walls.
  const auto nearer =
      distances.begin() + static_cast<long>(0.3 * static_cast<double>(distances.size()));
  std::nth_element(distances.begin(), nearer, distances.end());
  return *nearer;
}

void SceneView::look(const ViewMoment& m) {
  if (map_ == nullptr && !m.has_pose) return;
  const Eigen::Vector3d low = map_ ? map_->mesh().lowest.cast<double>().eval() : focus_;
  const Eigen::Vector3d high = map_ ? map_->mesh().highest.cast<double>().eval() : focus_;
  Eigen::Vector3d wanted = (low + high) / 2;
  double distance = 1.3 * std::max(0.05, (high - low).norm());
  if (m.has_pose && params_.follow) {
    // The focus lies between the camera and what it sees.
    const Pose camera = m.estimate.mean * m.T_base_camera;
    const double seen = distanceSeen(m, camera);
    constexpr double kNearest = 0.3, kFarthest = 9;  // m
    distance = std::clamp(3.5 * seen, kNearest, kFarthest);
    wanted = camera.translation() + 0.12 * distance * camera.linear().col(2);
  }
  // The focus moves slowly, except at the start and when the pose jumps.
  const bool jump = !has_focus_ || (wanted - focus_).norm() > 0.3 * distance;
  const double share = jump ? 1 : 0.1;
  focus_ += share * (wanted - focus_);
  distance_ += (has_focus_ ? share : 1) * (distance - distance_);
  has_focus_ = m.has_pose;
  const auto near = static_cast<float>(0.02 * distance_ / params_.zoom);
  scene_->getViewport()->setViewportClipDistances(near, near * 2000);
}

void SceneView::update(const ViewMoment& m, const HistoryView& history) {
  look(m);
  cutFor(m);
  showPoses(m, history);
  objects_->frustum->clear();
  objects_->picture->setVisibility(false);
  if (m.has_pose && m.has_camera) showCamera(m, m.estimate.mean * m.T_base_camera);
  objects_->frustum->notifyChange();
}

CCamera SceneView::camera() const {
  CCamera camera;
  camera.setProjectiveModel(true);
  camera.setProjectiveFOVdeg(static_cast<float>(kFieldOfViewDeg));
  camera.setPointingAt(focus_.x(), focus_.y(), focus_.z());
  camera.setZoomDistance(static_cast<float>(distance_ / params_.zoom));
  camera.setAzimuthDegrees(static_cast<float>(params_.azimuth));
  camera.setElevationDegrees(static_cast<float>(params_.elevation));
  return camera;
}

}  // namespace edge_mcl
