// The corners of a triangle [Oat].

FURROW_READ(0, float, positions);
FURROW_READ(1, uint, vertex_point);

out vec3 corner_position;
flat out uint corner_point;

void main() {
  uint word = 3u * uint(gl_VertexID);
  corner_position = vec3(FURROW_AT(positions, word), FURROW_AT(positions, word + 1u), FURROW_AT(positions, word + 2u));
  corner_point = FURROW_AT(vertex_point, gl_VertexID);
  gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
}
