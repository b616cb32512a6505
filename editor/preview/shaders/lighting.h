// Light and colours of the preview, one text for the shaders and, with glm, for C++. In shaders it follows
// furrow_shade.glsl.

#ifdef __cplusplus
#pragma once
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
namespace furrow::preview::gpu {
using namespace glm;
#define FURROW_FUNCTION inline
#define FURROW_VALUE inline const
// As furrow_shade.glsl has it.
inline float furrowFade(float cosine) {
  return min(8.0f * max(cosine, 0.0f), 1.0f);
}
#else
#define FURROW_FUNCTION
#define FURROW_VALUE const
#endif

FURROW_VALUE float kPi = 3.14159265f;
FURROW_VALUE float kReflectance = 0.035f;
// How far light wraps round the form, and how much of the bump reaches the diffuse light, by channel: red
// travels farthest in skin.
FURROW_VALUE vec3 kWrap = vec3(0.17f, 0.11f, 0.09f);
FURROW_VALUE vec3 kBump = vec3(0.82f, 0.94f, 1.0f);
// What a light keeps of its reflection; less for the rim, which grazes the surface, where everything mirrors.
FURROW_VALUE float kGloss = 0.9f;
FURROW_VALUE float kRimGloss = 0.35f;

// Texels of the shadow map between two of the nine samples that a pixel takes.
FURROW_VALUE float kShadowBlur = 3.0f;

// The darkest a crease gets where there is no map to say.
FURROW_VALUE float kVertexShade = 0.55f;

FURROW_FUNCTION vec3 keyTint() {
  return vec3(1.0f, 0.955f, 0.9f);
}
FURROW_FUNCTION vec3 fillTint() {
  return vec3(0.82f, 0.9f, 1.0f);
}
FURROW_FUNCTION vec3 rimTint() {
  return vec3(0.93f, 0.96f, 1.0f);
}

// GGX with Smith's height-correlated visibility and Schlick's Fresnel term, which rough surfaces, whose bumps hide one
// another where they are grazed, reach in part.
FURROW_FUNCTION float specular(vec3 n, vec3 v, vec3 l, float roughness) {
  vec3 h = normalize(v + l);
  float nl = max(dot(n, l), 0.0f), nv = max(dot(n, v), 1e-3f), nh = max(dot(n, h), 0.0f);
  float a = roughness * roughness, a2 = a * a;
  float d = nh * nh * (a2 - 1.0f) + 1.0f;
  float distribution = a2 / (kPi * d * d);
  float masking = nl * sqrt(nv * nv * (1.0f - a2) + a2), shadowing = nv * sqrt(nl * nl * (1.0f - a2) + a2);
  float visibility = 0.5f / (masking + shadowing + 1e-5f);
  float grazed = max(1.0f - roughness, kReflectance);
  float fresnel = kReflectance + (grazed - kReflectance) * pow(1.0f - max(dot(v, h), 0.0f), 5.0f);
  return distribution * visibility * fresnel * nl;
}

// Light from the surface with form normal `form` and wrinkled normal `n`; `cavity` is 1 outside creases.
// Lights are key, fill and rim: direction to the light and, in w, radiance.
FURROW_FUNCTION vec3 shade(const vec4 lights[3], vec3 up, vec3 base, vec3 form, vec3 n, vec3 v, float cavity,
                           float roughness, float shadow) {
  vec3 total = vec3(0.0f);
  for (int i = 0; i < 3; ++i) {
    vec3 l = vec3(lights[i]);
    vec3 tint = lights[i].w * (i == 0 ? keyTint() * shadow : i == 1 ? fillTint() : rimTint());
    float formed = dot(form, l), bumped = dot(n, l);
    vec3 soft = max((mix(vec3(formed), vec3(bumped), kBump) + kWrap) / (1.0f + kWrap), 0.0f);
    float reach = furrowFade((formed + kWrap.r) / (1.0f + kWrap.r));
    total += tint * reach * (base * soft / (1.0f + kWrap) * mix(1.0f, cavity, 0.5f));
    float gloss = i == 2 ? kRimGloss : kGloss;
    total += tint * furrowFade(formed) * specular(n, v, l, roughness) * cavity * kPi * gloss;
  }
  vec3 sky = vec3(0.2f, 0.215f, 0.24f), ground = vec3(0.085f, 0.07f, 0.06f);
  float rise = 0.5f + 0.5f * dot(n, up);
  total += base * mix(ground, sky, rise) * cavity;
  return total;
}

// The same lights by Blinn and Phong, faded as Larsson does where the unbumped surface turns away [L, eq. 12,
// 13].
FURROW_FUNCTION vec3 shadeBlinn(const vec4 lights[3], vec3 up, vec3 base, vec3 form, vec3 n, vec3 v,
                                float cavity, float roughness, float shadow) {
  float exponent = 2.0f / max(roughness * roughness * roughness * roughness, 1e-3f);  // as wide as GGX's peak
  vec3 total =
      base * mix(vec3(0.085f, 0.07f, 0.06f), vec3(0.2f, 0.215f, 0.24f), 0.5f + 0.5f * dot(n, up)) * cavity;
  for (int i = 0; i < 3; ++i) {
    vec3 l = vec3(lights[i]);
    vec3 tint = lights[i].w * (i == 0 ? keyTint() * shadow : i == 1 ? fillTint() : rimTint());
    float shine = 0.1f * pow(max(dot(n, normalize(v + l)), 0.0f), exponent);
    total += tint * furrowFade(dot(form, l)) * (base * max(dot(n, l), 0.0f) + vec3(shine)) * cavity;
  }
  return total;
}

// The light on a view that shows values.
FURROW_FUNCTION float viewLight(vec3 form, vec3 v, vec3 key) {
  return 0.45f + 0.4f * max(dot(form, v), 0.0f) + 0.35f * max(dot(form, key), 0.0f);
}

// How far off the surface, in texels of the shadow map, its light is looked up: farther where light grazes it, so that
// neither a facet nor the curve of the form shades itself.
FURROW_FUNCTION float shadowLift(float cosine) {
  return mix(13.0f, 4.0f, smoothstep(-0.1f, 0.9f, cosine));
}

// What reaches the surface of the key light: `lit` is the share of samples that the shadow map has in the light, `at`
// where, in [0, 1], beside which all is lit. Where the form itself turns away, shade() lets the light fade.
FURROW_FUNCTION float keyShare(float lit, vec2 at) {
  vec2 out_of_middle = abs(at * 2.0f - 1.0f);
  return mix(lit, 1.0f, smoothstep(0.9f, 1.0f, max(out_of_middle.x, out_of_middle.y)));
}

// Keeps colours nearly as they are up to 0.8 and rolls brighter ones off to white (Khronos PBR neutral tone mapping,
// with a gentler toe: dark colours lose at most half of their weakest channel, and less than 0.04).
FURROW_FUNCTION vec3 toneMap(vec3 c) {
  const float start = 0.76f, desaturation = 0.15f;
  float x = min(c.r, min(c.g, c.b));
  c -= 0.04f * x / (max(x, 0.0f) + 0.08f);
  float peak = max(c.r, max(c.g, c.b));
  if (peak < start) return c;
  float d = 1.0f - start;
  float new_peak = 1.0f - d * d / (peak + d - start);
  c *= new_peak / peak;
  float g = 1.0f - 1.0f / (desaturation * (peak - new_peak) + 1.0f);
  return mix(c, vec3(new_peak), g);
}

FURROW_FUNCTION vec3 diverging(float w) {
  const vec3 neutral = vec3(0.42f), warm = vec3(0.95f, 0.42f, 0.06f), hot = vec3(0.62f, 0.02f, 0.015f);
  const vec3 cool = vec3(0.1f, 0.42f, 0.85f), cold = vec3(0.012f, 0.05f, 0.4f);
  float m = min(abs(w), 1.0f);
  vec3 middle = w > 0.0f ? warm : cool, end = w > 0.0f ? hot : cold;
  return m < 0.5f ? mix(neutral, middle, m * 2.0f) : mix(middle, end, m * 2.0f - 1.0f);
}

FURROW_FUNCTION vec3 heat(float x) {
  float at = clamp(x, 0.0f, 1.0f) * 4.0f;
  vec3 c = mix(vec3(0.012f, 0.008f, 0.05f), vec3(0.12f, 0.02f, 0.22f), min(at, 1.0f));
  c = mix(c, vec3(0.55f, 0.06f, 0.1f), clamp(at - 1.0f, 0.0f, 1.0f));
  c = mix(c, vec3(0.93f, 0.33f, 0.02f), clamp(at - 2.0f, 0.0f, 1.0f));
  return mix(c, vec3(0.97f, 0.88f, 0.45f), clamp(at - 3.0f, 0.0f, 1.0f));
}

FURROW_FUNCTION vec3 maskShown(float mask) {
  return mix(vec3(0.03f), vec3(0.85f), mask);
}

// `pixel` from the bottom left corner.
FURROW_FUNCTION vec3 backgroundColor(vec2 pixel, float height) {
  vec3 grey = mix(vec3(0.013f, 0.0135f, 0.0145f), vec3(0.034f, 0.036f, 0.04f),
                  smoothstep(0.0f, 1.0f, pixel.y / height));
  // Half a step of noise, so that 8 bits show no bands.
  float noise = fract(52.9829189f * fract(dot(floor(pixel), vec2(0.06711056f, 0.00583715f)))) - 0.5f;
  return grey * (1.0f + noise * 0.03f);
}

#ifdef __cplusplus
#undef FURROW_FUNCTION
#undef FURROW_VALUE
}  // namespace furrow::preview::gpu
#endif
