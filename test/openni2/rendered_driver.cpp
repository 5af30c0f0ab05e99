// A driver for the OpenNI2 runtime. Its device streams a rendered flight.
//
// EDGE_MCL_DRIVER_SCENARIO: the flight. EDGE_MCL_DRIVER_PLUGGED: the device is there while a file
// of this name exists. The two macros belong to a library that OniDriverAPI.h expects and Debian
// does not ship.
#define XN_NEW(type, argument) new type(argument)
#define XN_DELETE(pointer) delete (pointer)
#include <Driver/OniDriverAPI.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "edge_mcl/sim/simulator.h"

namespace {

using namespace oni::driver;

constexpr int kFps = 15;  // the rate of the flight
constexpr const char* kUri = "rendered://flight";
constexpr const char* kSerial = "RENDERED-0001";

std::string setting(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

class RenderedStream : public StreamBase {
 public:
  RenderedStream(OniSensorType sensor, const OniVideoMode& mode,
                 const edge_mcl::CameraModel& camera)
      : sensor_(sensor), mode_(mode), camera_(camera) {}

  OniStatus start() override {
    running_ = true;
    return ONI_STATUS_OK;
  }
  // Waits until the current frame is delivered, because the runtime destroys its side of a stopped
  // stream.
  void stop() override {
    running_ = false;
    const std::lock_guard<std::mutex> lock(delivery_);
  }

  OniStatus getProperty(int id, void* data, int* size) override {
    if (id == ONI_STREAM_PROPERTY_VIDEO_MODE) return give(mode_, data, size);
    if (id == ONI_STREAM_PROPERTY_HORIZONTAL_FOV)
      return give(static_cast<float>(2 * std::atan(camera_.width / (2 * camera_.fx))), data, size);
    if (id == ONI_STREAM_PROPERTY_VERTICAL_FOV)
      return give(static_cast<float>(2 * std::atan(camera_.height / (2 * camera_.fy))), data, size);
    if (id == ONI_STREAM_PROPERTY_MAX_VALUE) return give(10000, data, size);
    // When a stream does not report these two properties, its recording plays no frames.
    if (id == ONI_STREAM_PROPERTY_CROPPING) return give(OniCropping{}, data, size);
    if (id == ONI_STREAM_PROPERTY_STRIDE) {
      const int bytes = mode_.pixelFormat == ONI_PIXEL_FORMAT_RGB888 ? 3 : 2;
      return give(bytes * mode_.resolutionX, data, size);
    }
    return ONI_STATUS_NOT_SUPPORTED;
  }
  OniStatus setProperty(int id, const void* data, int size) override {
    if (id != ONI_STREAM_PROPERTY_VIDEO_MODE || size != sizeof mode_)
      return ONI_STATUS_NOT_SUPPORTED;
    return std::memcmp(data, &mode_, sizeof mode_) == 0 ? ONI_STATUS_OK : ONI_STATUS_BAD_PARAMETER;
  }
  OniBool isPropertySupported(int id) override {
    return id <= ONI_STREAM_PROPERTY_VIDEO_MODE || id == ONI_STREAM_PROPERTY_MAX_VALUE ||
           id == ONI_STREAM_PROPERTY_STRIDE;
  }

  void deliver(const cv::Mat& pixels, int index, uint64_t microseconds) {
    const std::lock_guard<std::mutex> lock(delivery_);
    if (!running_) return;
    OniFrame* frame = getServices().acquireFrame();
    if (!frame) return;
    frame->sensorType = sensor_;
    frame->videoMode = mode_;
    frame->width = pixels.cols;
    frame->height = pixels.rows;
    frame->stride = static_cast<int>(pixels.cols * pixels.elemSize());
    frame->dataSize = frame->stride * pixels.rows;
    frame->frameIndex = index;
    frame->timestamp = microseconds;
    frame->croppingEnabled = FALSE;
    frame->cropOriginX = frame->cropOriginY = 0;
    std::memcpy(frame->data, pixels.data, static_cast<size_t>(frame->dataSize));
    raiseNewFrame(frame);
    getServices().releaseFrame(frame);
  }

 private:
  template <class Value>
  static OniStatus give(const Value& value, void* data, int* size) {
    if (*size < static_cast<int>(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
    std::memcpy(data, &value, sizeof value);
    *size = sizeof value;
    return ONI_STATUS_OK;
  }
  OniSensorType sensor_;
  OniVideoMode mode_;
  edge_mcl::CameraModel camera_;
  std::mutex delivery_;
  std::atomic<bool> running_{false};
};

class RenderedDevice : public DeviceBase {
 public:
  RenderedDevice() {
    scenario_ = edge_mcl::Scenario::fromYamlFile(setting("EDGE_MCL_DRIVER_SCENARIO"));
    for (int i = 0; i < 2; ++i) {
      const OniPixelFormat format = i == 0 ? ONI_PIXEL_FORMAT_RGB888 : ONI_PIXEL_FORMAT_DEPTH_1_MM;
      modes_[i] = {format, scenario_.camera.width, scenario_.camera.height, kFps};
      sensors_[i] = {i == 0 ? ONI_SENSOR_COLOR : ONI_SENSOR_DEPTH, 1, &modes_[i]};
    }
    thread_ = std::thread([this] { fly(); });
  }
  ~RenderedDevice() override {
    running_ = false;
    thread_.join();
  }

  OniStatus getSensorInfoList(OniSensorInfo** list, int* count) override {
    *list = sensors_;
    *count = 2;
    return ONI_STATUS_OK;
  }
  StreamBase* createStream(OniSensorType sensor) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    const bool is_depth = sensor == ONI_SENSOR_DEPTH;
    if (!is_depth && sensor != ONI_SENSOR_COLOR) return nullptr;
    Streams& streams = is_depth ? depth_ : color_;
    streams.push_back(
        std::make_shared<RenderedStream>(sensor, modes_[is_depth ? 1 : 0], scenario_.camera));
    return streams.back().get();
  }
  void destroyStream(StreamBase* stream) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    for (Streams* streams : {&color_, &depth_})
      streams->erase(std::remove_if(streams->begin(), streams->end(),
                                    [&](const auto& s) { return s.get() == stream; }),
                     streams->end());
  }
  OniStatus getProperty(int id, void* data, int* size) override {
    if (id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) {
      std::memcpy(data, &registration_, sizeof registration_);
      return ONI_STATUS_OK;
    }
    if (id != ONI_DEVICE_PROPERTY_SERIAL_NUMBER) return ONI_STATUS_NOT_SUPPORTED;
    std::strncpy(static_cast<char*>(data), kSerial, static_cast<size_t>(*size));
    return ONI_STATUS_OK;
  }
  OniStatus setProperty(int id, const void* data, int) override {
    if (id != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) return ONI_STATUS_NOT_SUPPORTED;
    std::memcpy(&registration_, data, sizeof registration_);
    return ONI_STATUS_OK;
  }
  OniBool isPropertySupported(int id) override {
    return id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION || id == ONI_DEVICE_PROPERTY_SERIAL_NUMBER;
  }
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode) override { return TRUE; }

 private:
  using Streams = std::vector<std::shared_ptr<RenderedStream>>;

  void fly() {
    edge_mcl::Simulator simulator(scenario_);
    edge_mcl::RecordedFrame frame;
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 0; running_; ++i) {
      // At the end the last frame is repeated.
      if (i < static_cast<int>(simulator.imageCount())) simulator.next(&frame);
      cv::Mat color, depth;
      cv::cvtColor(frame.color, color, cv::COLOR_BGR2RGB);
      frame.depth.convertTo(depth, CV_16U, 1000 / scenario_.depth_scale);
      const auto due = begin + std::chrono::microseconds(1000000LL * i / kFps);
      std::this_thread::sleep_until(due);
      const auto time = static_cast<uint64_t>(1000000LL * i / kFps);
      // Frames are delivered without the lock. The runtime creates and destroys streams under its
      // own locks, and takes these locks for a new frame, too.
      const auto [depth_streams, color_streams] = openStreams();
      for (const auto& stream : depth_streams) stream->deliver(depth, i, time);
      for (const auto& stream : color_streams) stream->deliver(color, i, time);
    }
  }
  std::pair<Streams, Streams> openStreams() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return {depth_, color_};
  }

  edge_mcl::Scenario scenario_;
  OniVideoMode modes_[2];
  OniSensorInfo sensors_[2];
  OniImageRegistrationMode registration_ = ONI_IMAGE_REGISTRATION_OFF;
  std::mutex mutex_;
  Streams color_, depth_;
  std::atomic<bool> running_{true};
  std::thread thread_;
};

class RenderedDriver : public DriverBase {
 public:
  explicit RenderedDriver(OniDriverServices* services) : DriverBase(services) {
    std::strcpy(info_.uri, kUri);
    std::strcpy(info_.vendor, "edge_mcl");
    std::strcpy(info_.name, "rendered flight");
  }
  OniStatus initialize(DeviceConnectedCallback connected, DeviceDisconnectedCallback disconnected,
                       DeviceStateChangedCallback changed, void* cookie) override {
    DriverBase::initialize(connected, disconnected, changed, cookie);
    if (isPlugged()) {
      plugged_ = true;
      deviceConnected(&info_);
    }
    watcher_ = std::thread([this] { watch(); });
    return ONI_STATUS_OK;
  }
  DeviceBase* deviceOpen(const char* uri, const char*) override {
    return std::string(uri) == kUri && plugged_ ? new RenderedDevice() : nullptr;
  }
  void deviceClose(DeviceBase* device) override { delete device; }
  void shutdown() override {
    running_ = false;
    if (watcher_.joinable()) watcher_.join();
  }

 private:
  static bool isPlugged() { return std::filesystem::exists(setting("EDGE_MCL_DRIVER_PLUGGED")); }
  void watch() {
    while (running_) {
      const bool plugged = isPlugged();
      if (plugged != plugged_) {
        plugged_ = plugged;
        if (plugged)
          deviceConnected(&info_);
        else
          deviceDisconnected(&info_);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  OniDeviceInfo info_{};
  std::atomic<bool> plugged_{false}, running_{true};
  std::thread watcher_;
};

}  // namespace

ONI_EXPORT_DRIVER(RenderedDriver)
