// The thin layer between furrow's shader texts and the shading language: compute shaders.
#define FURROW_READ(slot, type, name) layout(std430, binding = slot) restrict readonly buffer name##_block { type name[]; }
#define FURROW_WRITE(slot, type, name) layout(std430, binding = slot) restrict writeonly buffer name##_block { type name[]; }
#define FURROW_AT(name, index) name[index]

layout(local_size_x = 128) in;  // kGroupSize
layout(std140, binding = 0) uniform frame_block { FrameConstants frame; };

// Index of this invocation; work-groups are laid out in two dimensions because one holds 65535 at most.
uint invocationIndex() { return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * kGroupSize + gl_LocalInvocationID.x; }
