#version 330
#extension GL_GOOGLE_include_directive : require
#include "pixel.glsl"
