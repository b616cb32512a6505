#include "editor/preview/programs.h"

#include <epoxy/gl.h>

#include <string>

#include "editor/preview/shaders/scene.h"
#include "preview_shaders.h"

namespace furrow::preview {

static_assert(gpu::kMaxPreviewLayers == kMaxLayers);
static_assert(gpu::kShadingNone == static_cast<uint32_t>(Shading::kNone) &&
              gpu::kViewMorph == static_cast<uint32_t>(View::kMorph));

Programs::Programs()
    : background(makeProgram("background", {shaders::kBackgroundVertex}, {},
                             {shaders::kFurrowShade, shaders::kLighting, shaders::kBackgroundFragment})),
      stroke(makeProgram("stroke", {shaders::kStrokeVertex}, {shaders::kStrokeGeometry},
                         {shaders::kStrokeFragment})) {}

uint32_t Programs::shadow(bool holes) {
  GlObject& program = shadow_[holes];
  if (program) return program;
  const char* constants = holes ? "const bool kHoles = true;\n" : "const bool kHoles = false;\n";
  program = makeProgram("shadow", {shaders::kShadowVertex}, {}, {constants, shaders::kShadowFragment});
  glUseProgram(program);
  glUniform1i(glGetUniformLocation(program, "base_color_map"), kBaseColorMap);
  return program;
}

uint32_t Programs::surface(const RenderOptions& options, bool maps, bool base_color, bool base_normal,
                           bool painted) {
  // Only the beauty view knows shadings.
  const Shading shading = options.view == View::kBeauty ? options.shading : Shading::kNone;
  GlObject& program =
      surface_[{options.view, shading, options.lighting, maps, base_color, base_normal, painted}];
  if (program) return program;
  const auto truth = [](bool value) { return value ? "true" : "false"; };
  const std::string constants =
      "const uint kView = " + std::to_string(static_cast<uint32_t>(options.view)) +
      "u;\nconst uint kShading = " + std::to_string(static_cast<uint32_t>(shading)) +
      "u;\nconst bool kBlinn = " + truth(options.lighting == Lighting::kBlinn) +
      ";\nconst bool kMaps = " + truth(maps) + ";\nconst bool kBaseColor = " + truth(base_color) +
      ";\nconst bool kBaseNormal = " + truth(base_normal) + ";\nconst bool kPainted = " + truth(painted) +
      ";\n";
  program = makeProgram("surface", {constants.c_str(), shaders::kSurfaceVertex}, {},
                        {constants.c_str(), shaders::kSurfaceMaps, shaders::kFurrowShade, shaders::kLighting,
                         shaders::kSurfaceFragment});
  glUseProgram(program);
  glUniform1i(glGetUniformLocation(program, "normal_maps"), kNormalMaps);
  glUniform1i(glGetUniformLocation(program, "shading_maps"), kShadingMaps);
  glUniform1i(glGetUniformLocation(program, "mask_maps"), kMaskMaps);
  glUniform1i(glGetUniformLocation(program, "painted_mask"), kPaintedMask);
  glUniform1i(glGetUniformLocation(program, "shadow_map"), kShadowMap);
  glUniform1i(glGetUniformLocation(program, "base_color_map"), kBaseColorMap);
  glUniform1i(glGetUniformLocation(program, "base_normal_map"), kBaseNormalMap);
  return program;
}

}  // namespace furrow::preview
