#pragma once

// What images say about directions, for directionsFromTensors(). Texels are read as they stand, without
// colour conversion, at every place of a triangle's UVs and not only at its corners. Triangles without UVs,
// or with none of an area, say nothing; UVs repeat outside [0, 1].

#include "pipeline/bake/directions.h"
#include "pipeline/maps/image.h"

namespace furrow::pipeline {

enum class ImageKind {
  kFlow,  // d in red and green, 0.5 is zero: red towards +u (right in the image), green up in the image; its
          // sign does not matter, its length is how sure it is
  kHeight,  // red: d is across the ridges (structure tensor)
  kSlopes,  // of a relief, as readNormals() gives them: the same
};

uint32_t leastChannels(ImageKind kind);

// The image has leastChannels(kind) or more.
LineTensors tensorsOfImage(const Surface& surface, const std::vector<bool>& covered, const Image& image,
                           ImageKind kind);

}  // namespace furrow::pipeline
