/*
 * How a point of the relief looks: materials, lights and overlays. Used by the flat and by the turned picture. What is
 * not needed is left out before the program is built: a processor would compute it for every pixel.
 */

/** The choices that a program is built for: numbers by name. */
export const CHOICES = ["MATERIAL", "METAL", "GLOSS", "OVERLAY", "LIGHTS", "SHADOW", "HOLES"];

export const SHADING = `
uniform sampler2D slopes;
uniform sampler2D occlusion;
uniform sampler2D shadow;
uniform sampler2D noise;     /* red, green: clouds; blue: grain */
uniform sampler2D palette;
uniform sampler2D layer;     /* curl or coverage from the studio */
uniform vec3 to_light[LIGHTS];    /* x right, y down, z to the viewer */
uniform float strength[LIGHTS];
uniform vec3 albedo;
uniform vec3 hollow;         /* colour of what gathers in hollows: patina, dirt */
uniform vec3 finish;         /* share of mirror, roughness, how far light spreads inside */
uniform vec2 range;          /* lowest and highest height in px of the grid */
uniform vec2 contour;        /* px between contour lines; how many make a thicker one */
uniform float steepest;      /* slope that the draft angle allows */

vec3 dry(vec2 p, float z) {
  vec2 q = p / max(grid.x, grid.y);
#if MATERIAL == 1
    /* growth rings about an axis below the plate: carving deeper shows other rings */
    float deep = 0.9 - z / max(grid.x, grid.y);
    vec4 wave = texture(noise, q * vec2(0.35, 1.1));
    float ring = 46.0 * length(vec2(q.y - 0.42 + 0.10 * (wave.r - 0.5), deep)) + 2.2 * (wave.g - 0.5);
    float late = smoothstep(0.15, 0.95, fract(ring)) * (1.0 - smoothstep(0.95, 1.0, fract(ring)));
    float pores = texture(noise, q * vec2(2.0, 38.0)).b;
    float streak = texture(noise, q * vec2(1.2, 15.0) + 0.3).r;
    vec3 wood = mix(albedo * 1.35, albedo * 0.62, 0.75 * late);
    return wood * (0.78 + 0.44 * streak) * (1.0 - 0.45 * smoothstep(0.68, 0.86, pores));
#elif MATERIAL == 2
    vec2 bent = q + 0.16 * (texture(noise, q * 0.9).rg - 0.5);
    float cloud = texture(noise, bent * 0.6 + 0.2).g;
    float vein = abs(texture(noise, bent * 0.75).r - 0.5);
    float thin = abs(texture(noise, bent * 1.7 + 0.5).g - 0.5);
    float dark = 0.30 * exp(-70.0 * vein) + 0.14 * exp(-90.0 * thin) + 0.14 * smoothstep(0.45, 0.8, cloud);
    return mix(albedo, vec3(0.28, 0.30, 0.33), dark);
#else
  return albedo;
#endif
}

/* A studio with a bright ceiling, a window on one side, a dark floor and a horizon, blurred by the roughness. */
vec3 room(vec3 r, float rough) {
  float soft = 0.12 + 0.6 * rough;
  float up = -r.y * 0.75 - r.x * 0.25;
  float sky = smoothstep(-soft, 0.35 + soft, up);
  float strip = smoothstep(0.5 * soft, 0.0, abs(up - 0.52) - 0.14);
  float window = smoothstep(soft, 0.0, length(max(abs(vec2(r.x + 0.55, r.y + 0.25)) - vec2(0.16, 0.34), 0.0)));
  float dim = smoothstep(soft + 0.1, 0.0, length(max(abs(vec2(r.x - 0.72, r.y - 0.2)) - vec2(0.08, 0.5), 0.0)));
  float front = smoothstep(0.55, 1.0, r.z);
  vec3 light = vec3(0.10, 0.095, 0.09) + sky * vec3(0.30, 0.32, 0.36) + strip * 0.22 + window * vec3(1.15, 1.1, 1.0);
  return light + dim * vec3(0.40, 0.44, 0.52) - front * 0.10 * (1.0 - 0.5 * rough);
}

/* Background in blue stripes, as far as it is bare. */
vec3 bare_stripes(vec3 tone, float bare) {
  float stripe = step(0.5, fract((gl_FragCoord.x + gl_FragCoord.y) / 12.0));
  return mix(tone, vec3(0.02, 0.16, 0.62), clamp(bare, 0.0, 1.0) * (0.62 + 0.2 * stripe));
}

vec3 tint(vec3 tone, vec2 p, float z, float slope, float key) {
  float lit_by = 0.42 + 0.58 * min(key, 1.2);
#if OVERLAY == 1
  float t = clamp((z - range.x) / max(range.y - range.x, 1e-6), 0.0, 1.0);
  float level = z / contour.x;
  float wide = max(fwidth(level), 1e-5);
  float line = abs(fract(level - 0.5) - 0.5) / wide;
  bool is_thick = mod(floor(level + 0.5), contour.y) < 0.5;
  float mark = (1.0 - smoothstep(is_thick ? 1.1 : 0.4, is_thick ? 1.9 : 1.1, line)) * clamp(0.7 / wide - 1.0, 0.0, 1.0);
  return mix(texture(palette, vec2(t, 0.125)).rgb * lit_by, vec3(0.02), (is_thick ? 0.8 : 0.5) * mark);
#elif OVERLAY == 2
  return texture(palette, vec2(atan(slope) / 1.5707963, 0.375)).rgb * lit_by;
#elif OVERLAY == 3
  return mix(tone, vec3(0.85, 0.03, 0.02) * lit_by, 0.92 * step(steepest, slope));
#elif OVERLAY == 4
  return bare_stripes(tone, lit_by * (1.0 - texture(layer, (p + 0.5) / grid).r));
#elif OVERLAY == 5
  return texture(palette, vec2(texture(layer, (p + 0.5) / grid).r, 0.625)).rgb * (0.55 + 0.45 * min(key, 1.2));
#else
  return tone;
#endif
}

/* p: place on the grid; n: normal; view: to the viewer; open: share of the sky; lit: share of the first light. */
vec3 shade(vec2 p, float z, vec3 n, vec3 view, float open, float lit) {
  float mirror = finish.x, rough = finish.y, spread = finish.z;
  float worn = smoothstep(0.25, 0.97, open);
  vec3 base = mix(hollow, dry(p, z), worn);
  vec3 diffuse = vec3(0.0), shine = vec3(0.0);
  float key = 0.0;
  float facing = max(dot(n, view), 0.05);
  float tight = 2.0 / (rough * rough * rough * rough + 1e-3);
  for (int i = 0; i < LIGHTS; i++) {
    vec3 l = to_light[i];
    float reach = strength[i] * (i == 0 ? mix(lit, 1.0, 0.12 * spread) : 1.0);
    float incoming = dot(n, l);
    float direct = max((incoming + 0.3 * spread) / (1.0 + 0.3 * spread), 0.0);
    key += direct * reach;
#if GLOSS
    vec3 half_way = normalize(l + view);
    float lobe = exp2(tight * (dot(n, half_way) - 1.0) * 1.4427);
    float away = 1.0 - max(dot(half_way, view), 0.0);
    float fresnel = mirror + (1.0 - mirror) * 0.04 + (1.0 - mirror) * pow(away, 5.0) * 0.5;
    shine += vec3(fresnel * lobe * min(0.035 * tight, 2.2) * reach * smoothstep(0.0, 0.12, incoming));
#endif
  }
  float up = 0.5 - 0.5 * n.y * 0.7 - 0.15 * n.x;
  vec3 sky = mix(vec3(0.17, 0.15, 0.135), vec3(0.25, 0.265, 0.29), up) * open * (0.4 + 0.6 * n.z);
  vec3 warm = vec3(1.02, 1.0, 0.96);
  diffuse = base * (warm * key * 1.0 + sky);
  vec3 tone = diffuse + shine * mix(vec3(0.8), warm, 0.5) * worn;
#if METAL
  vec3 r = 2.0 * facing * n - view;
  vec3 seen = room(r, rough) * (0.25 + 0.75 * open) * (0.62 + 0.38 * min(key + 0.3, 1.0));
  float edge = pow(1.0 - facing, 5.0);
  vec3 colour_of = mix(base, vec3(1.0), 0.6 * edge);
  tone = mix(diffuse * 0.45, colour_of * (seen * 1.05 + 0.45 * key), mirror) + colour_of * shine * worn;
  tone *= 1.2 / (1.0 + 0.55 * tone);
#endif
  return tint(tone, p, z, length(n.xy) / max(n.z, 1e-3), key);
}

/* The look-ups of shade for a place on the grid. */
vec3 look(vec2 p, vec3 view, out float is_on) {
  vec2 uv = (p + 0.5) / grid;
  vec4 slope = texture(slopes, uv);
  is_on = slope.b;
  vec3 n = normalize(vec3(-slope.rg / max(slope.b, 0.05), 1.0));
  float lit = 1.0;
#if SHADOW
  vec2 s = texture(shadow, uv).rg;
  lit = 1.0 - smoothstep(0.0, 1.0, s.x / (0.07 * s.y + 0.45));
#endif
  return shade(p, at(p), n, view, texture(occlusion, uv).r, lit);
}

/* For the screen: highlights roll off, sRGB, and a little noise against bands. */
vec4 developed(vec3 tone) {
  tone = max(tone, 0.0);
  tone = tone * (1.0 + tone * 0.16) / (1.0 + tone * 0.36);
  float grainy = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
  return vec4(pow(tone, vec3(1.0 / 2.2)) + grainy / 255.0, 1.0);
}
`;
