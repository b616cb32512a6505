// The thin layer between furrow's shader texts and the shading language: compute shaders, GLSL 4.30 or, for
// SPIR-V, Vulkan's (descriptor set 0 storage buffers, 1 uniform buffers).
#ifdef VULKAN
#define FURROW_SET(number) set = number,
#else
#define FURROW_SET(number)
#endif
#define FURROW_READ(slot, type, name) layout(FURROW_SET(0) std430, binding = slot) restrict readonly buffer name##_block { type name[]; }
#define FURROW_WRITE(slot, type, name) layout(FURROW_SET(0) std430, binding = slot) restrict writeonly buffer name##_block { type name[]; }
#define FURROW_UPDATE(slot, type, name) layout(FURROW_SET(0) std430, binding = slot) restrict buffer name##_block { type name[]; }
#define FURROW_UNIFORM(slot, type, name) layout(FURROW_SET(1) std140, binding = slot) uniform name##_block { type name; }
#define FURROW_AT(name, index) name[index]
#define FURROW_SHARED shared
#define FURROW_GLOBAL
#define FURROW_SYNC memoryBarrierShared(); barrier()
#define FURROW_MAIN void main()
#define furrow_group gl_WorkGroupID
#define furrow_thread gl_LocalInvocationID.x

layout(local_size_x = 128) in;  // kGroupSize
