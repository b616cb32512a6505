// A pixel for each corner of a triangle, at its point's place among the sums, where blending adds it up [Oat].

FURROW_READ(2, float, measured);

layout(triangles) in;
layout(points, max_vertices = 3) out;

in vec3 corner_position[];
flat in uint corner_point[];
out vec4 angle_sum;

uint layerOf(uint channel) {
  return channel == 0u ? frame.slice[item].layer0 : channel == 1u ? frame.slice[item].layer1 : frame.slice[item].layer2;
}

void main() {
  uint record = frame.slice[item].first_word + frame.slice[item].record_words * uint(gl_PrimitiveIDIn);
  precise vec3 e1 = corner_position[1] - corner_position[0];
  precise vec3 e2 = corner_position[2] - corner_position[0];
  vec3 q = vec3(0.0, 0.0, 0.0);
  uint word = record + 3u;
  for (uint channel = 0u; channel < kLayersASlice && layerOf(channel) != kNoLayer; ++channel) {
    uint measure = frame.layer[layerOf(channel)].measure;
    uint count = coefficientCount(measure);
    vec3 c = vec3(FURROW_AT(measured, word), 0.0, 0.0);
    if (count > 1u) c.y = FURROW_AT(measured, word + 1u);
    if (count > 2u) c.z = FURROW_AT(measured, word + 2u);
    q[channel] = measureTriangle(measure, e1, e2, c);
    word += count;
  }
  vec2 size = vec2(float(kSumsWidth), float(frame.sums_height));
  for (int i = 0; i < 3; ++i) {
    float angle = FURROW_AT(measured, record + uint(i));
    uint point = corner_point[i];
    angle_sum = vec4(q * angle, angle);
    gl_Position = vec4((vec2(float(point % kSumsWidth), float(point / kSumsWidth)) + 0.5) / size * 2.0 - 1.0, 0.0, 1.0);
    EmitVertex();
    EndPrimitive();
  }
}
