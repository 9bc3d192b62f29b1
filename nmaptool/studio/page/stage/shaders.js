/* The picture of a relief: one triangle over the whole canvas; every pixel looks its height up in a texture. */

export const VERTEX = `#version 300 es
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}`;

export const FRAGMENT = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D heights;   /* red: height in px, green: 1 on the surface */
uniform vec2 grid;           /* columns and rows of vertices */
uniform vec2 origin;         /* vertex at the upper left corner of the canvas */
uniform float zoom;          /* device pixels per vertex */
uniform float canvas_height;
uniform vec3 light;          /* unit vector to the key light: x right, y down, z to the viewer */
uniform vec3 albedo;
uniform vec2 gloss;          /* strength and exponent of the highlight */
uniform float grain;         /* strength of wood grain or marble veins */
uniform int material;        /* 0 plain, 1 wood, 2 marble */
uniform int overlay;         /* 0 none, 1 heights, 2 slope */
uniform vec2 range;          /* lowest and highest height in px */
uniform float contour;       /* px between contour lines */
uniform int steps;           /* of the shadow; 0: none */
uniform vec3 ground;
out vec4 colour;

vec2 at(vec2 p) {
  vec2 q = clamp(p, vec2(0.0), grid - 1.001);
  ivec2 i = ivec2(q);
  vec2 f = q - vec2(i);
  vec2 a = texelFetch(heights, i, 0).rg;
  vec2 b = texelFetch(heights, i + ivec2(1, 0), 0).rg;
  vec2 c = texelFetch(heights, i + ivec2(0, 1), 0).rg;
  vec2 d = texelFetch(heights, i + ivec2(1, 1), 0).rg;
  return mix(mix(a, b, f.x), mix(c, d, f.x), f.y);
}

/* Share of the key light that reaches a point: the highest angle on the way to the light, softened. */
float lit(vec2 p, float z) {
  if (steps == 0) return 1.0;
  vec2 way = light.xy / max(length(light.xy), 1e-4);
  float rise = light.z / max(length(light.xy), 1e-4);
  float far = min((range.y - z) / max(rise, 1e-3), 0.6 * max(grid.x, grid.y));
  float open = 1.0;
  float jump = max(far / float(steps), 1.0);
  float t = 1.5;
  for (int i = 0; i < 64; i++) {
    if (i >= steps || t > far) break;
    float above = at(p + way * t).r - (z + rise * t);
    open = min(open, 1.0 - clamp(0.5 + above / (0.06 * t + 0.6), 0.0, 1.0));
    t += jump;
  }
  return smoothstep(0.0, 0.5, open);
}

float noise(vec2 p) {
  vec2 i = floor(p), f = fract(p);
  f = f * f * (3.0 - 2.0 * f);
  vec4 h = fract(sin(vec4(dot(i, vec2(12.9, 78.2)), dot(i + vec2(1, 0), vec2(12.9, 78.2)),
                          dot(i + vec2(0, 1), vec2(12.9, 78.2)), dot(i + vec2(1, 1), vec2(12.9, 78.2)))) * 43758.5);
  return mix(mix(h.x, h.y, f.x), mix(h.z, h.w, f.x), f.y);
}

vec3 stuff(vec2 p, float z) {
  vec2 q = p / max(grid.x, grid.y);
  if (material == 1) {
    float rings = q.y * 42.0 + 3.0 * noise(q * vec2(3.0, 9.0)) + 0.02 * z;
    float line = 0.5 + 0.5 * sin(6.2832 * rings);
    return albedo * (1.0 - grain * line * line - 0.3 * grain * noise(q * vec2(30.0, 400.0)));
  }
  if (material == 2) {
    float vein = abs(sin(9.0 * (q.x + q.y) + 5.0 * noise(q * 6.0) + 2.5 * noise(q * 17.0)));
    return albedo * (1.0 - grain * pow(1.0 - vein, 8.0));
  }
  return albedo;
}

vec3 scale_of(float t) {
  return clamp(vec3(1.5 - abs(4.0 * t - 3.0), 1.5 - abs(4.0 * t - 2.0), 1.5 - abs(4.0 * t - 1.0)), 0.0, 1.0);
}

void main() {
  vec2 p = origin + vec2(gl_FragCoord.x, canvas_height - gl_FragCoord.y) / zoom;
  vec2 here = at(p);
  if (p.x < 0.0 || p.y < 0.0 || p.x > grid.x - 1.0 || p.y > grid.y - 1.0 || here.g < 0.5) {
    colour = vec4(ground, 1.0);
    return;
  }
  float e = max(1.0, 1.0 / zoom);
  vec2 slope = vec2(at(p + vec2(e, 0)).r - at(p - vec2(e, 0)).r, at(p + vec2(0, e)).r - at(p - vec2(0, e)).r) / (2.0 * e);
  vec3 n = normalize(vec3(-slope, 1.0));
  float key = max(dot(n, light), 0.0) * lit(p, here.r);
  float sky = 0.5 + 0.5 * dot(n, normalize(vec3(-light.xy * 0.6, 0.8)));
  vec3 half_way = normalize(light + vec3(0, 0, 1));
  float shine = gloss.x * pow(max(dot(n, half_way), 0.0), gloss.y) * step(0.001, key);
  /* hollows get less of the sky */
  float mean = 0.0;
  for (int i = 0; i < 8; i++) {
    float a = 0.7854 * float(i);
    mean += at(p + 5.0 * vec2(cos(a), sin(a))).r;
  }
  float hollow = clamp(1.0 - 0.09 * max(mean / 8.0 - here.r, 0.0), 0.45, 1.0);
  vec3 made = stuff(p, here.r);
  vec3 tone = made * (1.05 * key + 0.26 * sky * hollow) + shine * mix(vec3(1.0), albedo, 0.4);
  if (overlay == 1) {
    float t = (here.r - range.x) / max(range.y - range.x, 1e-6);
    float line = abs(fract(here.r / contour - 0.5) - 0.5) * contour / max(length(slope), 1e-3);
    tone = scale_of(t) * (0.45 + 0.55 * key) * mix(0.35, 1.0, smoothstep(0.4, 1.2, line * zoom));
  } else if (overlay == 2) {
    tone = scale_of(clamp(atan(length(slope)) / 1.5708, 0.0, 1.0)) * (0.6 + 0.4 * key);
  }
  colour = vec4(pow(clamp(tone, 0.0, 1.0), vec3(1.0 / 2.2)), 1.0);
}`;
