// The thin layer between furrow's shader texts and the shading language: OpenGL 3.3, buffers as textures.
#ifndef GL_ARB_gpu_shader5
#define precise
#endif
#define FURROW_TEXELS_float samplerBuffer
#define FURROW_TEXELS_uint usamplerBuffer
#define FURROW_READ(slot, type, name) uniform FURROW_TEXELS_##type name
#define FURROW_UNIFORM(slot, type, name) layout(std140) uniform name##_block { type name; }
#define FURROW_AT(name, index) texelFetch(name, int(index)).x

uniform uint item;  // Item::slice
