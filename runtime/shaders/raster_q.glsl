// q of a vertex's point in a layer: the sums are divided as they are fetched.

FURROW_READ(0, uint, vertex_point);
uniform sampler2DArray sums;

float pointQ(uint v, uint layer) {
  if (frame.layer[layer].slice == kNoLayer) return 1.0;
  uint point = FURROW_AT(vertex_point, v);
  vec4 sum = texelFetch(sums, ivec3(int(point % kSumsWidth), int(point / kSumsWidth), int(frame.layer[layer].slice)), 0);
  return sum.a > 0.0 ? sum[frame.layer[layer].channel] / sum.a : 1.0;
}
