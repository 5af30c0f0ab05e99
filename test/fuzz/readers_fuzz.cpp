// libFuzzer target: the readers of models and sequences may refuse an input. They must not crash or
// hang.
// Build: cmake -S . -B build-fuzz -G Ninja -DCMAKE_CXX_COMPILER=clang++ -DEDGE_MCL_FUZZ=ON
//        -DEDGE_MCL_WITH_ROS=OFF && cmake --build build-fuzz --target readers_fuzz
// Run:   build-fuzz/bin/readers_fuzz -max_total_time=600 -timeout=20 -rss_limit_mb=4096
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/edges/edge_model.h"
#include "edge_mcl/core/import/mesh_loader.h"
#include "edge_mcl/core/recordings/sequence.h"
#include "edge_mcl/core/recordings/text_table.h"

namespace {

std::string folder() {
  static const std::string path = [] {
    const std::string p = std::filesystem::temp_directory_path().string() + "/edge_mcl_fuzz_" +
                          std::to_string(getpid());
    std::filesystem::create_directories(p);
    return p;
  }();
  return path;
}

std::string write(const std::string& name, const uint8_t* data, size_t size) {
  const std::string file = folder() + "/" + name;
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return file;
}

void readModel(const std::string& file) {
  edge_mcl::MeshModel mesh = edge_mcl::loadMesh(file, {});
  if (mesh.triangles.size() < 10000) edge_mcl::buildEdgeModel(&mesh, {});
}

}  // namespace

// assimp 5.2 leaks a mesh when an STL file ends in the middle of a facet. The code under test
// cannot free it.
extern "C" const char* __lsan_default_suppressions() { return "leak:libassimp\n"; }

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size < 2) return 0;
  const uint8_t kind = data[0] % 7;
  ++data;
  --size;
  try {
    switch (kind) {
      case 0:
        readModel(write("model.obj", data, size));
        break;
      case 1:
        readModel(write("model.ply", data, size));
        break;
      case 2:
        readModel(write("model.stl", data, size));
        break;
      case 3:
        edge_mcl::CameraModel::fromYamlFile(write("only_camera.yaml", data, size));
        break;
      case 4:
        edge_mcl::readTrajectory(write("trajectory.txt", data, size));
        break;
      case 5:
        edge_mcl::readFileList(write("list.txt", data, size));
        break;
      default: {
        // The camera and the list are good, and the description is the input.
        const std::string camera =
            "image_width: 4\nimage_height: 4\ncamera_matrix: {data: [4,0,2,0,4,2,0,0,1]}\n"
            "distortion_model: plumb_bob\ndistortion_coefficients: {data: [0,0,0,0,0]}\n";
        write("camera.yaml", reinterpret_cast<const uint8_t*>(camera.data()), camera.size());
        const std::string list = "0.1 a.png\n";
        write("rgb.txt", reinterpret_cast<const uint8_t*>(list.data()), list.size());
        write("sequence.yaml", data, size);
        edge_mcl::readSequence(folder());
      }
    }
  } catch (const edge_mcl::Error&) {
    // The reader refused the input with a reason, as it should.
  }
  return 0;
}
