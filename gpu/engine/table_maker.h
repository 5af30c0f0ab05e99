/// Makes score tables from pictures on the device. For .cu files only.
#pragma once

#include "edge_mcl/gpu/engine/device_memory.h"
#include "edge_mcl/gpu/math/table_recipe.h"

namespace edge_mcl::gpu {

/// Holds the buffers of the stages between a picture and its table. All calls must use the same
/// stream.
class TableMaker {
 public:
  /// Starts the upload of the picture and the computation of its table, and returns at once. A
  /// recipe is uploaded only when it is not the recipe of the last call. @param recipe must live
  /// until the next call. @param quads output. @throws DeviceError
  void make(const TableRecipe& recipe, const PictureData& picture, DeviceArray<Quad>* quads,
            cudaStream_t stream);
  /// Starts the conversion of a table that the host made. @param pairs ScoreTable::pairs in device
  /// memory. @param quads output. @throws DeviceError
  static void convert(const Table& table, const uint16_t* pairs, DeviceArray<Quad>* quads,
                      cudaStream_t stream);
  /// Device memory of the buffers, bytes.
  size_t bytes() const;

 private:
  void prepare(const TableRecipe& recipe);

  const TableRecipe* recipe_ = nullptr;
  PictureWork work_{};
  int reach_ = 0;
  Event copied_;  ///< after it the staging memory may be written again
  PinnedArray<uint8_t> staging_;
  DeviceArray<DirectionBin> directions_;
  DeviceArray<int32_t> shifts_, sampled_count_, threshold_, parent_, count_, usable_;
  DeviceArray<double> limits_;
  DeviceArray<uint8_t> level_codes_, picture_, strong_, level_, codes_;
  DeviceArray<float> level_borders_;
  DeviceArray<int16_t> gradients_;  ///< PictureWork::smooth, then both gradients
  DeviceArray<uint32_t> sampled_, matches_;
};

}  // namespace edge_mcl::gpu
