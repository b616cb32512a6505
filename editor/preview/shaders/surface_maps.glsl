// What the surface is drawn from; furrow_shade.glsl and surface_fragment.glsl follow.
in Surface {
  vec3 position;
  vec3 normal;
  vec4 tangent;
  vec2 uv;
  vec4 weights[4];
  vec4 masks[4];
  vec4 value;
} vertex;

uniform sampler2DArray normal_maps;
uniform sampler2DArray shading_maps;
uniform sampler2DArray mask_maps;

vec2 uv_dx, uv_dy;
#define FURROW_NORMAL(uv, slice) textureGrad(normal_maps, vec3(uv, float(slice)), uv_dx, uv_dy).xy
#define FURROW_SHADING(uv, slice) textureGrad(shading_maps, vec3(uv, float(slice)), uv_dx, uv_dy).x
#define FURROW_MASK(uv, slice) textureGrad(mask_maps, vec3(uv, float(slice)), uv_dx, uv_dy)
