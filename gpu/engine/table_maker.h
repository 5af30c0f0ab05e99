/// Score tables from pictures on the device. For .cu files only.
#pragma once

#include "edge_mcl/gpu/engine/device_memory.h"
#include "edge_mcl/gpu/math/table_recipe.h"

namespace edge_mcl::gpu {

/// Buffers for the stages between a picture and its table. Used by one stream.
class TableMaker {
 public:
  /// Starts the upload of the picture and the making of its table; returns at once.
  /// @param recipe must live until the next call, which uploads it only when it is another.
  void make(const TableRecipe& recipe, const PictureData& picture, DeviceArray<Quad>* quads,
            cudaStream_t stream);
  /// The same from a table that the host has made. @param pairs on the device.
  static void convert(const Table& table, const uint16_t* pairs, DeviceArray<Quad>* quads,
                      cudaStream_t stream);
  size_t bytes() const;

 private:
  void prepare(const TableRecipe& recipe);

  const TableRecipe* recipe_ = nullptr;
  PictureWork work_{};
  int reach_ = 0;
  Event copied_;  ///< the staging memory may be written again
  PinnedArray<uint8_t> staging_;
  DeviceArray<DirectionBin> directions_;
  DeviceArray<int32_t> shifts_, threshold_, parent_, count_, usable_;
  DeviceArray<uint8_t> level_codes_, picture_, strong_, level_, codes_;
  DeviceArray<float> level_borders_;
  DeviceArray<int16_t> gradients_;  ///< smooth, then both gradients
  DeviceArray<uint32_t> sampled_, matches_;
};

}  // namespace edge_mcl::gpu
