// The pixel shader of docs/integration.md as it stands there.

uniform sampler2DArray normal_maps, shading_maps, mask_maps;
uniform vec4 windows[32];
uniform uvec4 slices[16];
uniform uint layers;
uniform float base_roughness;
in vec2 uv;
in vec4 w[4];
out vec4 pixel;
vec2 uv_dx, uv_dy;

#include "glsl_1_1.inc"

void main() {
  vec3 base_normal = vec3(0.0, 0.0, 1.0);
  uv_dx = dFdx(uv);
  uv_dy = dFdy(uv);

#include "glsl_1_2.inc"

  pixel = vec4(n * surface.cavity, roughness);
}
