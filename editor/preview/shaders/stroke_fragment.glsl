in Ribbon {
  vec2 at;
  float confidence;
  float facing;
} ribbon;

layout(location = 0) out vec4 color;

void main() {
  const vec3 unsure = vec3(0.09, 0.11, 0.14), sure = vec3(1.0, 0.55, 0.08);
  float taper = 1.0 - pow(abs(ribbon.at.x), 3.0);
  float edge = 1.0 - smoothstep(taper * 0.6, taper + 0.001, abs(ribbon.at.y));
  vec3 tint = mix(unsure, sure, sqrt(clamp(ribbon.confidence, 0.0, 1.0)));
  color = vec4(tint, edge * smoothstep(0.0, 0.35, ribbon.facing));
}
