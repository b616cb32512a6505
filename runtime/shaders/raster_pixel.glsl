in vec4 angle_sum;
layout(location = 0) out vec4 sum;

void main() { sum = angle_sum; }
