#version 330 core
// positions come as the picture's own coordinates, -1 to 1
layout(location = 0) in vec3 position;

void main()
{
    gl_Position = vec4(position, 1.0);
}
