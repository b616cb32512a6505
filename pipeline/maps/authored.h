#pragma once

// Wrinkle maps that an artist painted or sculpted: from image files to normals in the vertices' tangent
// frames.

#include <array>
#include <filesystem>

#include "pipeline/maps/image.h"
#include "pipeline/maps/texel_map.h"

namespace furrow::pipeline {

enum class Green { kOpenGl, kDirectX };  // whether green is up in the image, or down

struct WrinkleMaps {
  Image normal;   // 2 channels: x, y of the unit normal, [-1, 1]
  Image shading;  // 1 channel: alpha-shading factor W, 0 where no crease is
};

// Checked and as slopes x/z, y/z (2 channels). Throws Error (kBadData) as readImage(), and if it is no
// tangent-space normal map: less than 2 channels, texels that are no unit vectors or point inwards, or none
// that is tilted.
Image readNormals(const std::filesystem::path& file, Green green);

// The first channel counts. Throws Error (kBadData) as readImage(), and if heights lie outside [0, 1] or all
// are the same.
Image readHeights(const std::filesystem::path& file);

// Normals and shading from readNormals(); W comes from how hollow the map is.
WrinkleMaps mapsFromSlopes(const Image& slopes, const TexelGrid& grid);

// Normals and shading from heights in [0, 1], `depth` from 0 to 1 in root-space units: exact on the surface
// whatever the scale, stretch and handedness of its UVs. W comes from how deep a texel lies below its
// surroundings.
WrinkleMaps mapsFromHeights(const Image& heights, const Surface& surface, const TexelMap& texels,
                            double depth);

// Cuts normals off at x^2 + y^2 = limit, in (0, 1).
void limitNormals(Image& normal, float limit);

// W as the wrinkles look under a light from a direction in root space, of any length but 0 (Larsson's alpha
// maps): how much less light they get than the surface without them, the light standing at least 30 degrees
// over it.
Image litShading(const Image& normal, const Surface& surface, const TexelMap& texels,
                 const std::array<double, 3>& light);

}  // namespace furrow::pipeline
