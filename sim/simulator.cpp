#include "edge_mcl/sim/simulator.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/mesh_loader.h"
#include "edge_mcl/sim/random_flight.h"

namespace edge_mcl {

namespace {

MeshModel buildingOf(const std::string& file) {
  MeshModel building = loadMesh(file, {});
  if (!building.origin.isZero())
    throw InputError(file +
                     ": the model is far from its origin; move it there to simulate flights");
  return building;
}

}  // namespace

Simulator::Simulator(Scenario scenario)
    : scenario_(std::move(scenario)),
      scene_(std::make_unique<Scene>(buildingOf(scenario_.model_file))),
      odometry_(scenario_.odometry, scenario_.seed * 3 + 1),
      random_(scenario_.seed * 3 + 2) {
  if (scenario_.random_duration > 0)
    scenario_.path = randomFlight(*scene_,
                                  {scenario_.random_duration, scenario_.random_speed,
                                   scenario_.seed * 3 + 5, scenario_.clearance},
                                  scenario_.file);
  image_count_ = static_cast<size_t>(std::floor(
                     (scenario_.path.end() - scenario_.path.begin()) * scenario_.rate + 1e-6)) +
                 1;
  checkPath();  // before objects are added: the path may lead through objects
  for (const MovableObject& object : scenario_.objects)
    scene_->addObject(loadMesh(object.model_file, {}));
  renderer_ = std::make_unique<Renderer>(*scene_, scenario_.camera, scenario_.lighting);
}

double Simulator::timeOf(size_t image) const {
  return scenario_.path.begin() + static_cast<double>(image) / scenario_.rate;
}

void Simulator::checkPath() const {
  const auto fault = [&](double time, const std::string& what) {
    char text[64];
    std::snprintf(text, sizeof text, "%.2f s", time);
    throw InputError(scenario_.file + ": the path " + what + " at " + text);
  };
  // The path is checked in short steps: between images that are far apart, a straight line may cut
  // a corner that the path goes round.
  constexpr double kStep = 0.05;  // s
  const auto steps = static_cast<size_t>(std::max(1.0, std::ceil(1 / (scenario_.rate * kStep))));
  Eigen::Vector3d last = scenario_.cameraAt(timeOf(0)).translation();
  for (size_t i = 0; i < image_count_; ++i) {
    const double time = timeOf(i);
    for (size_t k = 1; i > 0 && k <= steps; ++k) {
      const double share = static_cast<double>(k) / static_cast<double>(steps);
      const double moment = k == steps ? time : timeOf(i - 1) + share / scenario_.rate;
      const Eigen::Vector3d next = scenario_.cameraAt(moment).translation();
      if (scene_->blocked(last.cast<float>(), next.cast<float>()))
        fault(moment, "leads through the building");
      last = next;
    }
    const Eigen::Vector3d here = scenario_.cameraAt(time).translation();
    if (scenario_.clearance > 0 &&
        scene_->clearance(here, scenario_.clearance) < scenario_.clearance)
      fault(time, "comes closer to the building than the clearance of " +
                      std::to_string(scenario_.clearance) + " m");
  }
}

bool Simulator::isFree(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
  const double clearance = scenario_.clearance;
  return !scene_->blocked(from.cast<float>(), to.cast<float>()) &&
         (clearance <= 0 || scene_->clearance(to, clearance) >= clearance);
}

RecordingSetup Simulator::setup() const {
  const Scenario& s = scenario_;
  RecordingSetup setup;
  setup.camera = s.camera;
  setup.T_base_camera = s.T_body_camera();
  setup.depth_scale = s.depth_scale;
  RandomSource random(s.seed * 3 + 4);
  Vector6 scale;
  scale.head<3>().setConstant(setup.initial_std_position);
  scale.tail<3>().setConstant(setup.initial_std_angle);
  setup.initial_pose =
      normalized(s.cameraAt(timeOf(0)) * expSe3(scale.cwiseProduct(random.normalTwist())));
  return setup;
}

std::vector<std::string> Simulator::notes() const {
  const Scenario& s = scenario_;
  std::vector<std::string> notes;
  char text[400];
  std::snprintf(text, sizeof text,
                "odometry: noise per step and axis %g m and %g deg times sqrt(dt / 0.1 s), plus %g "
                "m/m and %g rad/rad",
                s.odometry.position, s.odometry.angle_deg, s.odometry.per_metre,
                s.odometry.per_radian);
  notes.emplace_back(text);
  std::snprintf(text, sizeof text,
                "camera: noise %g grey levels, exposure swing %g over %g s, exposure %g s, dropped "
                "%g, depth noise %g z^2; masks are exact",
                s.faults.noise, s.faults.exposure_swing, s.faults.exposure_period,
                s.faults.exposure_time, s.faults.dropped, s.faults.depth_noise);
  notes.emplace_back(text);
  std::snprintf(text, sizeof text, "%zu movable objects, seed %llu", s.objects.size(),
                static_cast<unsigned long long>(s.seed));
  notes.emplace_back(text);
  return notes;
}

RenderedImage Simulator::renderAt(double time, const Pose& T_map_camera) {
  for (size_t k = 0; k < scenario_.objects.size(); ++k)
    scene_->place(k, scenario_.objects[k].path.at(time));
  scene_->commit();
  return renderer_->render(T_map_camera);
}

bool Simulator::next(RecordedFrame* frame) {
  if (next_ >= image_count_) throw Error("simulator: the flight is over");
  const double time = timeOf(next_++);
  const auto cameraAt = [this](double t) { return scenario_.cameraAt(t); };
  return take(time, cameraAt, true, frame);
}

bool Simulator::take(double time, const Pose& T_map_camera, bool with_images,
                     RecordedFrame* frame) {
  const auto cameraAt = [&](double) { return T_map_camera; };
  return take(time, cameraAt, with_images, frame);
}

bool Simulator::take(double time, const std::function<Pose(double)>& cameraAt, bool with_images,
                     RecordedFrame* frame) {
  const size_t number = taken_++;
  frame->time = time;
  frame->truth = cameraAt(time);
  frame->odometry = odometry_.next(time, *frame->truth);
  if (random_.uniform() < scenario_.faults.dropped) return false;
  if (!with_images) return true;
  const CameraFaults& faults = scenario_.faults;
  RenderedImage image = renderAt(time, *frame->truth);
  if (faults.exposure_time > 0 && faults.blur_steps > 1) {
    // The time stamp is the middle of the exposure. Depth image and mask belong to this time.
    cv::Mat sum = cv::Mat::zeros(image.color.size(), CV_32FC3);
    for (int k = 0; k < faults.blur_steps; ++k) {
      const double offset = (k + 0.5) / faults.blur_steps - 0.5;
      cv::Mat part;
      const double moment = time + offset * faults.exposure_time;
      renderAt(moment, cameraAt(moment)).color.convertTo(part, CV_32FC3);
      sum += part;
    }
    sum.convertTo(image.color, CV_8UC3, 1.0 / faults.blur_steps);
  }
  spoil(faults, time, scenario_.seed * 1000003 + number, &image.color);
  frame->color = image.color;
  spoilDepth(faults, scenario_.seed * 1000003 + number, &image.depth);
  image.depth.convertTo(frame->depth, CV_16U, scenario_.depth_scale);
  frame->depth.setTo(0, image.depth > 65535 / scenario_.depth_scale);
  cv::Mat building, nothing;
  cv::compare(image.object, 0, building, cv::CMP_EQ);
  cv::compare(image.object, 65535, nothing, cv::CMP_EQ);
  frame->mask = ~(building | nothing);
  return true;
}

}  // namespace edge_mcl
