#include "furrow/frame_plan.h"
#include "shader_spirv.h"
#include "shader_text.h"

namespace furrow {

namespace {

using namespace shader_text;

#ifdef FURROW_WITH_SPIRV
#define FURROW_COMPUTE(name) \
  { .compute = name, .hlsl = name##Hlsl, .spirv = shader_spirv::name }
#else
#define FURROW_COMPUTE(name) \
  { .compute = name, .hlsl = name##Hlsl }
#endif

constexpr ShaderSource kSources[] = {
    FURROW_COMPUTE(kCluster),
    FURROW_COMPUTE(kDeform),
    FURROW_COMPUTE(kCompress),
    FURROW_COMPUTE(kSmooth),
    FURROW_COMPUTE(kLaplace),
    FURROW_COMPUTE(kRespond),
    {.vertex = kRasterPose},
    {.vertex = kRasterCorner, .geometry = kRasterTriangle, .fragment = kRasterPixel},
    {.vertex = kRasterCornerQ, .geometry = kRasterLaplace, .fragment = kRasterPixel},
    {.vertex = kRasterEase},
    {.vertex = kRasterWeight},
    {.vertex = kRasterKeep},
};
static_assert(std::size(kSources) == static_cast<size_t>(Shader::kCount));

}  // namespace

const ShaderSource& shaderSource(Shader shader) {
  return kSources[static_cast<size_t>(shader)];
}

}  // namespace furrow
