// furrow's shader library: from the weights of a vertex and the maps of a texture set to the wrinkled
// normal. An engine includes this text in its pixel shader. It compiles as GLSL (3.30 and up, or ES 3.00
// with highp floats, integers and samplers) and, with FURROW_HLSL defined, as HLSL.
//
// In one call, from control flow that a whole triangle goes through:
//
//   FurrowSurface surface = furrowSurface(base_normal, uv, layers);
//   surface.normal, surface.cavity, furrowRoughness(roughness, surface.variance): light with these
//
// or, where that does not fit, in one line a layer:
//
//   FurrowWrinkles wrinkles = furrowBegin(base_normal);
//   furrowAddLayer(wrinkles, weight, slices, uv);  // each layer; weight: the interpolated w of the vertices
//   vec3 normal = furrowNormal(wrinkles);          // tangent space, unit
//
// They fetch the maps through macros that the engine defines first. Those are called in divergent control flow:
// sample with explicit gradients there. A slice may cover a part of UV space only, `at` is where in it uv lies,
// and the gradients of `at` are those of uv times `zoom`. All textures repeat.
//   FURROW_WINDOW(slice)             vec4 of TextureSet::windows
//   FURROW_NORMAL(at, slice, zoom)   vec2 of TextureSet::normals
//   FURROW_SHADING(at, slice, zoom)  float of TextureSet::shading
//   FURROW_MASK(uv, slice)           vec4 of TextureSet::masks; not defined: weights come times Layer::mask
//   FURROW_WEIGHT(layer)             float, the interpolated weight of a layer (furrowSurface alone)
//   FURROW_SLICES(layer)             uvec4, what furrowAddLayer takes as slices (furrowSurface alone)
// Without FURROW_NORMAL the library has neither and the engine puts the functions below together itself.
//
// FURROW_COMBINE chooses how layers and the base normal add up:
//   0  surface gradients: slopes weighted by w and summed, in any order (Mikkelsen 2020); the default
//   1  whiteout: normalize(n1.xy + n2.xy, n1.z n2.z) (Oat 2007)
//   2  reoriented normal mapping (Barre-Brisebois and Hill 2012)
//
// Tangent space is that of the vertices: x along the tangent, y along the bitangent w cross(normal,
// tangent), z along the normal. "I" is Larsson's interpolation factor, |w|.

#ifdef FURROW_HLSL
#define vec2 float2
#define vec3 float3
#define vec4 float4
#define uvec4 uint4
#define mix lerp
#define fract frac
#define inversesqrt rsqrt
#define dFdx ddx
#define dFdy ddy
#endif

#ifndef FURROW_COMBINE
#define FURROW_COMBINE 0
#endif

// ---- One normal ----

// Unit normal of a BC5 texel: x and y stored * 0.5 + 0.5. Slopes end at 16, where block compression leaves
// no z.
vec3 furrowDecodeNormal(vec2 texel) {
  vec2 xy = texel * 2.0 - 1.0;
  return vec3(xy, sqrt(max(1.0 - xy.x * xy.x - xy.y * xy.y, 1.0 / 257.0)));
}

// Slope of the surface along tangent and bitangent, with its sign turned: (-dh/dx, -dh/dy).
vec2 furrowSlope(vec3 normal) { return normal.xy / normal.z; }

// Larsson's interpolated bump mapping: x and y scaled by I, then renormalised. It is the slope scaled by I,
// exactly.
vec3 furrowScale(vec3 normal, float I) { return normalize(vec3(normal.xy * I, normal.z)); }

// The same by z alone, without a division: unit, but steeper in z than furrowScale. Largest angle between
// the two over I in [0, 1], which lies near I = 0.55, by the length of the map's x and y:
//   x^2 + y^2   0.1    0.2    0.3    0.4    0.5    0.6    0.64   0.7    0.8    0.9
//   degrees     0.4    1.1    2.3    3.8    5.9    8.8    10.2   12.7   18.4   28.2
vec3 furrowScaleFast(vec3 normal, float I) {
  return vec3(normal.xy * I, sqrt(1.0 - I * I * (1.0 - normal.z * normal.z)));
}

// ---- Two normals; unit in, unit out ----

vec3 furrowCombineGradients(vec3 base, vec3 detail) {
  return normalize(vec3(base.xy * detail.z + detail.xy * base.z, base.z * detail.z));
}

vec3 furrowCombineWhiteout(vec3 base, vec3 detail) {
  return normalize(vec3(base.xy + detail.xy, base.z * detail.z));
}

vec3 furrowCombineReoriented(vec3 base, vec3 detail) {
  vec3 t = base + vec3(0.0, 0.0, 1.0);
  vec3 u = detail * vec3(-1.0, -1.0, 1.0);
  return normalize(t * dot(t, u) - u * t.z);
}

// ---- Larsson's other two methods ----

// Alpha shading: creases as darker colour, for a surface lit without its wrinkles. W is the shading map, 0
// on ridges.
vec3 furrowAlphaShade(vec3 color, float I, float W) { return color * (1.0 - I * W); }

// Bump-map blending: between the surface lit flat and lit with its wrinkles in full.
vec3 furrowBlend(vec3 flat_color, vec3 bumped_color, float I) { return mix(flat_color, bumped_color, I); }

// ---- Light on a bumped surface ----

// Fades light out where the unbumped surface turns away from it, so that no crease lights up behind the
// terminator. `cosine` is that of the light and the unbumped normal (Larsson, eq. 12 and 13).
float furrowFade(float cosine) { return min(8.0 * max(cosine, 0.0), 1.0); }

// Variance of the slope along one axis under a pixel, from the slope's screen derivatives (Tokuyoshi and
// Kaplanyan 2019, a Gaussian pixel of half a pixel's deviation), bounded as there.
float furrowSlopeVariance(vec2 slope_dx, vec2 slope_dy) {
  return min(0.125 * (dot(slope_dx, slope_dx) + dot(slope_dy, slope_dy)), 0.09);
}

// Variance of the slope along one axis that averaging took from a normal: what its length, at most 1, has
// lost (Toksvig 2005). For maps that store all three components.
float furrowLostVariance(vec3 averaged) {
  float length_squared = dot(averaged, averaged);
  return inversesqrt(max(length_squared, 1e-8)) - 1.0;
}

// Perceptual roughness (GGX alpha = roughness^2) widened by a slope variance.
float furrowRoughness(float roughness, float variance) {
  float alpha = roughness * roughness;
  return sqrt(sqrt(min(alpha * alpha + 2.0 * variance, 1.0)));
}

// ---- All layers ----

struct FurrowWrinkles {
  vec3 normal;    // of the layers so far; (slope, 1) when gradients are summed, else unit
  float shading;  // product of 1 - I W: the colour of alpha shading, a cavity factor for all others
};

FurrowWrinkles furrowBegin(vec3 base_normal) {
  FurrowWrinkles wrinkles;
#if FURROW_COMBINE == 0
  wrinkles.normal = vec3(furrowSlope(base_normal), 1.0);
#else
  wrinkles.normal = base_normal;
#endif
  wrinkles.shading = 1.0;
  return wrinkles;
}

// Adds a unit normal at I in [0, 1].
void furrowAddNormal(inout FurrowWrinkles wrinkles, vec3 normal, float I) {
#if FURROW_COMBINE == 0
  wrinkles.normal.xy += furrowSlope(normal) * I;
#elif FURROW_COMBINE == 1
  wrinkles.normal = furrowCombineWhiteout(wrinkles.normal, furrowScale(normal, I));
#else
  wrinkles.normal = furrowCombineReoriented(wrinkles.normal, furrowScale(normal, I));
#endif
}

vec3 furrowNormal(FurrowWrinkles wrinkles) { return normalize(wrinkles.normal); }

#ifdef FURROW_NORMAL
#define FURROW_NO_SLICE 0xffffffffu

// The weight of a layer at this pixel. slices: compress, stretch, index of the layer's mask (slice * 4 +
// channel), unused.
float furrowMaskedWeight(float weight, uvec4 slices, vec2 uv) {
#ifdef FURROW_MASK
  if (slices.z == FURROW_NO_SLICE) return weight;
  vec4 mask = FURROW_MASK(uv, slices.z / 4u);
  uint channel = slices.z % 4u;
  return weight * (channel == 0u ? mask.x : channel == 1u ? mask.y : channel == 2u ? mask.z : mask.w);
#else
  return weight;
#endif
}

// Adds a layer: its compress map at w > 0, its stretch map at w < 0. slices as for furrowMaskedWeight;
// FURROW_NO_SLICE: no such map.
void furrowAddLayer(inout FurrowWrinkles wrinkles, float weight, uvec4 slices, vec2 uv) {
  uint slice = weight > 0.0 ? slices.x : slices.y;
  if (weight == 0.0 || slice == FURROW_NO_SLICE) return;
  vec4 window = FURROW_WINDOW(slice);
  vec2 at = fract(uv - window.xy) * window.zw;
  if (max(at.x, at.y) > 1.0) return;  // beside the map, where the mask is 0
  float I = abs(furrowMaskedWeight(weight, slices, uv));
  if (I == 0.0) return;
  furrowAddNormal(wrinkles, furrowDecodeNormal(FURROW_NORMAL(at, slice, window.zw)), I);
  wrinkles.shading *= 1.0 - I * FURROW_SHADING(at, slice, window.zw);
}

#ifdef FURROW_WEIGHT
struct FurrowSurface {
  vec3 normal;     // tangent space, unit
  float cavity;    // 1 outside creases: times ambient and reflected light
  float variance;  // of the slope under this pixel, for furrowRoughness
};

FurrowSurface furrowSurface(vec3 base_normal, vec2 uv, uint layers) {
  FurrowWrinkles wrinkles = furrowBegin(base_normal);
  for (uint layer = 0u; layer < layers; ++layer)
    furrowAddLayer(wrinkles, FURROW_WEIGHT(layer), FURROW_SLICES(layer), uv);
  FurrowSurface surface;
  surface.normal = furrowNormal(wrinkles);
  surface.cavity = wrinkles.shading;
  vec2 slope = furrowSlope(surface.normal);
  surface.variance = furrowSlopeVariance(dFdx(slope), dFdy(slope));
  return surface;
}
#endif
#endif
