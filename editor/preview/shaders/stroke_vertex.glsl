layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 tangent;
layout(location = 12) in vec4 value;  // confidence, d along tangent and bitangent

out Stroke {
  vec3 position;
  vec3 normal;
  vec3 direction;
  float confidence;
} vertex;

void main() {
  vec3 along = tangent.xyz * value.y + tangent.w * cross(normal, tangent.xyz) * value.z;
  vertex.position = position;
  vertex.normal = normal;
  vertex.direction = along / max(length(along), 1e-20);
  vertex.confidence = value.x;
}
