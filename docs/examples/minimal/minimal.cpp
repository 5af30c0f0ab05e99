// Localizes the images of a sequence with edge_mcl's MRPT filter class.
#include <mrpt/bayes/CParticleFilter.h>

#include <cstdio>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/mrpt_plugins/CEdgeMonteCarloLocalization3D.h"
#include "edge_mcl/mrpt_plugins/rawlog_export.h"

int main(int argc, char** argv) try {
  if (argc != 2) return std::fprintf(stderr, "usage: minimal SEQUENCE\n"), 2;
  const edge_mcl::Sequence sequence = edge_mcl::readSequence(argv[1]);
  const edge_mcl::Pose T_base_camera = edge_mcl::opticalOnBody();

  edge_mcl::Parameters params;
  params.filter.particles = 1000;
  auto map = std::make_shared<edge_mcl::CEdgeMap>(sequence.model_file, params);

  edge_mcl::PoseGaussian start;  // of the robot's base in the map
  start.mean = edge_mcl::startOf(sequence) * T_base_camera.inverse();
  start.covariance.diagonal() << 0.01, 0.01, 0.01, 0.003, 0.003, 0.003;
  edge_mcl::CEdgeMonteCarloLocalization3D filter(map);
  filter.initialize(start);

  mrpt::bayes::CParticleFilter particle_filter;
  const edge_mcl::SequenceFrame* last = &sequence.frames.front();
  for (const edge_mcl::SequenceFrame& frame : sequence.frames) {
    const auto action = edge_mcl::makeAction(*last, frame, T_base_camera, params.filter);
    const auto images = edge_mcl::makeSensoryFrame(sequence, frame, T_base_camera, true);
    particle_filter.executeOn(filter, action.get(), images.get());
    const auto [covariance, mean] = filter.getCovarianceAndMean();
    std::printf("%s %s\n", frame.time_text.c_str(), mean.asString().c_str());
    last = &frame;
  }
  return 0;
} catch (const edge_mcl::Error& e) {
  return std::fprintf(stderr, "minimal: %s\n", e.what()), 3;
}
