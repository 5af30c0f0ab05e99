/// Converts the types of core/ to the types of the device.
#pragma once

#include <vector>

#include "edge_mcl/core/likelihood/likelihood_backend.h"
#include "edge_mcl/gpu/math/particle_score.h"
#include "edge_mcl/gpu/math/table_recipe.h"

namespace edge_mcl::gpu {

Camera cameraOf(const CameraModel& camera);
Table tableOf(const ScoreTable& table);
Rule ruleOf(const LikelihoodFrame& frame);
Combination combinationOf(const LikelihoodParameters& params);
/// @param cell number of the cell on the device.
Particle particleOf(const edge_mcl::Pose& T_map_camera, uint32_t cell);

/// Geometry of the score table that is made of the picture.
Table tableOf(const Picture& picture);

/// Whether a device can make score tables with these parameters.
bool canMakeTables(const ImageParameters& params);
/// Computes the constants and look-up tables for images of one size. @param width, height pixels.
TableRecipe recipeOf(int width, int height, const ImageParameters& params,
                     const ScoreLevels& levels);
/// Points to the pixels of the picture, which must stay alive.
PictureData dataOf(const Picture& picture);

}  // namespace edge_mcl::gpu
