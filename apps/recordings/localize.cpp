// edge-mcl localize: a recording and a model in, a trajectory with covariance out.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/common_options.h"
#include "apps/output_files.h"
#include "apps/progress_bar.h"
#include "apps/recordings/localize_report.h"
#include "apps/recordings/recording_options.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/drawing/overlay.h"
#include "edge_mcl/core/drawing/trajectory_plot.h"
#include "edge_mcl/core/image/picture_file.h"
#include "edge_mcl/localization/recorded/recorded_localizer.h"

namespace edge_mcl {

namespace {

struct LocalizeOptions : RecordingOptions {
  std::string out = "est.txt", stats, overlay, plot, masks_out;
  bool json = false;
};

/// A directory has names for its times, which join files of one moment. Other recordings have
/// numbers only.
std::string timeTextOf(const LiveInput& input) {
  if (!input.time_text.empty()) return input.time_text;
  char text[32];
  std::snprintf(text, sizeof text, "%.6f", input.time);
  return text;
}

void writeOverlay(const LocalizeOptions& o, const RecordedLocalizer& localizer,
                  const std::string& time_text) {
  const LiveResult& r = localizer.result();
  if (o.overlay.empty() || r.images.empty() || !localizer.localizer().isInitialized()) return;
  const Pose T_map_camera =
      r.estimate.mean * localizer.input().images[r.image_numbers.front()].T_base_camera;
  writePicture(o.overlay + "/" + time_text + ".png",
               drawOverlay(localizer.localizer().map(), *r.images.front(), T_map_camera));
}

/// Writes the masks that were used, in the form that `--masks` reads.
class MaskWriter {
 public:
  /// @throws ParameterError when masks that are read would be overwritten. InputError
  explicit MaskWriter(const LocalizeOptions& o) : folder_(o.masks_out) {
    const std::string& folder = folder_;
    if (folder.empty()) return;
    std::error_code ignored;
    for (const std::string& read : {o.recording, o.masks})
      for (const char* part : {"", "/mask", "/mask.txt"})
        if (!read.empty() && std::filesystem::equivalent(folder + part, read + part, ignored))
          throw ParameterError("--masks-out " + folder + ": would overwrite masks that are read");
    makeDirectory(folder + "/mask");
    list_.open(folder + "/mask.txt");
    list_ << "# masks used by edge-mcl localize, with their margin: timestamp filename"
          << std::endl;
    if (!list_) throw InputError(folder + "/mask.txt: cannot be written");
  }
  void write(const LiveResult& result, const std::string& time_text) {
    if (folder_.empty() || result.images.empty()) return;
    const EdgeImage& edges = result.images.front()->edges;
    const cv::Mat mask =
        edges.ignore.empty() ? cv::Mat::zeros(edges.grey.size(), CV_8U) : edges.ignore;
    writePicture(folder_ + "/mask/" + time_text + ".png", mask);
    list_ << time_text << " mask/" << time_text << ".png" << std::endl;
  }

 private:
  const std::string folder_;
  std::ofstream list_;
};

/// Localizes every moment. Each pose is written at once, so that an interrupted run keeps what it
/// has computed.
void localizeAll(const LocalizeOptions& o, const OpenedRecording& opened,
                 RecordedLocalizer* localizer, LocalizeReport* report) {
  std::ofstream out(o.out);
  if (!out) throw InputError(o.out + ": cannot be written");
  const bool is_euroc = std::filesystem::path(o.out).extension() == ".csv";
  if (is_euroc)
    out << kEurocColumns << '\n';
  else
    out << "# " << opened.trajectory_pose
        << " by edge-mcl localize: timestamp tx ty tz qx qy qz qw\n";
  if (!o.overlay.empty()) makeDirectory(o.overlay);
  MaskWriter masks(o);
  std::string last_problem;
  ProgressBar bar(opened.name, localizer->recording().imageCount());
  while (localizer->next()) {
    bar.advance();
    const LiveResult& r = localizer->result();
    const std::string time_text = timeTextOf(localizer->input());
    if (!r.problem.empty() && r.problem != last_problem) bar.note("warning: " + r.problem);
    last_problem = r.problem;
    if (r.relocalized) bar.note("found the pose at " + time_text);
    report->add(*localizer, time_text);
    if (r.late) continue;
    // While there is no pose, no line is written.
    if (localizer->localizer().isInitialized()) {
      Pose pose = r.estimate.mean;
      pose.translation() += opened.origin;
      out << (is_euroc ? formatEurocPose : formatPose)(time_text, pose) << std::endl;
    }
    if (!out) throw InputError(o.out + ": cannot be written (disk full?)");
    writeOverlay(o, *localizer, time_text);
    masks.write(r, time_text);
  }
}

int run(const LocalizeOptions& o) {
  for (const std::string& file : {o.out, o.stats}) checkOutput(file);
  checkPicture(o.plot);
  OpenedRecording opened = openRecording(o, false);
  RecordedLocalizer localizer(opened.map, std::move(opened.input), opened.start);
  LocalizeReport report;
  localizeAll(o, opened, &localizer, &report);
  const nlohmann::json summary = report.summary(opened, localizer.recording());
  if (!o.stats.empty()) writeJson(o.stats, {{"summary", summary}, {"images", report.images()}});
  if (o.json)
    std::printf("%s\n", textOf(summary).c_str());
  else
    std::printf("%strajectory (%s): %s\n", textOfSummary(summary).c_str(),
                opened.trajectory_pose.c_str(), o.out.c_str());
  if (!o.plot.empty())
    writePicture(o.plot, drawTrajectories(report.estimate(), localizer.recording().truth()));
  const std::string damage = localizer.recording().damage();
  // A directory without odometry.txt is meant to have none. In a bag a topic may have another name.
  if (!report.hasOdometry() && kindOf(o.recording) != RecordingKind::kDirectory)
    std::fprintf(stderr, "warning: %s: no odometry for any image; steady motion is assumed\n",
                 opened.name.c_str());
  if (report.estimate().empty())
    std::fprintf(stderr, "warning: %s: no pose was found; the trajectory is empty\n",
                 opened.name.c_str());
  const bool complete =
      report.unusableImages() == 0 && !report.estimate().empty() && damage.empty();
  return complete ? kExitOk : kExitIncomplete;
}

}  // namespace

void addLocalize(CLI::App* app, Action* action) {
  auto o = std::make_shared<LocalizeOptions>();
  CLI::App* c = app->add_subcommand(
      "localize", "localize a recorded sequence, a ROS bag or a rawlog in its 3D model");
  o->addTo(c);
  c->add_option(
      "--out", o->out,
      "trajectory to write: in TUM's format, or as FILE.csv in EuRoC's; default: est.txt");
  c->add_option("--stats", o->stats, "JSON file with states, times and covariance per image");
  c->add_option("--overlay", o->overlay,
                "directory for pictures: model edges green, image edges blue, normals red");
  c->add_option("--masks-out", o->masks_out,
                "directory for mask.txt and the folder mask/: the masks that were used");
  c->add_option("--plot", o->plot, "picture of the trajectory");
  c->add_flag("--json", o->json, "print the summary as JSON");
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
