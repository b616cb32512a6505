// Weights of each vertex, two layers a word.

FURROW_READ(4, float, next_state);

flat out uint pair0;
flat out uint pair1;
flat out uint pair2;
flat out uint pair3;
flat out uint pair4;
flat out uint pair5;
flat out uint pair6;
flat out uint pair7;

uint weight16(uint v, uint layer) {
  if (layer >= frame.layers) return 0u;
  if (frame.with_ease != 0u) return stored(FURROW_AT(next_state, stateOf(v, layer)));
  return isActive(layer) ? stored(weightOf(v, layer, pointQ(v, layer))) : 0u;
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
