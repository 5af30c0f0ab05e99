// edge-mcl bag, edge-mcl rawlog: convert a sequence directory to a ROS bag or an MRPT rawlog.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <limits>
#include <memory>

#include "apps/common_options.h"
#include "apps/progress_bar.h"
#include "apps/recordings/recorder_choice.h"
#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

struct ConvertOptions {
  std::string ending;  // required ending of the output file: .bag or .rawlog
  std::string sequence, out, base = "body";
  bool no_mask = false;
  ParameterOptions parameters;
};

int run(const ConvertOptions& o) {
  const Parameters params = o.parameters.load();
  if (o.base != "body" && o.base != "optical")
    throw ParameterError("--base " + o.base + ": must be body or optical");
  const Pose T_base_camera = o.base == "body" ? opticalOnBody() : Pose(Pose::Identity());
  const Sequence sequence = readSequence(o.sequence);
  for (const std::string& w : sequence.warnings) std::fprintf(stderr, "warning: %s\n", w.c_str());
  const std::unique_ptr<Recorder> recorder =
      recorderForFile(o.out, setupOf(sequence, T_base_camera), params.filter);
  if (!recorder) throw InputError(o.out + ": the name must end in " + o.ending);
  ProgressBar bar("convert", sequence.frames.size());
  // Depth images are not written to a rawlog, so they are not read and may be broken.
  auto depth = o.ending == ".rawlog" ? sequence.depths.end() : sequence.depths.begin();
  size_t left_out = 0;
  const auto leaveOut = [&](const InputError& e) {
    bar.note(std::string("warning: ") + e.what() + "; this image is left out");
    ++left_out;
  };
  // Depth images have their own time stamps, so they are written between the colour images.
  const auto writeDepthUntil = [&](double time) {
    for (; depth != sequence.depths.end() && depth->time <= time; ++depth) {
      cv::Mat image;
      try {
        image = readDepth(depth->file, sequence.camera);
      } catch (const InputError& e) {
        leaveOut(e);
        continue;
      }
      recorder->writeDepth(depth->time, image);
    }
  };
  for (const SequenceFrame& frame : sequence.frames) {
    bar.advance();
    RecordedFrame loaded;
    try {
      loaded = loadFrame(sequence, frame);
    } catch (const InputError& e) {
      leaveOut(e);
      continue;
    }
    if (o.no_mask) loaded.mask.release();
    recorder->write(loaded);
    writeDepthUntil(frame.time);
  }
  writeDepthUntil(std::numeric_limits<double>::infinity());
  recorder->close();
  std::printf("%s: wrote %zu images of %s, base frame: %s\n", o.out.c_str(), recorder->count(),
              sequence.name.c_str(), o.base.c_str());
  constexpr double kEarliestOfRos = 1;  // s
  if (o.ending == ".bag" && sequence.frames.front().time < kEarliestOfRos)
    std::printf("all times are shifted by 1 s, because ROS has no time before 1 s\n");
  return left_out == 0 ? kExitOk : kExitIncomplete;
}

void add(CLI::App* app, Action* action, const char* name, const char* ending,
         const char* description) {
  auto o = std::make_shared<ConvertOptions>();
  o->ending = ending;
  CLI::App* c = app->add_subcommand(name, description);
  c->add_option("sequence", o->sequence, "sequence directory (see docs/sequences.md)")->required();
  c->add_option("out", o->out, std::string("file to write, with the ending ") + ending)->required();
  c->add_option("--base", o->base,
                "frame of the robot: body (default; x forward, z up, the camera looks along x) or "
                "optical (x right, y down, z forward)");
  c->add_flag("--no-mask", o->no_mask,
              "write no masks; default: the masks of the sequence are written");
  o->parameters.addTo(c);
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace

void addBag(CLI::App* app, Action* action) {
  add(app, action, "bag", ".bag",
      "convert a sequence directory to a ROS bag with images, camera_info, depth, masks, tf, "
      "odometry and ground truth");
}

void addRawlog(CLI::App* app, Action* action) {
  add(app, action, "rawlog", ".rawlog",
      "convert a sequence directory to an MRPT rawlog with actions (odometry), images with masks, "
      "and ground truth");
}

}  // namespace edge_mcl
