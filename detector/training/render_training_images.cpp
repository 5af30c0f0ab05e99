/// Renders training images OUT/NUMBER.jpg with their labels OUT/NUMBER.png. Image k of a seed is
/// always the same, so that an interrupted run continues where it stopped.
#include <tbb/parallel_for.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <filesystem>
#include <iostream>
#include <mutex>
#include <opencv2/imgcodecs.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/picture_file.h"
#include "edge_mcl/detector/training/training_view.h"

namespace {

namespace fs = std::filesystem;
using namespace edge_mcl;

constexpr int kViewsPerRoom = 4;

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Renders images of random rooms with labels of the movable objects in them.");
  std::string objects_directory, split = "train", out;
  size_t count = 16;
  uint64_t seed = 1;
  int width = 320, height = 240;
  app.add_option("objects", objects_directory, "folder that objects.py made")->required();
  app.add_option("out", out, "directory for the images")->required();
  app.add_option("--split", split, "train or test: the objects of this split are used")
      ->check(CLI::IsMember({"train", "test"}));
  app.add_option("--count", count, "number of images")->capture_default_str();
  app.add_option("--seed", seed, "seed of the rooms")->capture_default_str();
  app.add_option("--width", width)->capture_default_str()->check(CLI::Range(16, 4096));
  app.add_option("--height", height)->capture_default_str()->check(CLI::Range(16, 4096));
  CLI11_PARSE(app, argc, argv);
  try {
    fs::create_directories(out);
    const TrainingObjects objects(objects_directory, split);
    std::atomic<size_t> done{0};
    std::mutex output;
    const size_t rooms = (count + kViewsPerRoom - 1) / kViewsPerRoom;
    tbb::parallel_for(size_t{0}, rooms, [&](size_t k) {
      const auto fileOf = [&](size_t view, const char* extension) {
        char name[32];
        std::snprintf(name, sizeof name, "%06zu%s", k * kViewsPerRoom + view, extension);
        return fs::path(out) / name;
      };
      if (!fs::exists(fileOf(kViewsPerRoom - 1, ".png"))) {
        std::seed_seq seeds{static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32),
                            static_cast<uint32_t>(k), split == "test" ? 1u : 0u};
        TrainingRandom random(seeds);
        const TrainingRoom room = randomRoom(random, objects);
        const TrainingView view(room, objects.device());
        for (size_t i = 0; i < kViewsPerRoom; ++i) {
          const TrainingImage image = view.take(random, width, height);
          writePicture(fileOf(i, ".jpg"), image.color, {cv::IMWRITE_JPEG_QUALITY, 94});
          writePicture(fileOf(i, ".png"), image.label, {});
        }
      }
      const size_t now = done += kViewsPerRoom;
      if (now % 200 < kViewsPerRoom) {
        const std::lock_guard<std::mutex> lock(output);
        std::cerr << '\r' << std::min(now, count) << " of " << count << " images" << std::flush;
      }
    });
    std::cerr << '\n';
  } catch (const std::exception& e) {
    std::cerr << "edge_mcl_training_images: " << e.what() << '\n';
    return 1;
  }
  return 0;
}
