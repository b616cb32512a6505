// The corners of a triangle with q of their points.

FURROW_READ(1, uint, vertex_point);

flat out vec3 corner_q;
flat out uint corner_point;

void main() {
  corner_point = FURROW_AT(vertex_point, gl_VertexID);
  corner_q = sliceQ(corner_point, item);
  gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
}
