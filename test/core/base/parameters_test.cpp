#include "edge_mcl/core/base/parameters.h"

#include <gtest/gtest.h>

#include <fstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_struct.h"

namespace edge_mcl {
namespace {

std::string messageOf(const std::function<void()>& f) {
  try {
    f();
  } catch (const ParameterError& e) {
    return e.what();
  }
  return "";
}

TEST(Parameters, DefaultsAreLegalAndDescribed) {
  const Parameters params;
  params.validate();
  for (const ParameterDescription& d : describeParameters(params))
    EXPECT_FALSE(d.text.empty()) << d.name;
}

TEST(Parameters, AnUnknownNameNamesTheNearestOne) {
  Parameters params;
  const std::string text = messageOf([&] { params.set("likelihood.sigm", "3"); });
  EXPECT_NE(text.find("likelihood.sigma"), std::string::npos) << text;
}

TEST(Parameters, WhatWouldStopTheFilterOrTheSearchIsRefused) {
  Parameters params;
  // With a window of one keyframe no earlier keyframe is left to follow hypotheses from.
  params.search.min_keyframes = params.search.window = 1;
  EXPECT_NE(messageOf([&] { params.validate(); }).find("search.window"), std::string::npos);
  params.search.window = 2;
  // With refinement, particles are resampled after every image, so every threshold is legal.
  // Without refinement, tempering leaves ESS/N at filter.ess_floor. With a threshold below it,
  // particles would never be resampled.
  params.filter.resample_threshold = 0.05;
  params.validate();
  params.refinement.enabled = false;
  EXPECT_NE(messageOf([&] { params.validate(); }).find("filter.resample_threshold"),
            std::string::npos);
}

TEST(Parameters, ValidateListsAllFaultsAtOnce) {
  Parameters params;
  params.likelihood.sigma = -1;
  params.filter.particles = 0;
  params.image.edge_share = 2;
  const std::string text = messageOf([&] { params.validate(); });
  for (const char* name : {"likelihood.sigma", "filter.particles", "image.edge_share"})
    EXPECT_NE(text.find(name), std::string::npos) << text;
}

/// Printed parameters are read back without change. The faults of a file name the parameters.
TEST(Parameters, YamlRoundTripAndErrors) {
  const std::string file = testing::TempDir() + "params.yaml";
  Parameters params;
  params.likelihood.model = LikelihoodModel::kPaper;
  params.filter.seed = 12345678901234ull;
  params.map.scale = 0.001;
  std::ofstream(file) << params.toYaml();
  Parameters read;
  read.loadYaml(file);
  EXPECT_EQ(read.toYaml(), params.toYaml());
  std::ofstream(file) << "likelihood: {sigma: big, kk: 3}\nfilter: {seed: -1}\n";
  const std::string text = messageOf([&] { read.loadYaml(file); });
  for (const char* part : {"likelihood.sigma", "likelihood.kk", "filter.seed"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
  EXPECT_THROW(read.loadYaml("/does/not/exist.yaml"), InputError);
}

}  // namespace
}  // namespace edge_mcl
