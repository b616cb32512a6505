// A posed vertex, which reads the morph targets that move it by itself.

FURROW_READ(2, uint, morph_entries);

PosedVertex poseVertex(uint v) {
  precise vec3 p = restPosition(v);
  vec3 n = frame.with_normals != 0u ? restNormal(v) : vec3(0.0, 0.0, 0.0);
  if (frame.morphs != 0u) {
    uint entries = frame.vertices + 1u;
    uint end = FURROW_AT(morph_entries, v + 1u);
    for (uint i = FURROW_AT(morph_entries, v); i < end; ++i) {
      uint word = entries + kEntryWords * i;
      uint morph = FURROW_AT(morph_entries, word + 3u);
      float step = positionStep(morph), normal_step = normalStep(morph);
      if (step == 0.0 && normal_step == 0.0) continue;
      uint dx = FURROW_AT(morph_entries, word);
      uint dy = FURROW_AT(morph_entries, word + 1u);
      uint dz = FURROW_AT(morph_entries, word + 2u);
      p.x = p.x + step * float(signed24(dx));
      p.y = p.y + step * float(signed24(dy));
      p.z = p.z + step * float(signed24(dz));
      n += normal_step * vec3(float(signed8(dx >> 24)), float(signed8(dy >> 24)), float(signed8(dz >> 24)));
    }
  }
  return skin(v, p, n, frame.with_normals != 0u);
}
