// kHoles (whether the part's colour map has any) is a constant.

in vec2 place;

uniform sampler2DArray base_color_map;

void main() {
  if (!kHoles) return;
  vec2 at = mat2(material.color_uv.xy, material.color_uv.zw) * place + material.color_at_normal_at.xy;
  if (material.base_color.a * texture(base_color_map, vec3(at, 0.0)).a < material.opaque_from) discard;
}
