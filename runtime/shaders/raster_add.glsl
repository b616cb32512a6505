// A pixel for each corner of a triangle, at its point's place among the sums, where blending adds it up [Oat].

FURROW_READ(2, float, measured);

layout(triangles) in;
layout(points, max_vertices = 3) out;

flat in uint corner_point[];
out vec4 angle_sum;

uint recordOf() { return frame.slice[item].first_word + frame.slice[item].record_words * uint(gl_PrimitiveIDIn); }

void addCorner(int corner, vec3 q) {
  float angle = FURROW_AT(measured, recordOf() + uint(corner));
  uint point = corner_point[corner];
  vec2 size = vec2(float(kSumsWidth), float(frame.sums_height));
  angle_sum = vec4(q * angle, angle);
  gl_Position = vec4((vec2(float(point % kSumsWidth), float(point / kSumsWidth)) + 0.5) / size * 2.0 - 1.0, 0.0, 1.0);
  EmitVertex();
  EndPrimitive();
}
