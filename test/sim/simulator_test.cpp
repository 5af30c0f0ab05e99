#include "edge_mcl/sim/simulator.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/mesh_loader.h"
#include "edge_mcl/core/recordings/sequence.h"
#include "edge_mcl/localization/recorded/recorded_localizer.h"
#include "edge_mcl/localization/recorded/sequence_input.h"
#include "edge_mcl/sim/random_flight.h"
#include "edge_mcl/sim/sequence_writer.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

namespace fs = std::filesystem;

const std::string kMaps = EDGE_MCL_MAPS;

std::string contentOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class SimulatorTest : public testing::Test {
 protected:
  fs::path folder_ =
      fs::temp_directory_path() / ("edge_mcl_sim_" + std::to_string(getpid()) + "_" +
                                   testing::UnitTest::GetInstance()->current_test_info()->name());
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Writes the scenario of a flight through the office with a small camera. @return its file
  std::string scenario(const std::string& more = "",
                       const std::string& path =
                           "path:\n"
                           "  - {time: 0, position: [1.0, 1.2, 1.3], yaw_deg: 35}\n"
                           "  - {time: 1, position: [1.5, 1.5, 1.4], yaw_deg: 50}\n"
                           "  - {time: 2, position: [2.2, 1.5, 1.4], yaw_deg: 65}\n") {
    std::ofstream(folder_ / "camera.yaml")
        << "image_width: 320\nimage_height: 240\ncamera_matrix: {rows: 3, cols: 3, data: [215, 0, "
           "161, 0, 215, 119, 0, 0, 1]}\ndistortion_model: plumb_bob\ndistortion_coefficients: "
           "{rows: 1, cols: 5, data: [-0.12, 0.03, 0.0004, -0.0003, 0]}\n";
    std::ofstream(folder_ / "flight.yaml")
        << "model: " << fs::relative(kMaps + "/office.obj", folder_).string()
        << "\ncamera: camera.yaml\nrate: 15\n"
        << path << "objects:\n  - name: person\n    model: "
        << fs::relative(kMaps + "/objects/person.obj", folder_).string()
        << "\n    path:\n      - {time: 0, position: [2.0, 4.6, 0]}\n"
           "      - {time: 2, position: [3.4, 4.4, 0]}\n"
        << more;
    return (folder_ / "flight.yaml").string();
  }

  std::string record(const std::string& file, const std::string& name, size_t images,
                     uint64_t seed = 1) {
    Scenario s = Scenario::fromYamlFile(file);
    s.seed = seed;
    Simulator simulator(s);
    std::string out = (folder_ / name).string();
    SequenceWriter writer(out, simulator.setup(), s.model_file, simulator.notes());
    writer.writeImu(simulateImu(s.path, s.imu, s.seed));
    for (size_t i = 0; i < std::min(images, simulator.imageCount()); ++i) {
      RecordedFrame frame;
      if (simulator.next(&frame)) writer.write(frame);
    }
    return out;
  }
};

/// Two recordings with one seed must be equal in every byte. Another seed gives other images.
TEST_F(SimulatorTest, SameSeedSameBytes) {
  const std::string file = scenario("faults: {noise: 3, exposure_swing: 0.2, dropped: 0.3}\n");
  const fs::path a = record(file, "a", 6), b = record(file, "b", 6), c = record(file, "c", 6, 2);
  int files = 0, differ = 0;
  for (const auto& entry : fs::recursive_directory_iterator(a)) {
    if (!entry.is_regular_file()) continue;
    const fs::path name = fs::relative(entry.path(), a);
    if (name == "sequence.yaml") continue;  // holds the name of the directory
    ++files;
    EXPECT_EQ(contentOf(a / name), contentOf(b / name)) << name;
    differ += contentOf(a / name) != contentOf(c / name);
  }
  EXPECT_GT(files, 10);
  EXPECT_GT(differ, 5);
}

/// The truth is the recorded ground truth.
TEST_F(SimulatorTest, WhatItWritesIsASequenceAndIsTracked) {
  const std::string out = record(scenario(), "out", 100);
  const Sequence sequence = readSequence(out);
  ASSERT_EQ(sequence.frames.size(), 31u);
  ASSERT_TRUE(sequence.has_odometry);
  Parameters params;
  params.filter.particles = 300;
  auto input = std::make_unique<SequenceInput>(sequence, SequenceParts());
  const RecordedStart start{input->initialPose(), std::nullopt};
  RecordedLocalizer localizer(std::make_shared<LocalizationMap>(sequence.model_file, params),
                              std::move(input), start);
  double worst = 0;
  for (const SequenceFrame& frame : sequence.frames) {
    ASSERT_TRUE(localizer.next());
    const LiveResult& r = localizer.result();
    EXPECT_TRUE(r.updated) << r.problem;
    ASSERT_TRUE(frame.ground_truth && !frame.mask_file.empty());
    worst =
        std::max(worst, (r.estimate.mean.translation() - frame.ground_truth->translation()).norm());
  }
  // Median errors are some millimetres. A wrong frame or time stamp would cost decimetres.
  EXPECT_LT(worst, 0.10);
}

/// The recording holds the model as OBJ. It must be the same building with the same edges, in every
/// format of the original.
TEST_F(SimulatorTest, TheMapOfARecordingIsTheModel) {
  const Scenario s = Scenario::fromYamlFile(scenario());
  for (const char* name : {"office.obj", "office.dae"}) {
    const std::string out = (folder_ / name).string() + "_recorded";
    const SequenceWriter writer(out, Simulator(s).setup(), kMaps + "/" + name, {});
    MeshModel original = loadMesh(kMaps + "/" + name, {}), copy = loadMesh(out + "/model.obj", {});
    EXPECT_EQ(original.triangles.size(), copy.triangles.size());
    const EdgeModel a = buildEdgeModel(&original, {}), b = buildEdgeModel(&copy, {});
    EXPECT_EQ(a.countOf(EdgeKind::kCrease), b.countOf(EdgeKind::kCrease));
    EXPECT_EQ(a.countOf(EdgeKind::kMaterial), b.countOf(EdgeKind::kMaterial));
    EXPECT_NEAR(a.feature_length, b.feature_length, 1e-3);
  }
}

/// Noise and blur change the colour image. Depth and mask stay as they are.
TEST_F(SimulatorTest, FaultsSpoilTheImageAlone) {
  Scenario clean = Scenario::fromYamlFile(scenario()), faulty = clean;
  clean.faults.noise = 0;
  faulty.faults.noise = 6;
  RecordedFrame a, b;
  Simulator(clean).next(&a);
  Simulator(faulty).next(&b);
  EXPECT_EQ(cv::countNonZero(a.mask != b.mask), 0);
  EXPECT_EQ(cv::countNonZero(a.depth != b.depth), 0);
  double sum = 0, squares = 0;
  int n = 0;
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      const int value = a.color.at<cv::Vec3b>(y, x)[1];
      if (value < 40 || value > 215) continue;  // only values that noise does not clip
      const double d = b.color.at<cv::Vec3b>(y, x)[1] - value;
      sum += d;
      squares += d * d;
      ++n;
    }
  EXPECT_NEAR(sum / n, 0, 0.15);                 // five times 6 / sqrt(50,000)
  EXPECT_NEAR(std::sqrt(squares / n), 6, 0.15);  // rounding adds a variance of 1/12
  Scenario blurred = clean;
  blurred.faults.exposure_time = 0.1;
  RecordedFrame c;
  Simulator moving(blurred);
  moving.next(&c);
  moving.next(&c);
  Simulator sharp(clean);
  sharp.next(&a);
  sharp.next(&a);
  EXPECT_EQ(cv::countNonZero(a.depth != c.depth), 0);
  EXPECT_GT(cv::norm(a.color, c.color, cv::NORM_L1), 1e5);
}

/// The recorder takes images by next(), the node by take(). Both must be equal.
TEST_F(SimulatorTest, APathIsBlurredAlikeHoweverItIsTaken) {
  Scenario s = Scenario::fromYamlFile(scenario());
  s.faults.noise = 0;
  s.faults.exposure_time = 0.1;
  Simulator recorder(s), node(s), at_rest(s);
  const auto cameraAt = [&](double time) { return s.cameraAt(time); };
  RecordedFrame a, b, c;
  for (size_t i = 0; i < 2; ++i) {
    recorder.next(&a);
    node.take(a.time, cameraAt, true, &b);
    at_rest.take(a.time, s.cameraAt(a.time), true, &c);
  }
  EXPECT_EQ(cv::norm(a.color, b.color, cv::NORM_L1), 0);
  EXPECT_EQ(cv::norm(a.depth, b.depth, cv::NORM_L1), 0);
  EXPECT_TRUE(a.odometry->isApprox(*b.odometry, 1e-12));
  EXPECT_GT(cv::norm(a.color, c.color, cv::NORM_L1), 1e5);
}

/// Between two images the path goes through the door. The straight line between them crosses the
/// wall.
TEST_F(SimulatorTest, FewImagesDoNotCutCorners) {
  const std::string through_the_door =
      "path:\n"
      "  - {time: 0, position: [5.4, 4.6, 1.4]}\n"
      "  - {time: 2, position: [5.4, 2.9, 1.4]}\n"
      "  - {time: 4, position: [6.6, 2.9, 1.4]}\n"
      "  - {time: 6, position: [6.6, 4.6, 1.4]}\n";
  Scenario s = Scenario::fromYamlFile(scenario("clearance: 0\n", through_the_door));
  EXPECT_NO_THROW(Simulator{s});
  s.rate = 1.0 / 6;
  EXPECT_NO_THROW(Simulator{s});
}

TEST_F(SimulatorTest, DroppedImagesAreAboutAsManyAsAskedFor) {
  Scenario s = Scenario::fromYamlFile(scenario());
  s.rate = 200;
  s.camera.width = s.camera.height = 16;
  s.camera.validate("tiny");
  s.faults.dropped = 0.25;
  Simulator simulator(s);
  int dropped = 0;
  for (size_t i = 0; i < simulator.imageCount(); ++i) {
    RecordedFrame frame;
    dropped += !simulator.next(&frame);
  }
  EXPECT_NEAR(dropped / 401.0, 0.25, 0.09);  // four standard deviations of 401 images
}

TEST_F(SimulatorTest, BadScenariosAreOneClearLine) {
  const auto messageOf = [&](const std::string& file) -> std::string {
    try {
      Simulator simulator(Scenario::fromYamlFile(file));
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos && text.find('\n') == std::string::npos;
  };
  EXPECT_TRUE(has(messageOf(scenario("ratte: 3\n")), "unknown key 'ratte' (did you mean 'rate'?)"));
  EXPECT_TRUE(has(messageOf(scenario("faults: {noise: -1}\n")), "noise must be between"));
  EXPECT_TRUE(has(messageOf(scenario("faults: {noise: loud}\n")), "wrong type"));
  EXPECT_TRUE(has(messageOf(scenario("", "")), "neither 'path' nor 'trajectory' nor 'random'"));
  EXPECT_TRUE(has(messageOf(scenario("", "path:\n  - {time: 0, position: [1, 1, 1]}\n")),
                  "at least two points"));
  EXPECT_TRUE(has(messageOf(scenario("",
                                     "path:\n  - {time: 0, position: [1, 1, 1.4]}\n"
                                     "  - {time: 2, position: [9, 1, 1.4]}\n")),
                  "the path "));
  EXPECT_TRUE(has(messageOf(scenario("clearance: 0\n",
                                     "path:\n  - {time: 0, position: [5, 1.2, 1.4]}\n"
                                     "  - {time: 2, position: [7, 1.2, 1.4]}\n")),
                  "leads through the building at 0.97 s"));
  for (const char* key : {"position", "angle_deg", "per_metre", "per_radian"})
    for (const char* value : {".nan", ".inf", "-0.1"})
      EXPECT_TRUE(has(messageOf(scenario("odometry: {" + std::string(key) + ": " + value + "}\n")),
                      "odometry: " + std::string(key) + " must be between"))
          << key << value;
  for (const char* key : {"accelerometer", "gyroscope", "accelerometer_walk", "gyroscope_walk"})
    EXPECT_TRUE(has(messageOf(scenario("imu: {" + std::string(key) + ": .nan}\n")),
                    "imu: " + std::string(key) + " must be between"))
        << key;
  EXPECT_TRUE(has(messageOf((folder_ / "missing.yaml").string()), "cannot be read"));
  std::ofstream(folder_ / "broken.yaml") << "model: [unclosed\n";
  EXPECT_NE(messageOf((folder_ / "broken.yaml").string()), "");
}

/// Each file of a sequence that exists already stops the recording, and nothing is written.
TEST_F(SimulatorTest, NothingOfAUserIsOverwritten) {
  const Scenario s = Scenario::fromYamlFile(scenario());
  const Simulator simulator(s);
  const fs::path out = folder_ / "mine";
  for (const char* name : {"rgb.txt", "depth.txt", "mask.txt", "groundtruth.txt", "odometry.txt",
                           "imu.txt", "model.obj", "camera.yaml", "sequence.yaml"}) {
    fs::remove_all(out);
    fs::create_directories(out);
    std::ofstream(out / name) << "mine";
    EXPECT_THROW(SequenceWriter(out.string(), simulator.setup(), s.model_file, {}), InputError)
        << name;
    EXPECT_EQ(contentOf(out / name), "mine");
    EXPECT_EQ(std::distance(fs::directory_iterator(out), fs::directory_iterator()), 1) << name;
  }
}

TEST_F(SimulatorTest, ARecordingIsCalledAsItsDirectory) {
  const Scenario s = Scenario::fromYamlFile(scenario());
  for (const std::string name : {"plain", "a: 'b' #1", "[12"}) {
    const std::string out = (folder_ / name).string();
    Simulator simulator(s);
    SequenceWriter writer(out + "/", simulator.setup(), s.model_file, {"it's: noted"});
    RecordedFrame frame;
    simulator.next(&frame);
    writer.write(frame);
    EXPECT_EQ(readSequence(out).name, name);
  }
}

/// A limit on the size of files acts as a full disk.
TEST_F(SimulatorTest, AFullDiskEndsTheRecordingWhichStaysReadable) {
  Scenario s = Scenario::fromYamlFile(scenario());
  s.faults.noise = 0;
  Simulator simulator(s);
  const std::string out = (folder_ / "full").string();
  SequenceWriter writer(out, simulator.setup(), s.model_file, simulator.notes());
  RecordedFrame frame;
  simulator.next(&frame);
  writer.write(frame);
  simulator.next(&frame);
  writer.write(frame);
  simulator.next(&frame);
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{2000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::string message;
  try {
    writer.write(frame);
  } catch (const InputError& e) {
    message = e.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, previous);
  EXPECT_NE(message.find("cannot be written"), std::string::npos);
  EXPECT_NE(message.find("2 images are complete"), std::string::npos);
  const Sequence sequence = readSequence(out);
  ASSERT_EQ(sequence.frames.size(), 2u);
  for (const SequenceFrame& f : sequence.frames) EXPECT_NO_THROW(readImage(f.image_file, s.camera));
  EXPECT_THROW(SequenceWriter(out, simulator.setup(), s.model_file, {}), InputError);
}

TEST_F(SimulatorTest, RandomFlightsAreClearAndGoByTheirSeed) {
  Scenario s = Scenario::fromYamlFile(scenario("", "random: {duration: 15, speed: 0.7}\n"));
  std::vector<Eigen::Vector3d> ends;
  for (const uint64_t seed : {1, 2, 3, 1}) {
    s.seed = seed;
    // The constructor of the simulator checks the clearance at every image.
    const Simulator simulator(s);
    const FlightPath& path = simulator.scenario().path;
    EXPECT_GE(path.end(), 15);
    ends.push_back(path.at(path.end()).translation());
    double length = 0;
    for (double t = 0.1; t <= path.end(); t += 0.1) {
      length += (path.at(t).translation() - path.at(t - 0.1).translation()).norm();
      EXPECT_LT(path.velocity(t).norm(), 3);
    }
    EXPECT_GT(length, 3);
  }
  EXPECT_EQ(ends[0], ends[3]);
  EXPECT_NE(ends[0], ends[1]);
  EXPECT_NE(ends[1], ends[2]);
}

TEST(RandomFlight, MayBeLongInAWideHall) {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {60, 60, 8}, 0, true);
  const Scene scene(weldMesh(std::move(soup), 1e-6, "hall"));
  RandomFlight request;
  request.duration = 300;
  EXPECT_GE(randomFlight(scene, request, "hall").end(), 300);
}

/// The maps in the repository must be equal to the output of their script, byte for byte.
TEST(Maps, AreWhatTheirScriptMakes) {
  const fs::path folder = fs::temp_directory_path() / ("edge_mcl_maps_" + std::to_string(getpid()));
  ASSERT_EQ(
      std::system(
          ("/usr/bin/python3 -B '" + kMaps + "/generate.py' '" + folder.string() + "'").c_str()),
      0);
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    ++files;
    const fs::path name = fs::relative(entry.path(), folder);
    EXPECT_EQ(contentOf(entry.path()), contentOf(fs::path(kMaps) / name)) << name;
  }
  EXPECT_EQ(files, 10);
  fs::remove_all(folder);
}

/// The office exists in two formats. Both must give the same building.
TEST(Maps, TheOfficeIsTheSameInColladaAsInObj) {
  const MeshModel obj = loadMesh(kMaps + "/office.obj", {});
  const MeshModel dae = loadMesh(kMaps + "/office.dae", {});
  EXPECT_EQ(obj.triangles.size(), dae.triangles.size());
  EXPECT_EQ(obj.vertices.size(), dae.vertices.size());
  EXPECT_LT((obj.lowest - dae.lowest).norm(), 1e-5f);
  EXPECT_LT((obj.highest - dae.highest).norm(), 1e-5f);
}

TEST(Maps, EveryFlightIsClearOfTheBuilding) {
  for (const char* name : {"office", "house", "hall"})
    EXPECT_NO_THROW(Simulator(Scenario::fromYamlFile(kMaps + "/" + name + "_flight.yaml"))) << name;
}

}  // namespace
}  // namespace edge_mcl
