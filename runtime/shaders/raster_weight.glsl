// Weights of each vertex, two layers a word: the sums are divided as they are fetched.

FURROW_READ(0, uint, vertex_point);
uniform sampler2DArray sums;

flat out uint pair0;
flat out uint pair1;
flat out uint pair2;
flat out uint pair3;
flat out uint pair4;
flat out uint pair5;
flat out uint pair6;
flat out uint pair7;

uint weight16(uint v, uint layer) {
  if (layer >= frame.layers || !isActive(layer)) return 0u;
  float q = 1.0;
  if (frame.layer[layer].slice != kNoLayer) {
    uint point = FURROW_AT(vertex_point, v);
    vec4 sum = texelFetch(sums, ivec3(int(point % kSumsWidth), int(point / kSumsWidth), int(frame.layer[layer].slice)), 0);
    if (sum.a > 0.0) q = sum[frame.layer[layer].channel] / sum.a;
  }
  return stored(weightOf(v, layer, q));
}

uint pairOf(uint pair) {
  uint v = uint(gl_VertexID);
  return 2u * pair < frame.layers ? weight16(v, 2u * pair) | (weight16(v, 2u * pair + 1u) << 16) : 0u;
}

void main() {
  pair0 = pairOf(0u);
  pair1 = pairOf(1u);
  pair2 = pairOf(2u);
  pair3 = pairOf(3u);
  pair4 = pairOf(4u);
  pair5 = pairOf(5u);
  pair6 = pairOf(6u);
  pair7 = pairOf(7u);
  gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
}
