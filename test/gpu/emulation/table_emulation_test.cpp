#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <list>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/image/edge_field.h"
#include "edge_mcl/core/likelihood/picture.h"
#include "edge_mcl/gpu/backend/conversion.h"
#include "edge_mcl/gpu/emulation/table_emulation.h"
#include "support/scenes.h"

#ifdef EDGE_MCL_HAS_CUDA
#include "edge_mcl/gpu/engine/engine.h"
#endif

namespace edge_mcl {
namespace {

/// Picture number `kind`: a room, ellipses, noise, or an even surface. Some sizes do not fill the
/// last block of threads.
cv::Mat picture(int kind, cv::Size size) {
  cv::Mat image(size, CV_8U, cv::Scalar(90));
  cv::RNG random(7 + kind);
  if (kind == 0)
    cv::resize(test::render(test::furnishedRooms(), test::pinhole(320, 240, 220),
                            test::lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15}), 1),
               image, size);
  if (kind == 1)
    for (int i = 0; i < 60; ++i)
      cv::ellipse(image, {random.uniform(0, size.width), random.uniform(0, size.height)},
                  {random.uniform(2, 60), random.uniform(2, 40)}, random.uniform(0, 180), 0, 360,
                  cv::Scalar(random.uniform(0, 256)), random.uniform(1, 4));
  if (kind == 2) random.fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

struct Setting {
  const char* name;
  void (*set)(Parameters*);
  bool masked;
};
const Setting kSettings[] = {
    {"defaults", [](Parameters*) {}, false},
    {"mask", [](Parameters*) {}, true},
    {"one threshold", [](Parameters* p) { p->image.contrast_window = 0; }, true},
    {"small tiles", [](Parameters* p) { p->image.contrast_window = 24; }, false},
    {"paper", [](Parameters* p) { p->likelihood.model = LikelihoodModel::kPaper; }, true},
    {"no blur, few bins",
     [](Parameters* p) {
       p->image.blur_sigma = 0;
       p->image.orientation_bins = 5;
       p->image.edge_share = 0.9;
     },
     false},
    {"wide",
     [](Parameters* p) {
       p->image.blur_sigma = 2.5;
       p->image.orientation_bins = 32;
       p->image.orientation_tolerance_deg = 40;
       p->image.search_length = 90;
       p->image.clutter_window = 8;
       p->image.hysteresis = 1;
     },
     true},
};

/// The truth is the table of the host. Every element must be equal, so every choice, rounding and
/// comparison on the way must be equal.
void expectSameTable(const std::function<std::vector<gpu::Quad>(const gpu::TableRecipe&,
                                                                const gpu::PictureData&)>& make) {
  for (const Setting& setting : kSettings)
    for (const cv::Size size :
         {cv::Size(320, 240), cv::Size(203, 131), cv::Size(9, 30), cv::Size(1, 40), cv::Size(2, 2)})
      for (int kind = 0; kind < 4; ++kind) {
        SCOPED_TRACE(std::string(setting.name) + ", picture " + std::to_string(kind) + ", width " +
                     std::to_string(size.width));
        Parameters params;
        setting.set(&params);
        cv::Mat mask;
        if (setting.masked) {
          mask = cv::Mat::zeros(size, CV_8U);
          mask(cv::Rect(size.width / 4, size.height / 3, size.width / 3, size.height / 5)) = 255;
        }
        const Picture made(picture(kind, size), ignoredPixels(mask, size, params.image, "test"),
                           params.image,
                           std::make_shared<ScoreLevels>(params.image, params.likelihood));
        ASSERT_TRUE(gpu::canMakeTables(params.image));
        const gpu::TableRecipe recipe =
            gpu::recipeOf(size.width, size.height, params.image, *made.levels());
        const std::vector<gpu::Quad> quads = make(recipe, gpu::dataOf(made));
        const ScoreTable& t = *made.table();
        ASSERT_EQ(quads.size(), static_cast<size_t>(t.bins()) * size.area());
        size_t differ = 0, i = 0;
        for (int b = 0; b < t.bins(); ++b)
          for (int y = 0; y < t.height(); ++y)
            for (int x = 0; x < t.width(); ++x, ++i) {
              const uint16_t* p =
                  t.pairs() + (static_cast<size_t>(b) * t.rows() + y) * t.stride() + x;
              differ += quads[i].top != (p[0] | static_cast<uint32_t>(p[1]) << 16);
              differ += quads[i].bottom !=
                        (p[t.stride()] | static_cast<uint32_t>(p[t.stride() + 1]) << 16);
            }
        EXPECT_EQ(differ, 0u);
      }
}

TEST(TableOnDevice, TheKernelBodiesOnTheHostMakeTheHostsTable) {
  expectSameTable([](const gpu::TableRecipe& recipe, const gpu::PictureData& data) {
    return gpu::emulateTable(recipe, data);
  });
}

TEST(TableOnDevice, TheDeviceMakesTheHostsTable) {
#ifdef EDGE_MCL_HAS_CUDA
  if (const std::string why = gpu::Engine::whyUnavailable(); !why.empty())
    GTEST_SKIP() << "SKIPPED: no CUDA device answers: " << why;
  gpu::Engine engine;
  std::list<gpu::TableRecipe> kept;  // the engine needs a recipe until its next call
  expectSameTable([&](const gpu::TableRecipe& recipe, const gpu::PictureData& data) {
    kept.push_back(recipe);
    engine.setPicture(0, {}, {}, kept.back(), data);
    return engine.table(0);
  });
#else
  GTEST_SKIP() << "SKIPPED: built without CUDA";
#endif
}

TEST(TableOnDevice, WhatItCannotDoIsKnown) {
  ImageParameters params;
  EXPECT_TRUE(gpu::canMakeTables(params));
  params.orientation_bins = 33;
  EXPECT_FALSE(gpu::canMakeTables(params));
  params = {};
  params.straight_segments = true;
  EXPECT_FALSE(gpu::canMakeTables(params));
  params = {};
  params.blur_sigma = 19;
  EXPECT_FALSE(gpu::canMakeTables(params));
}

TEST(Blur, WeightsAddUpAndHaveTheWidth) {
  for (const double sigma : {0.0, 0.5, 0.8, 1.0, 1.7, 3.0, 8.0, 19.0}) {
    const std::vector<int> weights = blurWeights(sigma);
    int sum = weights[0];
    double variance = 0;
    for (size_t i = 1; i < weights.size(); ++i) {
      EXPECT_GE(weights[i], 0);
      sum += 2 * weights[i];
      variance += 2.0 * weights[i] * static_cast<double>(i * i) / kBlurUnit;
    }
    EXPECT_EQ(sum, kBlurUnit);
    // The weights are rounded to 64 steps. So the tail of the Gaussian below half a step is
    // missing.
    EXPECT_NEAR(std::sqrt(variance), sigma, 0.05 + 0.06 * sigma) << sigma;
  }
}

}  // namespace
}  // namespace edge_mcl
