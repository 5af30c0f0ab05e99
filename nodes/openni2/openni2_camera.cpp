#include "edge_mcl/nodes/openni2/openni2_camera.h"

#include <OpenNI.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <thread>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

using openni::OpenNI;

/// The message of OpenNI2 about its last failure, in one line.
std::string extendedError() {
  std::string text = OpenNI::getExtendedError();
  for (char& c : text)
    if (c == '\n' || c == '\t') c = ' ';
  text.erase(0, text.find_first_not_of(' '));
  text.resize(text.find_last_not_of(' ') + 1);
  return text;
}

/// Starts the runtime of OpenNI2 at the first call. It runs until the program ends.
void startRuntime() {
  static std::mutex mutex;
  static bool running = false;
  const std::lock_guard<std::mutex> lock(mutex);
  if (running) return;
  if (OpenNI::initialize() != openni::STATUS_OK)
    throw Error("OpenNI2 cannot be started: " + extendedError());
  running = true;
}

bool isRecording(const std::string& device) {
  return device.size() > 4 && device.compare(device.size() - 4, 4, ".oni") == 0;
}

std::string serialOf(const char* uri) {
  openni::Device device;
  if (device.open(uri) != openni::STATUS_OK) return "";
  char serial[256] = "";
  int size = sizeof serial;
  if (device.getProperty(ONI_DEVICE_PROPERTY_SERIAL_NUMBER, serial, &size) != openni::STATUS_OK)
    return "";
  return serial;
}

std::string listed(const std::vector<std::string>& items) {
  std::string text;
  for (const std::string& item : items) text += (text.empty() ? "" : ", ") + item;
  return text.empty() ? "none" : text;
}

/// URI of the wanted device. @throws InputError when there is no such device
std::string uriOf(const std::string& wanted) {
  if (isRecording(wanted)) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(wanted, ignored))
      throw InputError(wanted + ": no such recording");
    return wanted;
  }
  openni::Array<openni::DeviceInfo> found;
  OpenNI::enumerateDevices(&found);
  if (wanted.empty()) {
    if (found.getSize() == 0)
      throw InputError(
          "no OpenNI2 device found (is it plugged in, and do the udev rules permit it?)");
    return found[0].getUri();
  }
  std::vector<std::string> there;
  for (int i = 0; i < found.getSize(); ++i) {
    if (wanted == found[i].getUri()) return wanted;
    there.emplace_back(found[i].getUri());
  }
  for (const std::string& uri : there)
    if (serialOf(uri.c_str()) == wanted) return uri;
  throw InputError("no OpenNI2 device '" + wanted + "'; devices: " + listed(there));
}

std::string textOf(const openni::VideoMode& mode) {
  return std::to_string(mode.getResolutionX()) + "x" + std::to_string(mode.getResolutionY()) + "@" +
         std::to_string(mode.getFps());
}

bool isUsable(openni::PixelFormat format, bool depth) {
  if (depth)
    return format == openni::PIXEL_FORMAT_DEPTH_1_MM || format == openni::PIXEL_FORMAT_DEPTH_100_UM;
  return format == openni::PIXEL_FORMAT_RGB888 || format == openni::PIXEL_FORMAT_GRAY8;
}

CameraModel modelOf(const openni::VideoStream& stream, const std::string& origin) {
  const openni::VideoMode mode = stream.getVideoMode();
  const auto width = static_cast<double>(mode.getResolutionX()),
             height = static_cast<double>(mode.getResolutionY());
  CameraModel model;
  model.width = mode.getResolutionX();
  model.height = mode.getResolutionY();
  model.fx = width / 2 / std::tan(static_cast<double>(stream.getHorizontalFieldOfView()) / 2);
  model.fy = height / 2 / std::tan(static_cast<double>(stream.getVerticalFieldOfView()) / 2);
  model.cx = (width - 1) / 2;
  model.cy = (height - 1) / 2;
  model.validate(origin);
  return model;
}

}  // namespace

struct OpenNi2Camera::Impl : public OpenNI::DeviceDisconnectedListener {
  std::string uri;
  openni::Device device;
  openni::VideoStream color, depth;
  bool has_color = false, has_depth = false, recording = false;
  std::atomic<bool> lost{false};
  std::chrono::steady_clock::time_point last_frame = std::chrono::steady_clock::now();

  void onDeviceDisconnected(const openni::DeviceInfo* info) override {
    if (uri == info->getUri()) lost = true;
  }

  void start(openni::VideoStream* stream, openni::SensorType sensor, int width, int height, int fps,
             bool mirror) {
    const bool is_depth = sensor == openni::SENSOR_DEPTH;
    const std::string name = uri + (is_depth ? ": depth" : ": colour");
    if (stream->create(device, sensor) != openni::STATUS_OK)
      throw InputError(name + " cannot be opened: " + extendedError());
    if (!recording) {
      const auto& modes = stream->getSensorInfo().getSupportedVideoModes();
      std::vector<std::string> there;
      int chosen = -1;
      for (int i = 0; i < modes.getSize(); ++i) {
        if (!isUsable(modes[i].getPixelFormat(), is_depth)) continue;
        there.push_back(textOf(modes[i]));
        const bool fits = modes[i].getResolutionX() == width &&
                          modes[i].getResolutionY() == height && modes[i].getFps() == fps;
        if (fits && chosen < 0) chosen = i;
      }
      if (chosen < 0)
        throw InputError(name + ": no mode " + std::to_string(width) + "x" +
                         std::to_string(height) + "@" + std::to_string(fps) +
                         "; modes: " + listed(there));
      if (stream->setVideoMode(modes[chosen]) != openni::STATUS_OK)
        throw InputError(name + ": the mode cannot be set: " + extendedError());
      if (stream->isPropertySupported(openni::STREAM_PROPERTY_MIRRORING))
        stream->setMirroringEnabled(mirror);
    } else if (!isUsable(stream->getVideoMode().getPixelFormat(), is_depth)) {
      throw InputError(name + ": the recording has a pixel format that is not supported");
    }
    if (stream->start() != openni::STATUS_OK)
      throw InputError(name + " cannot be started: " + extendedError());
  }

  void open(const DepthCameraOptions& o) {
    uri = uriOf(o.device);
    recording = isRecording(o.device);
    if (device.open(uri.c_str()) != openni::STATUS_OK)
      throw InputError(uri + " cannot be opened: " + extendedError());
    OpenNI::addDeviceDisconnectedListener(this);
    if (recording) device.getPlaybackControl()->setRepeatEnabled(false);
    has_color = o.color && device.hasSensor(openni::SENSOR_COLOR);
    has_depth = o.depth && device.hasSensor(openni::SENSOR_DEPTH);
    if (!has_color && !has_depth)
      throw InputError(uri + ": the device has none of the wanted streams");
    const openni::ImageRegistrationMode registration =
        o.registration && has_color ? openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR
                                    : openni::IMAGE_REGISTRATION_OFF;
    if (has_depth && !recording && device.isImageRegistrationModeSupported(registration))
      device.setImageRegistrationMode(registration);
    if (has_color)
      start(&color, openni::SENSOR_COLOR, o.color_width, o.color_height, o.color_fps, o.mirror);
    if (has_depth)
      start(&depth, openni::SENSOR_DEPTH, o.depth_width, o.depth_height, o.depth_fps, o.mirror);
    if (has_color && has_depth && !recording) device.setDepthColorSyncEnabled(true);
  }

  ~Impl() override {
    OpenNI::removeDeviceDisconnectedListener(this);
    for (openni::VideoStream* stream : {&color, &depth})
      if (stream->isValid()) {
        stream->stop();
        stream->destroy();
      }
    device.close();
  }
};

OpenNi2Camera::OpenNi2Camera(const DepthCameraOptions& options) {
  startRuntime();
  impl_ = std::make_unique<Impl>();
  impl_->open(options);
}

OpenNi2Camera::~OpenNi2Camera() {
  // The driver for recordings reads its list of streams in a thread of its own, without a lock.
  // After the end of the recording it does so without a pause, and crashes now and then when a
  // stream is destroyed meanwhile. When all streams are stopped, it reads the list only every 10
  // ms, for an instant. So all streams are stopped first, and destroyed some time later.
  if (!impl_ || !impl_->recording) return;
  for (openni::VideoStream* stream : {&impl_->color, &impl_->depth})
    if (stream->isValid()) stream->stop();
  std::this_thread::sleep_for(std::chrono::milliseconds(35));
}

OpenNi2Camera::Event OpenNi2Camera::read(Frame* frame, int timeout_ms) {
  Impl& m = *impl_;
  if (m.lost) return Event::kLost;
  openni::VideoStream* streams[2];
  int count = 0;
  if (m.has_color) streams[count++] = &m.color;
  if (m.has_depth) streams[count++] = &m.depth;
  int ready = -1;
  const openni::Status status = OpenNI::waitForAnyStream(streams, count, &ready, timeout_ms);
  if (m.lost) return Event::kLost;
  openni::VideoFrameRef grabbed;
  if (status != openni::STATUS_OK || ready < 0 ||
      streams[ready]->readFrame(&grabbed) != openni::STATUS_OK || !grabbed.isValid()) {
    // OpenNI2 does not report the end of a recording. So a recording is over after this time
    // without a frame.
    constexpr std::chrono::seconds kSilence(1);
    if (m.recording && std::chrono::steady_clock::now() - m.last_frame > kSilence)
      return Event::kEnd;
    return Event::kNothing;
  }
  m.last_frame = std::chrono::steady_clock::now();
  const openni::PixelFormat format = grabbed.getVideoMode().getPixelFormat();
  frame->is_depth = streams[ready] == &m.depth;
  frame->device_time = static_cast<double>(grabbed.getTimestamp()) * 1e-6;
  const int type = frame->is_depth                         ? CV_16UC1
                   : format == openni::PIXEL_FORMAT_RGB888 ? CV_8UC3
                                                           : CV_8UC1;
  // Copied, because the runtime uses its buffers again.
  frame->pixels =
      cv::Mat(grabbed.getHeight(), grabbed.getWidth(), type, const_cast<void*>(grabbed.getData()),
              static_cast<size_t>(grabbed.getStrideInBytes()))
          .clone();
  if (format == openni::PIXEL_FORMAT_DEPTH_100_UM) frame->pixels /= 10;
  return Event::kFrame;
}

bool OpenNi2Camera::hasColor() const { return impl_->has_color; }
bool OpenNi2Camera::hasDepth() const { return impl_->has_depth; }

bool OpenNi2Camera::isRegistered() const {
  return impl_->has_depth &&
         impl_->device.getImageRegistrationMode() == openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
}

CameraModel OpenNi2Camera::colorModel() const {
  if (!impl_->has_color) throw Error(impl_->uri + ": no colour stream");
  return modelOf(impl_->color, impl_->uri + ": colour");
}

CameraModel OpenNi2Camera::depthModel() const {
  if (!impl_->has_depth) throw Error(impl_->uri + ": no depth stream");
  return modelOf(impl_->depth, impl_->uri + ": depth");
}

std::string OpenNi2Camera::description() const {
  std::string text = std::string(impl_->device.getDeviceInfo().getName()) + " (" + impl_->uri + ")";
  if (impl_->has_color) text += ", colour " + textOf(impl_->color.getVideoMode());
  if (impl_->has_depth)
    text += std::string(", ") + (isRegistered() ? "registered " : "") + "depth " +
            textOf(impl_->depth.getVideoMode());
  return text;
}

std::vector<std::string> OpenNi2Camera::devices() {
  startRuntime();
  openni::Array<openni::DeviceInfo> found;
  OpenNI::enumerateDevices(&found);
  std::vector<std::string> list;
  list.reserve(static_cast<size_t>(found.getSize()));
  for (int i = 0; i < found.getSize(); ++i)
    list.push_back(std::string(found[i].getUri()) + " (" + found[i].getName() + ")");
  return list;
}

}  // namespace edge_mcl
