// Posed vertices: skinning of a morphed vertex. The expression order is that of src/deform.cpp and
// src/dual_quaternion.cpp.

FURROW_READ(0, float, rest_vertices);
FURROW_READ(1, uint, influences);
FURROW_READ(3, float, palette);
FURROW_READ(4, float, morph_weights);

struct PosedVertex {
  vec3 position;
  vec3 normal;
  vec4 tangent;
};

float restWord(uint word) { return FURROW_AT(rest_vertices, word); }

vec3 restPosition(uint v) { return vec3(restWord(3u * v), restWord(3u * v + 1u), restWord(3u * v + 2u)); }

// Where a vertex's normal and tangent are.
uint restFrame(uint v) { return 3u * frame.vertices + kRestFrameWords * v; }

vec3 restNormal(uint v) {
  uint word = restFrame(v);
  return vec3(restWord(word), restWord(word + 1u), restWord(word + 2u));
}

// Of a morph target: how much a step of position and a step of normal move; both 0 if it is at rest.
float positionStep(uint morph) { return FURROW_AT(morph_weights, 2u * (instance * frame.morphs + morph)); }
float normalStep(uint morph) { return FURROW_AT(morph_weights, 2u * (instance * frame.morphs + morph) + 1u); }

vec3 unit(vec3 v) {
  float squared = v.x * v.x + v.y * v.y + v.z * v.z;
  return squared > 0.0 ? v / sqrt(squared) : vec3(0.0, 1.0, 0.0);
}

float paletteWord(uint word) { return FURROW_AT(palette, word); }

// `p` and `n` are morphed; the normal and tangent are computed if `with_frame`.
PosedVertex skin(uint v, vec3 p, vec3 n, bool with_frame) {
  precise float m[12];
  for (uint i = 0u; i < 12u; ++i) m[i] = 0.0;
  if (frame.dual_quaternions == 0u) {
    for (uint k = 0u; k < frame.influences; ++k) {
      uint influence = FURROW_AT(influences, v * frame.influences + k);
      if ((influence >> 16) == 0u) continue;
      precise float weight = float(influence >> 16) * 1.52590219e-5;
      uint joint = (instance * frame.joints + (influence & 0xffffu)) * kMatrixWords;
      for (uint i = 0u; i < 12u; ++i) m[i] = m[i] + weight * paletteWord(joint + i);
    }
  } else {
    precise vec4 q = vec4(0.0, 0.0, 0.0, 0.0);
    precise vec4 d = vec4(0.0, 0.0, 0.0, 0.0);
    vec4 pivot = vec4(0.0, 0.0, 0.0, 0.0);
    precise float stretch[9];
    for (uint i = 0u; i < 9u; ++i) stretch[i] = 0.0;
    for (uint k = 0u; k < frame.influences; ++k) {
      uint influence = FURROW_AT(influences, v * frame.influences + k);
      if ((influence >> 16) == 0u) continue;
      precise float weight = float(influence >> 16) * 1.52590219e-5;
      uint joint = (instance * frame.joints + (influence & 0xffffu)) * kMotionWords;
      vec4 r = vec4(paletteWord(joint), paletteWord(joint + 1u), paletteWord(joint + 2u), paletteWord(joint + 3u));
      vec4 dual = vec4(paletteWord(joint + 4u), paletteWord(joint + 5u), paletteWord(joint + 6u), paletteWord(joint + 7u));
      for (uint i = 0u; i < 9u; ++i) stretch[i] = stretch[i] + weight * paletteWord(joint + 8u + i);
      if (pivot.x == 0.0 && pivot.y == 0.0 && pivot.z == 0.0 && pivot.w == 0.0) pivot = r;
      precise float along = (pivot.x * r.x + pivot.y * r.y) + (pivot.z * r.z + pivot.w * r.w);
      float w = along < 0.0 ? -weight : weight;
      q = q + w * r;
      d = d + w * dual;
    }
    precise float squared = (q.x * q.x + q.y * q.y) + (q.z * q.z + q.w * q.w);
    precise float s = 2.0 * (1.0 / squared);
    precise float r[9];
    r[0] = 1.0 - s * (q.y * q.y + q.z * q.z);
    r[1] = s * (q.x * q.y - q.w * q.z);
    r[2] = s * (q.x * q.z + q.w * q.y);
    r[3] = s * (q.x * q.y + q.w * q.z);
    r[4] = 1.0 - s * (q.x * q.x + q.z * q.z);
    r[5] = s * (q.y * q.z - q.w * q.x);
    r[6] = s * (q.x * q.z - q.w * q.y);
    r[7] = s * (q.y * q.z + q.w * q.x);
    r[8] = 1.0 - s * (q.x * q.x + q.y * q.y);
    for (uint row = 0u; row < 3u; ++row)
      for (uint c = 0u; c < 3u; ++c)
        m[4u * row + c] = (r[3u * row] * stretch[c] + r[3u * row + 1u] * stretch[3u + c]) + r[3u * row + 2u] * stretch[6u + c];
    m[3] = s * ((q.w * d.x - d.w * q.x) + (q.y * d.z - q.z * d.y));
    m[7] = s * ((q.w * d.y - d.w * q.y) + (q.z * d.x - q.x * d.z));
    m[11] = s * ((q.w * d.z - d.w * q.z) + (q.x * d.y - q.y * d.x));
  }

  precise float px = ((m[0] * p.x + m[1] * p.y) + m[2] * p.z) + m[3];
  precise float py = ((m[4] * p.x + m[5] * p.y) + m[6] * p.z) + m[7];
  precise float pz = ((m[8] * p.x + m[9] * p.y) + m[10] * p.z) + m[11];
  PosedVertex posed;
  posed.position = vec3(px, py, pz);
  posed.normal = vec3(0.0, 0.0, 0.0);
  posed.tangent = vec4(0.0, 0.0, 0.0, 0.0);
  if (!with_frame) return posed;

  vec3 r0 = vec3(m[0], m[1], m[2]);
  vec3 r1 = vec3(m[4], m[5], m[6]);
  vec3 r2 = vec3(m[8], m[9], m[10]);
  float hand = dot(r0, cross(r1, r2)) < 0.0 ? -1.0 : 1.0;
  posed.normal = unit(hand * vec3(dot(cross(r1, r2), n), dot(cross(r2, r0), n), dot(cross(r0, r1), n)));
  uint rest = restFrame(v) + 3u;
  vec3 t = vec3(restWord(rest), restWord(rest + 1u), restWord(rest + 2u));
  t = vec3(dot(r0, t), dot(r1, t), dot(r2, t));
  posed.tangent = vec4(unit(t - dot(t, posed.normal) * posed.normal), hand * restWord(rest + 3u));
  return posed;
}
