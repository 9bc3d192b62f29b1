/*
 * Where a layer lies: from the matrix of its map to the canvas, to the keys of the recipe and back. Coordinates are px of
 * the canvas and of the map, x right, y down; a box is { cols, rows, matrix: [[a, b, x], [c, d, y]] }.
 */

export const ANCHORS = {
  center: [0.5, 0.5],
  "top-left": [0, 0],
  top: [0.5, 0],
  "top-right": [1, 0],
  left: [0, 0.5],
  right: [1, 0.5],
  "bottom-left": [0, 1],
  bottom: [0.5, 1],
  "bottom-right": [1, 1],
};

/** The place on the canvas of a point of a box, given as shares of its width and height. */
export function pointAt({ cols, rows, matrix }, [across, down]) {
  const [x, y] = [across * cols, down * rows];
  return matrix.map(([a, b, c]) => a * x + b * y + c);
}

/** The box with another linear part, so that a point of it, given as shares, stays where it is. */
export function about(box, share, linear) {
  const [x, y] = pointAt(box, share);
  const [u, v] = [share[0] * box.cols, share[1] * box.rows];
  const matrix = [
    [...linear[0], x - linear[0][0] * u - linear[0][1] * v],
    [...linear[1], y - linear[1][0] * u - linear[1][1] * v],
  ];
  return { ...box, matrix };
}

export function moved(box, dx, dy) {
  const [[a, b, x], [c, d, y]] = box.matrix;
  return { ...box, matrix: [[a, b, x + dx], [c, d, y + dy]] };
}

/** The box turned counter-clockwise by degrees about a point, given as shares. */
export function turned(box, share, degrees) {
  const angle = (degrees * Math.PI) / 180;
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  const [[a, b], [c, d]] = box.matrix;
  return about(box, share, [
    [cos * a + sin * c, cos * b + sin * d],
    [cos * c - sin * a, cos * d - sin * b],
  ]);
}

/** The box stretched along its own axes, so that a point of it, given as shares, stays. */
export function stretched(box, share, across, down) {
  const [[a, b], [c, d]] = box.matrix;
  return about(box, share, [
    [a * across, b * down],
    [c * across, d * down],
  ]);
}

/** The shares of a box at a place on the canvas. */
export function shareAt({ cols, rows, matrix }, x, y) {
  const [[a, b, e], [c, d, f]] = matrix;
  const det = a * d - b * c;
  const [u, v] = [x - e, y - f];
  return [(d * u - b * v) / det / cols, (a * v - c * u) / det / rows];
}

const number = (value, digits) => String(Number(value.toFixed(digits)));

/**
 * The keys of the recipe that put a layer where a box is: `at`, `scale` and `rotate`; those that stay are left out.
 *
 * @param {object} before  the box that the options stand for
 * @param {object} box
 * @param {object} options  of the layer: anchor, scale, rotate
 * @param {object} canvas  cols and rows
 */
export function keysFor(before, box, options, canvas) {
  const [x, y] = pointAt(box, ANCHORS[options.anchor]);
  const values = { at: `${number((100 * x) / canvas.cols, 3)}%,${number((100 * y) / canvas.rows, 3)}%` };
  const [old, now] = [sizes(before), sizes(box)];
  const ratios = [now[0] / old[0], now[1] / old[1]];
  if (ratios.some((ratio) => Math.abs(ratio - 1) > 1e-6)) values.scale = scaleText(options.scale, now, ratios);
  const turn = angle(box) - angle(before);
  if (Math.abs(turn) > 1e-6) values.rotate = Number(wrapped(options.rotate + turn).toFixed(2));
  return values;
}

/** Factors across and down. */
export function sizes({ matrix: [[a, b], [c, d]] }) {
  return [Math.hypot(a, c), Math.hypot(b, d)];
}

/** Degrees counter-clockwise of the box's own x axis. */
function angle({ matrix: [[a], [c]] }) {
  return (Math.atan2(-c, a) * 180) / Math.PI;
}

/** Degrees between -180 and 180. */
export function wrapped(degrees) {
  return ((((degrees + 180) % 360) + 360) % 360) - 180;
}

/** A width such as 30mm keeps its unit while the proportions stay. */
function scaleText(text, factors, ratios) {
  const isEven = Math.abs(ratios[0] / ratios[1] - 1) < 1e-6;
  const length = /^([\d.]+)\s*([a-z%]+)$/.exec(text);
  if (isEven && length) return `${number(Number(length[1]) * ratios[0], 3)}${length[2]}`;
  const [across, down] = factors.map((factor) => number(factor, 4));
  return across === down ? across : `${across},${down}`;
}

/**
 * Where a value snaps to: the nearest of the targets within reach.
 *
 * @returns {{shift: number, target: number} | null}  how far to move, and to which target
 */
export function snap(values, targets, reach) {
  let found = null;
  for (const value of values) {
    for (const target of targets) {
      const shift = target - value;
      if (Math.abs(shift) <= reach && (!found || Math.abs(shift) < Math.abs(found.shift))) found = { shift, target };
    }
  }
  return found;
}

/** Lowest, middle and highest coordinate of a box's corners, across (0) or down (1). */
export function marks(box, axis) {
  const corners = [[0, 0], [1, 0], [0, 1], [1, 1]].map((share) => pointAt(box, share)[axis]);
  const [low, high] = [Math.min(...corners), Math.max(...corners)];
  return [low, (low + high) / 2, high];
}
