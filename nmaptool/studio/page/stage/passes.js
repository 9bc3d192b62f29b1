/*
 * What is computed once for each relief or light, at each vertex of a grid: slopes, ambient occlusion, and how far the
 * shadow of the first light lies above the surface. The picture then looks it up, flat or turned.
 */

export const WHOLE = `#version 300 es
void main() {
  gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 0.0, 1.0);
}`;

/** Reading heights between vertices: by the card, or by hand where it does not interpolate 32-bit numbers. */
export const HEIGHTS = (isLinear) => `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D heights;   /* px of the grid */
uniform sampler2D surface;   /* 1/255 on the surface */
uniform vec2 grid;           /* columns and rows of vertices */
float at(vec2 p) {
  ${
    isLinear
      ? "return texture(heights, (p + 0.5) / grid).r;"
      : `vec2 q = clamp(p, vec2(0.0), grid - 1.0);
  ivec2 i = ivec2(q), j = min(i + 1, ivec2(grid) - 1);
  vec2 f = q - vec2(i);
  return mix(mix(texelFetch(heights, i, 0).r, texelFetch(heights, ivec2(j.x, i.y), 0).r, f.x),
             mix(texelFetch(heights, ivec2(i.x, j.y), 0).r, texelFetch(heights, j, 0).r, f.x), f.y);`
  }
}
`;

/* Red, green: slopes dz/dx and dz/dy (y down), 0 off the surface; blue: whether it is on the surface. The weights of Scharr's filter
   also smooth the steps that 16 bits leave; QUICK leaves that out. At the edge of the surface the slope goes to one side. */
export const SLOPES = `
out vec4 found;
float on(ivec2 i) {
  return step(0.001, texelFetch(surface, clamp(i, ivec2(0), ivec2(grid) - 1), 0).r);
}
float z(ivec2 i, float own) {
  i = clamp(i, ivec2(0), ivec2(grid) - 1);
  float height = texelFetch(heights, i, 0).r;
#if HOLES
  if (on(i) == 0.0) return own;
#endif
  return height;
}
void main() {
  ivec2 i = ivec2(gl_FragCoord.xy);
  float own = texelFetch(heights, i, 0).r;
  float n = z(i + ivec2(0, -1), own), w = z(i + ivec2(-1, 0), own);
  float e = z(i + ivec2(1, 0), own), s = z(i + ivec2(0, 1), own);
#if QUICK
  vec2 slope = 0.5 * vec2(e - w, s - n);
#else
  float nw = z(i + ivec2(-1, -1), own), ne = z(i + ivec2(1, -1), own);
  float sw = z(i + ivec2(-1, 1), own), se = z(i + ivec2(1, 1), own);
  vec2 slope = vec2(3.0 * (ne - nw + se - sw) + 10.0 * (e - w), 3.0 * (sw - nw + se - ne) + 10.0 * (s - n)) / 32.0;
#endif
  /* at an edge the difference spans one px, not two */
  vec2 last = vec2(1.0) + vec2(equal(i, ivec2(0))) + vec2(equal(i, ivec2(grid) - 1));
  float is_on = 1.0;
#if HOLES
  is_on = on(i);
  last += 2.0 - vec2(on(i + ivec2(1, 0)) + on(i - ivec2(1, 0)), on(i + ivec2(0, 1)) + on(i - ivec2(0, 1)));
  last = min(last, 2.0);
#endif
  found = vec4(clamp(slope * last, -200.0, 200.0) * is_on, is_on, 1.0);
}`;

/* Share of the sky that a vertex sees: the horizon in 8 directions, above the tangent plane. */
export const OCCLUSION = `
uniform sampler2D slopes;
uniform vec2 target;         /* size of the result */
uniform float reach;         /* px of the grid */
uniform int taps;
out vec4 found;
void main() {
  vec2 p = gl_FragCoord.xy / target * grid - 0.5;
  float own = at(p);
  vec2 slope = texture(slopes, (p + 0.5) / grid).rg;
  vec2 cell = mod(floor(gl_FragCoord.xy), 2.0);
  float turn = (cell.x + 2.0 * cell.y) * 0.19635;
  float closed = 0.0;
  float least = max(1.5, 0.75 * grid.x / target.x);
  for (int k = 0; k < 8; k++) {
    float angle = 0.785398 * float(k) + turn;
    vec2 way = vec2(cos(angle), sin(angle));
    float flat_slope = dot(slope, way);
    float tangent = flat_slope * inversesqrt(1.0 + flat_slope * flat_slope);
    float most = 0.0;
    for (int tap = 0; tap < 8; tap++) {
      if (tap >= taps) break;
      float far = least * pow(reach / least, (float(tap) + 0.5) / float(taps));
      vec2 q = p + far * way;
      if (any(lessThan(q, vec2(-0.5))) || any(greaterThan(q, grid - 0.5))) break;
      float rise = (at(q) - own) / far;
      float seen = rise * inversesqrt(1.0 + rise * rise) - tangent;
      most = max(most, (seen - 0.02) * (1.0 - 0.6 * far / reach));
    }
    closed += most;
  }
  found = vec4(clamp(1.0 - closed / 8.0, 0.0, 1.0));
}`;

/* Red: how far the highest shadow lies above the vertex; green: how far away the vertex is that casts it. With each
   pass the way towards the light that is looked at doubles, so every step of it is seen. */
export const SHADOW = `
uniform sampler2D before;    /* the pass before */
uniform vec2 target;
uniform vec2 way;            /* to the light in the picture, unit vector */
uniform float rise;          /* of a ray per px */
uniform float far;           /* px of the grid that the pass before looked at; 0: there was none */
uniform float pace;          /* px of the grid of the first step */
out vec4 found;
const float NONE = -1000.0;
void main() {
  vec2 p = gl_FragCoord.xy / target * grid - 0.5;
  float jump = far == 0.0 ? pace : far;
  vec2 q = p + jump * way;
  float above = at(q) - at(p) - jump * rise;
  bool is_out = any(lessThan(q, vec2(0.0))) || any(greaterThan(q, grid - 1.0));
  if (far == 0.0) {
    found = is_out ? vec4(NONE, jump, 0.0, 1.0) : vec4(max(above, NONE), jump, 0.0, 1.0);
    return;
  }
  vec2 near = texture(before, (p + 0.5) / grid).rg;
  found = vec4(near, 0.0, 1.0);
  if (is_out) return;
  vec2 next = texture(before, (q + 0.5) / grid).rg;
  float higher = max(next.x + above, NONE);
  if (higher > near.x) found = vec4(higher, next.y + jump, 0.0, 1.0);
}`;
