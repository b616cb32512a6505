// The thin layer between furrow's shader texts and the shading language: OpenGL 3.3, buffers as textures.
#ifndef GL_ARB_gpu_shader5
#define precise
#endif
#define FURROW_TEXELS_float samplerBuffer
#define FURROW_TEXELS_uint usamplerBuffer
#define FURROW_READ(slot, type, name) uniform FURROW_TEXELS_##type name
#define FURROW_AT(name, index) texelFetch(name, int(index)).x

layout(std140) uniform frame_block { FrameConstants frame; };
uniform uint item;  // Item::slice
