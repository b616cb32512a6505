// kView, kShading, kBlinn, kMaps (whether the part has wrinkle maps), kBaseColor and kBaseNormal (whether it has
// such maps of its own) and kPainted (whether a painted mask is put over it) are constants: software renderers run both sides of every branch that is not one.

uniform sampler2DShadow shadow_map;

layout(location = 0) out vec4 color;

float shadowAt(vec3 position, vec3 normal) {
  float cosine = dot(normal, scene.lights[0].xyz);
  float lift = scene.eye.w * shadowLift(cosine);
  vec3 at = (scene.shadow * vec4(position + normal * lift, 1.0)).xyz;
  vec2 texel = 1.0 / vec2(textureSize(shadow_map, 0));
  float lit = 0.0;
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x)
      lit += texture(shadow_map, vec3(at.xy + vec2(x, y) * kShadowBlur * texel, at.z - 0.001));
  return keyShare(lit / 9.0, at.xy);
}

vec3 light(vec3 base, vec3 form, vec3 n, vec3 v, float cavity, float roughness, float shadow) {
  return kBlinn ? shadeBlinn(scene.lights, scene.up.xyz, base, form, n, v, cavity, roughness, shadow)
                : shade(scene.lights, scene.up.xyz, base, form, n, v, cavity, roughness, shadow);
}

float maskAt(uint layer) {
  if (kPainted) return paintedMask();
  if (material.with_masks == 0u) return component(vertex.masks, layer);
  return furrowMaskedWeight(1.0, material.slices[layer], vertex.uv);
}

vec3 viewColor() {
  switch (kView) {
    case kViewWeight:
      return diverging(component(vertex.weights, scene.layer));
    case kViewMask:
      return maskShown(maskAt(scene.layer));
    case kViewBias:
    case kViewMorph:
      return diverging(vertex.value.x);
    case kViewConfidence:
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
  vec4 painted = material.base_color;
  if (kBaseColor) {
    painted *= baseMap(base_color_map, material.color_uv, material.color_at_normal_at.xy);
    if (painted.a < material.opaque_from) discard;
  }

  if (kView != kViewBeauty) {
    color = vec4(viewColor() * viewLight(form, v, scene.lights[0].xyz), 1.0);
    return;
  }

  vec3 bitangent = vertex.tangent.w * cross(vertex.normal, vertex.tangent.xyz);
  mat3 frame = mat3(vertex.tangent.xyz, bitangent, vertex.normal) * side;
  vec3 base = painted.rgb * vertex.value.rgb * vertex.value.rgb;
  vec3 own = vec3(0.0, 0.0, 1.0);  // normal, in tangent space
  if (kBaseNormal)
    own = furrowDecodeNormal(baseMap(base_normal_map, material.normal_uv, material.color_at_normal_at.zw).xy);
  vec3 smooth_normal = kBaseNormal ? normalize(frame * own) : form;  // without wrinkles
  float shadow = shadowAt(vertex.position, form);

  if (!kMaps || kShading == kShadingAlpha || kShading == kShadingNone) {
    float crease = 1.0;
    for (uint i = 0u; i < scene.layers && kShading != kShadingNone; ++i) {
      float w = FURROW_WEIGHT(i);
      if (!kMaps) {
        crease *= 1.0 - max(w, 0.0) * kVertexShade;
      } else {
        FurrowWrinkles one = furrowBegin(vec3(0.0, 0.0, 1.0));
        furrowAddLayer(one, w, FURROW_SLICES(i), vertex.uv);
        crease *= one.shading;
      }
    }
    vec3 lit = light(base, form, smooth_normal, v, 1.0, material.roughness, shadow);
    color = vec4(toneMap(furrowAlphaShade(lit, 1.0, 1.0 - crease) * scene.up.w), 1.0);
    return;
  }

  if (kShading == kShadingBlend) {
    vec3 plain = light(base, form, smooth_normal, v, 1.0, material.roughness, shadow);
    vec3 total = plain;
    for (uint i = 0u; i < scene.layers; ++i) {
      float w = FURROW_WEIGHT(i);
      float I = abs(furrowMaskedWeight(w, FURROW_SLICES(i), vertex.uv));
      if (I == 0.0) continue;
      FurrowWrinkles full = furrowBegin(own);
      uvec4 unmasked = uvec4(FURROW_SLICES(i).xy, FURROW_NO_SLICE, 0u);
      furrowAddLayer(full, sign(w), unmasked, vertex.uv);
      vec3 n = normalize(frame * furrowNormal(full));
      vec3 bumped = light(base, form, n, v, full.shading, material.roughness, shadow);
      total += furrowBlend(plain, bumped, I) - plain;
    }
    color = vec4(toneMap(max(total, 0.0) * scene.up.w), 1.0);
    return;
  }

  FurrowSurface surface = furrowSurface(own, vertex.uv, scene.layers);
  float roughness = furrowRoughness(material.roughness, surface.variance);
  vec3 n = normalize(frame * surface.normal);
  color = vec4(toneMap(light(base, form, n, v, surface.cavity, roughness, shadow) * scene.up.w), 1.0);
}
