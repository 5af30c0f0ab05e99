// edge-mcl rawlog: a sequence as an MRPT rawlog.
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/serialization/CArchive.h>

#include <cstdio>
#include <memory>

#include "common_options.h"
#include "edge_mcl/core/error.h"
#include "edge_mcl/mrpt_plugins/rawlog_export.h"
#include "progress_bar.h"

namespace edge_mcl {

namespace {

struct RawlogOptions {
  std::string sequence, out, base = "body";
  bool no_mask = false;
  ParameterOptions parameters;
};

int run(const RawlogOptions& o) {
  const Parameters params = o.parameters.load();
  if (o.base != "body" && o.base != "optical")
    throw ParameterError("--base " + o.base + ": body or optical expected");
  const Pose T_base_camera = o.base == "body" ? opticalOnBody() : Pose(Pose::Identity());
  const Sequence sequence = readSequence(o.sequence);
  for (const std::string& w : sequence.warnings) std::fprintf(stderr, "warning: %s\n", w.c_str());
  mrpt::io::CFileGZOutputStream file;
  if (!file.open(o.out)) throw InputError(o.out + ": cannot be written");
  auto archive = mrpt::serialization::archiveFrom(file);
  size_t written = 0;
  const SequenceFrame* last = nullptr;
  ProgressBar bar("rawlog", sequence.frames.size());
  for (const SequenceFrame& frame : sequence.frames) {
    bar.advance();
    mrpt::obs::CSensoryFrame::Ptr sensory_frame;
    try {
      sensory_frame = makeSensoryFrame(sequence, frame, T_base_camera, !o.no_mask);
    } catch (const InputError& e) {
      bar.note(std::string("warning: ") + e.what() + ", left out");
      continue;
    }
    // MRPT expects pairs: the motion that led here, then what was seen.
    archive << *makeAction(last ? *last : frame, frame, T_base_camera, params.filter)
            << *sensory_frame;
    last = &frame;
    ++written;
  }
  std::printf("%s: %zu images of %s, base frame: %s\n", o.out.c_str(), written,
              sequence.name.c_str(), o.base.c_str());
  return written == sequence.frames.size() ? kExitOk : kExitIncomplete;
}

}  // namespace

void addRawlog(CLI::App* app, Action* action) {
  auto o = std::make_shared<RawlogOptions>();
  CLI::App* c = app->add_subcommand(
      "rawlog", "write a sequence as an MRPT rawlog: actions, images with masks, ground truth");
  c->add_option("sequence", o->sequence, "sequence directory")->required();
  c->add_option("out", o->out, "rawlog to write")->required();
  c->add_option("--base", o->base,
                "robot frame: body (x forward, z up; the camera looks along x) or optical");
  c->add_flag("--no-mask", o->no_mask, "leave the masks out");
  o->parameters.addTo(c);
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
