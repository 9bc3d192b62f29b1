/* What the relief is made of, and the colours of the overlays. */

/** Linear colours; `finish` is the share of mirror, the roughness, and how far light spreads inside. */
export const MATERIALS = {
  clay: { albedo: [0.5, 0.245, 0.15], hollow: [0.24, 0.1, 0.06], finish: [0.02, 0.75, 0.15], kind: 0 },
  plaster: { albedo: [0.78, 0.765, 0.73], hollow: [0.5, 0.46, 0.4], finish: [0, 0.85, 0.35], kind: 0 },
  bronze: { albedo: [0.54, 0.275, 0.11], hollow: [0.035, 0.04, 0.028], finish: [0.9, 0.52, 0], kind: 0 },
  silver: { albedo: [0.86, 0.85, 0.82], hollow: [0.05, 0.05, 0.055], finish: [0.95, 0.4, 0], kind: 0 },
  walnut: { albedo: [0.26, 0.135, 0.065], hollow: [0.07, 0.032, 0.014], finish: [0.05, 0.55, 0], kind: 1 },
  marble: { albedo: [0.82, 0.81, 0.79], hollow: [0.55, 0.54, 0.52], finish: [0.04, 0.4, 0.9], kind: 2 },
};

export const OVERLAYS = {
  none: 0,
  "heights and contours": 1,
  slope: 2,
  "draft angle": 3,
  "background and coverage": 4,
  curl: 5,
};

/** Colours of the scales, sRGB, evenly spaced; lightness rises, so they serve the colour-blind, too. */
export const SCALES = {
  height: ["#26306e", "#1f5f8b", "#1e8a86", "#4fae62", "#a9c84a", "#f3e36b", "#fff7d6"],
  slope: ["#12122e", "#45226b", "#8a2a6e", "#c9425a", "#f0774a", "#fab45c", "#fdf1b4"],
  curl: ["#000004", "#320a5e", "#781c6d", "#bc3754", "#ed6925", "#fbb61a", "#fcffa4"],
};

const LEVELS = 256;

/** RGB of a share of a scale, 0 to 255 in sRGB. */
export function colourAt(scale, share) {
  const stops = SCALES[scale];
  const place = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const i = Math.min(Math.floor(place), stops.length - 2);
  return [1, 3, 5].map((at) => {
    const [low, high] = [stops[i], stops[i + 1]].map((stop) => parseInt(stop.slice(at, at + 2), 16));
    return Math.round(low + (high - low) * (place - i));
  });
}

/** The scales as a picture of 256 x 4 pixels, in linear light. */
export function palette() {
  const pixels = new Uint8Array(LEVELS * 4 * 4);
  Object.keys(SCALES).forEach((scale, row) => {
    for (let i = 0; i < LEVELS; i++) {
      const linear = colourAt(scale, i / (LEVELS - 1)).map((value) => 255 * (value / 255) ** 2.2);
      pixels.set([...linear.map(Math.round), 255], 4 * (row * LEVELS + i));
    }
  });
  return { pixels, width: LEVELS, height: 4 };
}

/** Noise that repeats, 256 x 256 pixels: two kinds of clouds, and grain; the same at each start. */
export function noise(size = 256) {
  let seed = 7;
  const random = () => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return seed / 2 ** 32;
  };
  const clouds = [layered(size, random), layered(size, random)];
  const pixels = new Uint8Array(4 * size * size);
  for (let i = 0; i < size * size; i++)
    pixels.set([255 * clouds[0][i], 255 * clouds[1][i], 255 * random(), 255], 4 * i);
  return { pixels, width: size, height: size };
}

/** Six octaves of interpolated random numbers, 0 to 1. */
function layered(size, random) {
  const sum = new Float32Array(size * size);
  for (let cells = 4, weight = 0.5; cells <= size / 2; cells *= 2, weight /= 2) {
    const knots = Float32Array.from({ length: cells * cells }, random);
    const knot = (i, j) => knots[(j % cells) * cells + (i % cells)];
    for (let y = 0; y < size; y++)
      for (let x = 0; x < size; x++) {
        const [u, v] = [(x * cells) / size, (y * cells) / size];
        const [i, j] = [Math.floor(u), Math.floor(v)];
        const [fx, fy] = [smooth(u - i), smooth(v - j)];
        const upper = knot(i, j) * (1 - fx) + knot(i + 1, j) * fx;
        const lower = knot(i, j + 1) * (1 - fx) + knot(i + 1, j + 1) * fx;
        sum[y * size + x] += weight * (upper * (1 - fy) + lower * fy);
      }
  }
  return sum;
}

function smooth(t) {
  return t * t * (3 - 2 * t);
}
