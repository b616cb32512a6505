// Posed vertices: morphs, then linear blend skinning. The expression order is that of src/deform.cpp.

FURROW_READ(0, float, rest_vertices);
FURROW_READ(1, uint, influences);
FURROW_READ(2, uint, morph_entries);
FURROW_READ(3, float, palette);
FURROW_READ(4, float, morph_weights);

struct PosedVertex {
  vec3 position;
  vec3 normal;
  vec4 tangent;
};

vec3 unit(vec3 v) {
  float squared = v.x * v.x + v.y * v.y + v.z * v.z;
  return squared > 0.0 ? v / sqrt(squared) : vec3(0.0, 1.0, 0.0);
}

PosedVertex poseVertex(uint v) {
  uint rest = v * kRestVertexWords;
  precise float x = FURROW_AT(rest_vertices, rest);
  precise float y = FURROW_AT(rest_vertices, rest + 1u);
  precise float z = FURROW_AT(rest_vertices, rest + 2u);
  vec3 n = vec3(FURROW_AT(rest_vertices, rest + 3u), FURROW_AT(rest_vertices, rest + 4u),
                FURROW_AT(rest_vertices, rest + 5u));

  if (frame.morphs != 0u) {
    uint entries = frame.vertices + 1u;
    uint end = FURROW_AT(morph_entries, v + 1u);
    for (uint i = FURROW_AT(morph_entries, v); i < end; ++i) {
      uint word = entries + 4u * i;
      uint morph = FURROW_AT(morph_entries, word + 3u);
      float step = FURROW_AT(morph_weights, 2u * morph);
      if (step == 0.0) continue;
      uint dx = FURROW_AT(morph_entries, word);
      uint dy = FURROW_AT(morph_entries, word + 1u);
      uint dz = FURROW_AT(morph_entries, word + 2u);
      x = x + step * float(signed24(dx));
      y = y + step * float(signed24(dy));
      z = z + step * float(signed24(dz));
      n += FURROW_AT(morph_weights, 2u * morph + 1u) *
           vec3(float(signed8(dx >> 24)), float(signed8(dy >> 24)), float(signed8(dz >> 24)));
    }
  }

  precise float m[12];
  for (uint i = 0u; i < 12u; ++i) m[i] = 0.0;
  for (uint k = 0u; k < frame.influences; ++k) {
    uint influence = FURROW_AT(influences, v * frame.influences + k);
    if ((influence >> 16) == 0u) continue;
    precise float weight = float(influence >> 16) * 1.52590219e-5;
    uint joint = (influence & 0xffffu) * 12u;
    for (uint i = 0u; i < 12u; ++i) m[i] = m[i] + weight * FURROW_AT(palette, joint + i);
  }

  precise float px = ((m[0] * x + m[1] * y) + m[2] * z) + m[3];
  precise float py = ((m[4] * x + m[5] * y) + m[6] * z) + m[7];
  precise float pz = ((m[8] * x + m[9] * y) + m[10] * z) + m[11];
  PosedVertex posed;
  posed.position = vec3(px, py, pz);
  posed.normal = vec3(0.0, 0.0, 0.0);
  posed.tangent = vec4(0.0, 0.0, 0.0, 0.0);
  if (frame.with_normals == 0u) return posed;

  vec3 r0 = vec3(m[0], m[1], m[2]);
  vec3 r1 = vec3(m[4], m[5], m[6]);
  vec3 r2 = vec3(m[8], m[9], m[10]);
  float hand = dot(r0, cross(r1, r2)) < 0.0 ? -1.0 : 1.0;
  n = unit(hand * vec3(dot(cross(r1, r2), n), dot(cross(r2, r0), n), dot(cross(r0, r1), n)));
  vec3 t = vec3(FURROW_AT(rest_vertices, rest + 6u), FURROW_AT(rest_vertices, rest + 7u),
                FURROW_AT(rest_vertices, rest + 8u));
  t = vec3(dot(r0, t), dot(r1, t), dot(r2, t));
  posed.normal = n;
  posed.tangent = vec4(unit(t - dot(t, n) * n), hand * FURROW_AT(rest_vertices, rest + 9u));
  return posed;
}
