// q of a triangle goes to its corners.

in vec3 corner_position[];

uint layerOf(uint channel) {
  return channel == 0u ? frame.slice[item].layer0 : channel == 1u ? frame.slice[item].layer1 : frame.slice[item].layer2;
}

void main() {
  precise vec3 e1 = corner_position[1] - corner_position[0];
  precise vec3 e2 = corner_position[2] - corner_position[0];
  vec3 q = vec3(0.0, 0.0, 0.0);
  uint word = recordOf() + 3u;
  for (uint channel = 0u; channel < kLayersASlice && layerOf(channel) != kNoLayer; ++channel) {
    uint measure = frame.layer[layerOf(channel)].measure;
    uint count = coefficientCount(measure);
    vec3 c = vec3(FURROW_AT(measured, word), 0.0, 0.0);
    if (count > 1u) c.y = FURROW_AT(measured, word + 1u);
    if (count > 2u) c.z = FURROW_AT(measured, word + 2u);
    q[channel] = measureTriangle(measure, e1, e2, c);
    word += count;
  }
  for (int i = 0; i < 3; ++i) addCorner(i, q);
}
