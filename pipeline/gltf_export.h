#pragma once

// A cooked asset as glTF 2.0, for tools that know nothing of furrow.

#include <cstddef>
#include <vector>

#include "furrow/asset.h"
#include "pipeline/scene/rig.h"

namespace furrow::pipeline {

// The bytes of a GLB file. Vertices are in the asset's order: a mesh of one primitive for every part, in the
// parts' order. With it come
//   the nodes, skins, morph targets and clips of the rig, which pose the vertices as the asset's do;
//   a vertex's POSITION, NORMAL, TANGENT, TEXCOORD_0, COLOR_0, JOINTS_n, WEIGHTS_n, and
//     _POINT        its point (a number; left out from 2^24 points on, where floats would round it)
//     _WEIGHT_X     the weight of layer X at rest: its bias, and what lambda < 1 gives
//     _MASK_X       [0, 1]
//     _BIAS_X       [-1, 1], where the layer has one
//     _DIRECTION_X  unit, in root space at rest, 0 where there is none; _CONFIDENCE_X [0, 1]. Not for measure
//     "none"
//   every slice of the maps as a PNG image: normals (green up), shading factors, masks;
//   the model's own colours and normals, as far as the asset keeps them, as textures of its materials.
// X is the layer's name in capitals, with _ for what is no letter or digit. extras.furrow of the file lists
// the layers with their attributes, extras.furrow of a material their images and the windows of UV space
// these cover.
std::vector<std::byte> exportGlb(const AssetView& asset, const Rig& rig);

}  // namespace furrow::pipeline
