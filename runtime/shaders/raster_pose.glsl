// Posed vertices, captured by transform feedback.

out vec3 posed_position;
out vec3 posed_normal;
out vec4 posed_tangent;

void main() {
  PosedVertex posed = poseVertex(uint(gl_VertexID));
  posed_position = posed.position;
  posed_normal = posed.normal;
  posed_tangent = posed.tangent;
  gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
}
