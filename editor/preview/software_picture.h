#pragma once

// The preview's pictures without OpenGL, drawn by the runtime's software rasteriser on the cpu tier. The same
// camera, lights, shadows, background and colours as the renderer's; light is by vertex.

#include "editor/preview/renderer.h"

namespace furrow::preview {

// Why software cannot draw this: shading that needs a normal a pixel, or strokes. Null if it can.
const char* whyNotInSoftware(const RenderOptions& options);

// As Renderer::render, with options.tier kCpu; the same bytes for any number of threads. Throws
// pipeline::Error, also (kEnvironment) for what software cannot draw.
pipeline::Image softwarePicture(const AssetView& asset, const FrameInput& input, const RenderOptions& options,
                                uint32_t threads);

}  // namespace furrow::preview
