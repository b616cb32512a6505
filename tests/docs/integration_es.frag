#version 300 es
#extension GL_GOOGLE_include_directive : require
precision highp float;
precision highp int;
precision highp sampler2DArray;
#include "pixel.glsl"
