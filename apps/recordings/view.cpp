// edge-mcl view: localizes a recording and shows it in a window, as a video or as pictures.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>

#include "apps/progress_bar.h"
#include "apps/recordings/recording_options.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/heap_blocks.h"
#include "edge_mcl/viewer/moments/recorded_player.h"
#include "edge_mcl/viewer/output/view_recorder.h"
#include "edge_mcl/viewer/window/viewer_window.h"

namespace edge_mcl {

namespace {

struct ViewOptions : RecordingOptions {
  bool headless = false, loop = false;
  RecorderOptions recorder;
  size_t images = 0;
  std::string window_picture;
  std::vector<std::string> show;
  double close_after = 0;
};

ViewParameters parseShow(const ViewOptions& o) {
  ViewParameters params;
  for (const std::string& assignment : o.show) {
    const auto equals = assignment.find('=');
    if (equals == std::string::npos)
      throw ParameterError("--show " + assignment + ": must have the form name=value");
    params.set(assignment.substr(0, equals), assignment.substr(equals + 1));
  }
  params.validate();
  return params;
}

int runHeadless(const ViewOptions& o, const ViewParameters& params, const LocalizationMap& map,
                RecordedView* view) {
  if (o.recorder.video.empty() && o.recorder.pictures.empty())
    throw ParameterError("--headless needs --video FILE or --pictures BEGIN");
  ViewRecorder recorder(&map, params, o.recorder);
  const size_t count = o.images > 0 ? std::min(o.images, view->imageCount()) : view->imageCount();
  ProgressBar bar("view", count);
  ViewMoment moment;
  size_t shown = 0;
  bool found = false;
  for (; shown < count && view->next(&moment); ++shown) {
    recorder.show(moment);
    found = found || moment.has_pose;
    bar.advance();
  }
  recorder.close();
  std::printf("%s\n", recorder.summary().c_str());
  for (const std::string& file : recorder.written()) std::printf("%s\n", file.c_str());
  if (!found) std::fprintf(stderr, "warning: %s: no pose was found\n", o.recording.c_str());
  return found ? kExitOk : kExitIncomplete;
}

int run(const ViewOptions& o) {
  giveLargeBlocksBack();
  const ViewParameters params = parseShow(o);
  OpenedRecording opened = openRecording(o, true);
  auto view = std::make_unique<RecordedView>(opened.map, std::move(opened.input), opened.start,
                                             static_cast<size_t>(params.max_particles));
  if (o.headless) return runHeadless(o, params, *opened.map, view.get());
  RecordedPlayer player(std::move(view), o.loop);
  WindowReport report;
  try {
    ViewerWindow window(opened.map.get(), params, &player, "edge_mcl: " + opened.name);
    const auto begin = std::chrono::steady_clock::now();
    report = window.run(
        [&] {
          const std::chrono::duration<double> open = std::chrono::steady_clock::now() - begin;
          return o.close_after <= 0 || open.count() < o.close_after;
        },
        o.window_picture);
  } catch (const InputError&) {
    throw;
  } catch (const Error& e) {
    throw InputError(e.what());
  }
  if (o.close_after > 0) std::printf("%.1f frames drawn per second\n", report.rate());
  return kExitOk;
}

}  // namespace

void addView(CLI::App* app, Action* action) {
  auto o = std::make_shared<ViewOptions>();
  CLI::App* c = app->add_subcommand(
      "view", "localize a recording and show model, particles, camera image and figures");
  o->addTo(c);
  c->add_option("--show", o->show,
                "sets one parameter of the picture, e.g. --show model_style=ghost; can be given "
                "several times (see docs/parameters.md)");
  CLI::Option* headless =
      c->add_flag("--headless", o->headless, "open no window, but write a video or pictures");
  CLI::Option* video = c->add_option("--video", o->recorder.video,
                                     "video file to write, .mp4 or .avi; default: no video")
                           ->needs(headless);
  c->add_option("--video-rate", o->recorder.video_rate,
                "number of pictures per second of the video; default 10")
      ->needs(video);
  CLI::Option* pictures =
      c->add_option(
           "--pictures", o->recorder.pictures,
           "beginning of the names of pictures to write, BEGIN-1.png and so on; default: no "
           "pictures")
          ->needs(headless);
  c->add_option(
       "--at", o->recorder.at,
       "times of the pictures in seconds since the first image, e.g. --at 2,5,8; they must "
       "increase; default: one picture of the last moment")
      ->delimiter(',')
      ->needs(pictures);
  c->add_option("--images", o->images,
                "number of images after which the command stops; 0 (default): all images")
      ->needs(headless);
  c->add_flag("--loop", o->loop,
              "start again when the recording has ended; default: stop at its end")
      ->excludes(headless);
  c->add_option("--close-after", o->close_after,
                "time after which the window closes, s; the command then prints the frames drawn "
                "per second; 0 (default): the window stays open")
      ->excludes(headless);
  c->add_option("--window-picture", o->window_picture,
                "file for a picture of the window when it closes; default: none")
      ->excludes(headless);
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
