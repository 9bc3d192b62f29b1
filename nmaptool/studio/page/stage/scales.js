/* Round steps for contour lines, legends and axes, and numbers as text. */

/** The smallest round number (1, 2 or 5 times a power of ten) that is at least `rough`. */
export function roundUp(rough) {
  const power = 10 ** Math.floor(Math.log10(Math.max(rough, 1e-9)) + 1e-9);
  return power * ([1, 2, 5, 10].find((step) => step * power >= rough * (1 - 1e-9)) ?? 10);
}

/** Millimetres between contour lines: about 12 of them, and at most 15. */
export function contourStep(range) {
  return roundUp(Math.max(range, 1e-6) / 15);
}

/** Round numbers from `low` to `high`, at most `most` of them. */
export function ticks(low, high, most) {
  const step = roundUp(Math.max(high - low, 1e-9) / Math.max(most, 1));
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, i) => Number(((first + i) * step).toPrecision(9)));
}

/** Millimetres as text, with the digits that a step needs. */
export function mmText(mm, step = 0.001) {
  const digits = Math.min(Math.max(-Math.floor(Math.log10(step) + 1e-9), 0), 4);
  return mm.toFixed(digits).replace(/^-(0(\.0*)?)$/, "$1");
}
