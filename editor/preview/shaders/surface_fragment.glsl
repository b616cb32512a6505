// kView, kShading and kMaps (whether the part has maps) are constants: software renderers run both sides of
// every branch that is not one.

uniform sampler2DShadow shadow_map;

layout(location = 0) out vec4 color;

const float kPi = 3.14159265;
const float kReflectance = 0.035;
// How far light wraps round the form, and how much of the bump reaches the diffuse light, by channel: red
// travels farthest in skin.
const vec3 kWrap = vec3(0.17, 0.11, 0.09);
const vec3 kBump = vec3(0.82, 0.94, 1.0);
// What each light keeps of its reflection: the rim grazes the surface, where everything mirrors.
const float kGloss[3] = float[3](0.9, 0.9, 0.35);
// The darkest a crease gets where there is no map to say.
const float kVertexShade = 0.55;

vec3 keyTint() { return vec3(1.0, 0.955, 0.9); }
vec3 fillTint() { return vec3(0.82, 0.9, 1.0); }
vec3 rimTint() { return vec3(0.93, 0.96, 1.0); }

float shadowAt(vec3 position, vec3 normal) {
  // Moved off the surface, farther where the light grazes it: a facet must not shade itself.
  float cosine = clamp(dot(normal, scene.lights[0].xyz), 0.0, 1.0);
  float lift = scene.eye.w * mix(6.0, 2.0, cosine);
  vec3 at = (scene.shadow * vec4(position + normal * lift, 1.0)).xyz;
  if (any(lessThan(at.xy, vec2(0.0))) || any(greaterThan(at.xy, vec2(1.0)))) return 1.0;
  vec2 texel = 1.0 / vec2(textureSize(shadow_map, 0));
  float lit = 0.0;
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x)
      lit += texture(shadow_map, vec3(at.xy + vec2(x, y) * 1.7 * texel, at.z - 0.001));
  return mix(1.0, lit / 9.0, smoothstep(0.0, 0.25, cosine));
}

// GGX with Smith's height-correlated visibility and Schlick's Fresnel term.
float specular(vec3 n, vec3 v, vec3 l, float roughness) {
  vec3 h = normalize(v + l);
  float nl = max(dot(n, l), 0.0), nv = max(dot(n, v), 1e-3), nh = max(dot(n, h), 0.0);
  float a = roughness * roughness, a2 = a * a;
  float d = nh * nh * (a2 - 1.0) + 1.0;
  float distribution = a2 / (kPi * d * d);
  float masking = nl * sqrt(nv * nv * (1.0 - a2) + a2), shadowing = nv * sqrt(nl * nl * (1.0 - a2) + a2);
  float visibility = 0.5 / (masking + shadowing + 1e-5);
  float fresnel = kReflectance + (1.0 - kReflectance) * pow(1.0 - max(dot(v, h), 0.0), 5.0);
  return distribution * visibility * fresnel * nl;
}

// Light from the surface with form normal `form` and wrinkled normal `n`; `cavity` is 1 outside creases.
vec3 shade(vec3 base, vec3 form, vec3 n, vec3 v, float cavity, float roughness, float shadow) {
  vec3 total = vec3(0.0);
  for (int i = 0; i < 3; ++i) {
    vec3 l = scene.lights[i].xyz;
    vec3 tint = scene.lights[i].w * (i == 0 ? keyTint() * shadow : i == 1 ? fillTint() : rimTint());
    float formed = dot(form, l), bumped = dot(n, l);
    vec3 soft = max((mix(vec3(formed), vec3(bumped), kBump) + kWrap) / (1.0 + kWrap), 0.0);
    float reach = furrowFade((formed + kWrap.r) / (1.0 + kWrap.r));
    total += tint * reach * (base * soft / (1.0 + kWrap) * mix(1.0, cavity, 0.5));
    total += tint * furrowFade(formed) * specular(n, v, l, roughness) * cavity * kPi * kGloss[i];
  }
  vec3 sky = vec3(0.2, 0.215, 0.24), ground = vec3(0.085, 0.07, 0.06);
  float rise = 0.5 + 0.5 * dot(n, scene.up.xyz);
  total += base * mix(ground, sky, rise) * cavity;
  return total;
}

// Keeps colours as they are up to 0.8 and rolls brighter ones off to white (Khronos PBR neutral tone
// mapping).
vec3 toneMap(vec3 c) {
  const float start = 0.76, desaturation = 0.15;
  float x = min(c.r, min(c.g, c.b));
  c -= x < 0.08 ? x - 6.25 * x * x : 0.04;
  float peak = max(c.r, max(c.g, c.b));
  if (peak < start) return c;
  float d = 1.0 - start;
  float new_peak = 1.0 - d * d / (peak + d - start);
  c *= new_peak / peak;
  float g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
  return mix(c, vec3(new_peak), g);
}

float component(vec4 values[4], uint layer) { return values[layer / 4u][layer % 4u]; }

vec3 diverging(float w) {
  const vec3 neutral = vec3(0.42), warm = vec3(0.95, 0.42, 0.06), hot = vec3(0.62, 0.02, 0.015);
  const vec3 cool = vec3(0.1, 0.42, 0.85), cold = vec3(0.012, 0.05, 0.4);
  float m = min(abs(w), 1.0);
  vec3 middle = w > 0.0 ? warm : cool, end = w > 0.0 ? hot : cold;
  return m < 0.5 ? mix(neutral, middle, m * 2.0) : mix(middle, end, m * 2.0 - 1.0);
}

vec3 heat(float x) {
  const vec3 stops[5] = vec3[5](vec3(0.012, 0.008, 0.05), vec3(0.12, 0.02, 0.22), vec3(0.55, 0.06, 0.1),
                                vec3(0.93, 0.33, 0.02), vec3(0.97, 0.88, 0.45));
  float at = clamp(x, 0.0, 1.0) * 4.0;
  int i = min(int(at), 3);
  return mix(stops[i], stops[i + 1], at - float(i));
}

float maskAt(uint layer) {
  if (scene.given_values != 0u) return vertex.value.x;
  if (material.with_masks == 0u) return component(vertex.masks, layer);
  return furrowMaskedWeight(1.0, material.slices[layer], vertex.uv);
}

vec3 viewColor() {
  switch (kView) {
    case kViewWeight:
      return diverging(component(vertex.weights, scene.layer));
    case kViewMask:
      return mix(vec3(0.03), vec3(0.85), maskAt(scene.layer));
    case kViewBias:
      return diverging(vertex.value.x);
    case kViewConfidence:
    case kViewMorph:
      return heat(vertex.value.x);
    case kViewPoint:
      return vertex.value.rgb;
  }
  return vec3(0.2);
}

void main() {
  vec3 v = normalize(scene.eye.xyz - vertex.position);
  // Both sides are drawn. The winding cannot tell them apart (nodes may mirror), the face's own plane can.
  vec3 facet = cross(dFdx(vertex.position), dFdy(vertex.position));
  if (dot(facet, v) < 0.0) facet = -facet;
  float side = dot(vertex.normal, facet) < 0.0 ? -1.0 : 1.0;
  vec3 form = normalize(vertex.normal) * side;
  uv_dx = dFdx(vertex.uv);
  uv_dy = dFdy(vertex.uv);

  if (kView != kViewBeauty) {
    float light = 0.45 + 0.4 * max(dot(form, v), 0.0) + 0.35 * max(dot(form, scene.lights[0].xyz), 0.0);
    color = vec4(viewColor() * light, 1.0);
    return;
  }

  vec3 bitangent = vertex.tangent.w * cross(vertex.normal, vertex.tangent.xyz);
  mat3 frame = mat3(vertex.tangent.xyz, bitangent, vertex.normal) * side;
  vec3 base = material.base_color.rgb * vertex.value.rgb * vertex.value.rgb;
  float shadow = shadowAt(vertex.position, form);

  if (!kMaps || kShading == kShadingAlpha || kShading == kShadingNone) {
    float crease = 1.0;
    for (uint i = 0u; i < scene.layers && kShading != kShadingNone; ++i) {
      float w = component(vertex.weights, i);
      if (!kMaps) {
        crease *= 1.0 - max(w, 0.0) * kVertexShade;
      } else {
        FurrowWrinkles one = furrowBegin(vec3(0.0, 0.0, 1.0));
        furrowAddLayer(one, w, material.slices[i], vertex.uv);
        crease *= one.shading;
      }
    }
    vec3 lit = shade(base, form, form, v, 1.0, material.roughness, shadow);
    color = vec4(toneMap(furrowAlphaShade(lit, 1.0, 1.0 - crease)), 1.0);
    return;
  }

  if (kShading == kShadingBlend) {
    vec3 plain = shade(base, form, form, v, 1.0, material.roughness, shadow);
    vec3 total = plain;
    for (uint i = 0u; i < scene.layers; ++i) {
      float w = component(vertex.weights, i);
      float I = abs(furrowMaskedWeight(w, material.slices[i], vertex.uv));
      if (I == 0.0) continue;
      FurrowWrinkles full = furrowBegin(vec3(0.0, 0.0, 1.0));
      uvec4 unmasked = uvec4(material.slices[i].xy, FURROW_NO_SLICE, 0u);
      furrowAddLayer(full, sign(w), unmasked, vertex.uv);
      vec3 n = normalize(frame * furrowNormal(full));
      vec3 bumped = shade(base, form, n, v, full.shading, material.roughness, shadow);
      total += furrowBlend(plain, bumped, I) - plain;
    }
    color = vec4(toneMap(max(total, 0.0)), 1.0);
    return;
  }

  FurrowWrinkles wrinkles = furrowBegin(vec3(0.0, 0.0, 1.0));
  for (uint i = 0u; i < scene.layers; ++i)
    furrowAddLayer(wrinkles, component(vertex.weights, i), material.slices[i], vertex.uv);
  vec3 bump = furrowNormal(wrinkles);
  vec2 slope = furrowSlope(bump);
  float roughness = furrowRoughness(material.roughness, furrowSlopeVariance(dFdx(slope), dFdy(slope)));
  vec3 n = normalize(frame * bump);
  color = vec4(toneMap(shade(base, form, n, v, wrinkles.shading, roughness, shadow)), 1.0);
}
