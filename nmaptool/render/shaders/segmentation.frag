#version 330 core
// the number of the face, counted from 1, in four bytes
out vec4 frag_color;

void main()
{
    uint number = uint(gl_PrimitiveID) + 1u;
    uvec4 bytes = uvec4(number, number >> 8, number >> 16, number >> 24) & 255u;
    frag_color = vec4(bytes) / 255.0;
}
