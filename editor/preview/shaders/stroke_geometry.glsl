layout(points) in;
layout(triangle_strip, max_vertices = 4) out;

in Stroke {
  vec3 position;
  vec3 normal;
  vec3 direction;
  float confidence;
} vertex[];

out Ribbon {
  vec2 at;  // [-1, 1] along and across
  float confidence;
  float facing;
} ribbon;

void main() {
  vec3 middle = vertex[0].position, along = vertex[0].direction * scene.size.z * 0.5;
  float facing = dot(normalize(vertex[0].normal), normalize(scene.eye.xyz - middle));
  if (dot(along, along) == 0.0 || facing <= 0.0) return;
  vec4 ends[2];
  ends[0] = scene.view_projection * vec4(middle - along, 1.0);
  ends[1] = scene.view_projection * vec4(middle + along, 1.0);
  if (ends[0].w <= 0.0 || ends[1].w <= 0.0) return;
  vec2 line = (ends[1].xy / ends[1].w - ends[0].xy / ends[0].w) * scene.size.xy;
  vec2 across = vec2(-line.y, line.x) / max(length(line), 1e-6) * scene.size.w / scene.size.xy;
  for (int i = 0; i < 4; ++i) {
    vec4 end = ends[i / 2];
    float sign = i % 2 == 0 ? -1.0 : 1.0;
    ribbon.at = vec2(i / 2 == 0 ? -1.0 : 1.0, sign);
    ribbon.confidence = vertex[0].confidence;
    ribbon.facing = facing;
    end.xy += across * sign * end.w;
    // Lifted towards the eye by a stroke's length, so that it does not sink into the curved surface.
    vec4 lifted = scene.view_projection * vec4(middle + normalize(scene.eye.xyz - middle) * scene.size.z * 0.5, 1.0);
    end.z = min(end.z / end.w, lifted.z / lifted.w) * end.w;
    gl_Position = end;
    EmitVertex();
  }
  EndPrimitive();
}
