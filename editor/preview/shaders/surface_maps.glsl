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
uniform sampler2D painted_mask;
uniform sampler2DArray base_color_map;
uniform sampler2DArray base_normal_map;

vec2 uv_dx, uv_dy;

// The model's own map at the matrix `columns`, `begin`.
vec4 baseMap(sampler2DArray map, vec4 columns, vec2 begin) {
  mat2 turn = mat2(columns.xy, columns.zw);
  return textureGrad(map, vec3(turn * vertex.uv + begin, 0.0), turn * uv_dx, turn * uv_dy);
}

float component(vec4 values[4], uint layer) { return values[layer / 4u][layer % 4u]; }
float paintedMask() { return textureGrad(painted_mask, vertex.uv, uv_dx, uv_dy).x; }
float weightAt(uint layer) {
  float weight = component(vertex.weights, layer);
  return kPainted && layer == scene.layer ? weight * paintedMask() : weight;
}
uint shownLayer(uint i) { return scene.shown_layers[i / 4u][i % 4u]; }

#define FURROW_WINDOW(slice) material.windows[slice]
#define FURROW_WEIGHT(i) weightAt(shownLayer(i))
#define FURROW_SLICES(i) material.slices[shownLayer(i)]
#define FURROW_NORMAL(at, slice, zoom) \
  textureGrad(normal_maps, vec3(at, float(slice)), uv_dx * zoom, uv_dy * zoom).xy
#define FURROW_SHADING(at, slice, zoom) \
  textureGrad(shading_maps, vec3(at, float(slice)), uv_dx * zoom, uv_dy * zoom).x
#define FURROW_MASK(uv, slice) textureGrad(mask_maps, vec3(uv, float(slice)), uv_dx, uv_dy)
