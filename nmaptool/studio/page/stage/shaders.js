/* The pictures: the relief flat on the screen, the relief turned in space, and the sides of its plate. */

/** Flat: one triangle over the whole canvas; every pixel looks up the place of the relief that it shows. */
export const FLAT = `
uniform vec2 corner;         /* vertex of the grid at the lower left corner of the canvas */
uniform vec2 step_px;        /* vertices of the grid per device pixel */
uniform vec3 ground;
out vec4 colour;
void main() {
  vec2 p = corner + gl_FragCoord.xy * step_px;
  vec2 inside = min(p, grid - 1.0 - p) / abs(step_px) + 0.5;
  float is_in = clamp(min(inside.x, inside.y), 0.0, 1.0);
  if (is_in == 0.0) {
    colour = developed(ground);
    return;
  }
  float is_on;
  vec3 tone = look(p, vec3(0.0, 0.0, 1.0), is_on);
  vec3 behind = ground;
#if HOLES
#if OVERLAY == 4
  if (is_in == 1.0) behind = bare_stripes(ground, 1.0);
#endif
  is_in *= smoothstep(0.4, 0.6, is_on);
#endif
  colour = developed(mix(behind, tone, is_in));
}`;

/** Turned: the vertices of a mesh over the grid, lifted by the height. */
export const LIFTED = `
uniform mat4 matrix;
uniform ivec2 mesh;          /* columns and rows of vertices of the mesh */
uniform vec2 unit;           /* px of the map per px of the grid, in the plane and in height */
uniform float bottom;        /* px of the grid */
out vec2 place;
out vec3 world;
out float solid;
void main() {
  ivec2 ij = ivec2(gl_VertexID % mesh.x, gl_VertexID / mesh.x);
  place = vec2(ij) / vec2(mesh - 1) * (grid - 1.0);
  ivec2 nearest = ivec2(place + 0.5);
  solid = step(0.001, texelFetch(surface, nearest, 0).r);
  float z = solid > 0.0 ? at(place) : bottom;
  world = vec3(place * unit.x, z * unit.y);
  gl_Position = matrix * vec4(world, 1.0);
}`;

export const TURNED = `
uniform vec3 eye;
in vec2 place;
in vec3 world;
in float solid;
out vec4 colour;
void main() {
  if (solid < 0.01) discard;
  vec3 view = normalize(eye - world);
  float is_on;
  vec3 tone;
#if HOLES
  vec3 n = normalize(cross(dFdx(world), dFdy(world)));
  if (dot(n, view) < 0.0) n = -n;
  if (solid < 0.99) tone = shade(place, at(place), n, view, 0.9, 0.8);
  else
#endif
    tone = look(place, view, is_on);
  colour = developed(tone);
}`;

/** The four sides of the plate, from its edge down to the back. */
export const SIDES = `
uniform mat4 matrix;
uniform int side;            /* 0 upper, 1 right, 2 lower, 3 left */
uniform int count;           /* vertices along it */
uniform vec2 unit;
uniform float bottom;
out vec2 place;
out vec3 world;
void main() {
  float share = float(gl_VertexID / 2) / float(count - 1);
  vec2 most = grid - 1.0;
  place = side == 0 ? vec2(share * most.x, 0.0) : side == 1 ? vec2(most.x, share * most.y)
        : side == 2 ? vec2(share * most.x, most.y) : vec2(0.0, share * most.y);
  float is_on = step(0.001, texelFetch(surface, ivec2(place + 0.5), 0).r);
  bool is_top = gl_VertexID % 2 == 0 && is_on > 0.0;
  world = vec3(place * unit.x, (is_top ? at(place) : bottom) * unit.y);
  gl_Position = matrix * vec4(world, 1.0);
}`;

export const SIDE = `
uniform vec3 eye;
uniform vec3 outward;
uniform vec2 unit;
uniform float bottom;
in vec2 place;
in vec3 world;
out vec4 colour;
void main() {
  vec3 view = normalize(eye - world);
  float z = world.z / unit.y;
  vec2 grained = place + vec2(0.0, bottom - z) * abs(outward.y) + vec2(bottom - z, 0.0) * abs(outward.x);
  colour = developed(shade(grained, z, outward, view, 0.85, 1.0));
}`;

/** The ground behind the turned relief: lighter above. */
export const BACKDROP = `#version 300 es
precision highp float;
uniform vec3 ground;
uniform vec2 size;
out vec4 colour;
void main() {
  float share = gl_FragCoord.y / size.y;
  float grainy = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  colour = vec4(pow(ground * (0.75 + 0.9 * share), vec3(1.0 / 2.2)) + grainy / 255.0, 1.0);
}`;
