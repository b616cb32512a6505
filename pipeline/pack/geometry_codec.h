#pragma once

namespace furrow::pipeline {

// How an asset carries its geometry: compressed by Draco, or as plain streams that load without it. Both
// decode to the same floats.
enum class GeometryCodec { kDraco, kRaw };

}  // namespace furrow::pipeline
