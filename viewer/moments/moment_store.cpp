#include "edge_mcl/viewer/moments/moment_store.h"

#include <opencv2/imgcodecs.hpp>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

size_t MomentStore::Stored::bytes() const {
  return image.size() + mask.size() + particles.size() * sizeof(particles[0]) +
         moment.weights.size() * sizeof(float) +
         moment.depth_points.size() * sizeof(Eigen::Vector3f);
}

void MomentStore::add(const ViewMoment& moment) {
  Stored s;
  s.moment = moment;
  s.moment.image.release();
  s.moment.mask.release();
  s.moment.particles.clear();
  if (!moment.image.empty())
    cv::imencode(".jpg", shownImage(moment.image), s.image, {cv::IMWRITE_JPEG_QUALITY, 92});
  if (!moment.mask.empty())
    cv::imencode(".png", moment.mask, s.mask, {cv::IMWRITE_PNG_COMPRESSION, 1});
  for (const Pose& pose : moment.particles) {
    const Eigen::Quaternionf q(pose.linear().cast<float>());
    const Eigen::Vector3f p = pose.translation().cast<float>();
    s.particles.push_back({p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()});
  }
  // The newest moments are shown next. Only they keep their prepared image; it is made again for
  // older ones.
  constexpr size_t kPrepared = 4;
  if (moments_.size() >= kPrepared) moments_[moments_.size() - kPrepared].moment.prepared.reset();
  bytes_ += s.bytes();
  moments_.push_back(std::move(s));
  while (bytes_ > most_bytes_ && forgotten_ + 1 < moments_.size()) {
    Stored& oldest = moments_[forgotten_++];
    bytes_ -= oldest.bytes();
    oldest.image = {};
    oldest.mask = {};
    oldest.particles = {};
    oldest.moment.weights = {};
    oldest.moment.depth_points = {};
  }
}

ViewMoment MomentStore::get(size_t i) const {
  if (i >= moments_.size()) throw Error("no such moment");
  const Stored& s = moments_[i];
  ViewMoment moment = s.moment;
  if (!s.image.empty()) moment.image = cv::imdecode(s.image, cv::IMREAD_UNCHANGED);
  if (!s.mask.empty()) moment.mask = cv::imdecode(s.mask, cv::IMREAD_UNCHANGED);
  for (const auto& v : s.particles) {
    Pose pose = Pose::Identity();
    pose.linear() = Eigen::Quaterniond(static_cast<double>(v[6]), static_cast<double>(v[3]),
                                       static_cast<double>(v[4]), static_cast<double>(v[5]))
                        .normalized()
                        .toRotationMatrix();
    pose.translation() = Eigen::Vector3f(v[0], v[1], v[2]).cast<double>();
    moment.particles.push_back(pose);
  }
  return moment;
}

}  // namespace edge_mcl
