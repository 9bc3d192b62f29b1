/* Heights along a line: what they are, and how the plot shows them. */

import { mmText, roundUp, ticks } from "./scales.js";

/** Space around the plot in CSS px. */
export const EDGES = { left: 46, right: 14, top: 18, bottom: 32 };

/**
 * Heights along a line.
 *
 * @param {number[]} from  end point in document coordinates
 * @param {number[]} to
 * @param {(x: number, y: number) => number} heightAt  in mm, NaN outside the surface
 * @param {number} mmPerPx
 * @param {number} count  points, at most; two for each px of the map are enough
 * @returns {{length: number, points: {x: number, y: number, along: number, height: number}[]}}  in mm, but for x and y
 */
export function sampled(from, to, heightAt, mmPerPx, count = 600) {
  const span = Math.hypot(to[0] - from[0], to[1] - from[1]);
  const steps = Math.max(2, Math.min(count - 1, Math.ceil(2 * span)));
  const points = Array.from({ length: steps + 1 }, (_, i) => {
    const share = i / steps;
    const [x, y] = [0, 1].map((axis) => from[axis] + share * (to[axis] - from[axis]));
    return { x, y, along: share * span * mmPerPx, height: heightAt(x, y) };
  });
  return { length: span * mmPerPx, points };
}

/** Lowest and highest of some heights, widened to a range that can be drawn; null if there are none. */
export function rangeOf(heights) {
  let [low, high] = [Infinity, -Infinity];
  for (const height of heights) {
    if (!Number.isFinite(height)) continue;
    low = Math.min(low, height);
    high = Math.max(high, height);
  }
  if (low > high) return null;
  const edge = Math.max(0.06 * (high - low), 1e-3);
  return [low - edge, high + edge];
}

/** The path of an SVG through points; a gap where a height is not a number. */
export function pathOf(points, x, y) {
  let path = "";
  let draws = false;
  for (const { along, height } of points) {
    if (Number.isFinite(height)) path += `${draws ? "L" : "M"}${x(along).toFixed(2)} ${y(height).toFixed(2)}`;
    draws = Number.isFinite(height);
  }
  return path;
}

/** Where things are in a plot of a size in CSS px, and by how much it exaggerates heights. */
export function layout({ width, height, length, range }) {
  const [inner, tall] = [width - EDGES.left - EDGES.right, height - EDGES.top - EDGES.bottom];
  const [low, high] = range;
  const across = inner / Math.max(length, 1e-9);
  const upward = tall / (high - low);
  const down = Math.max(Math.floor(tall / 20), 2);
  const stepDown = roundUp((high - low) / down);
  const many = Math.max(Math.floor(inner / 70), 2);
  const stepAcross = roundUp(Math.max(length, 1e-9) / many);
  return {
    x: (along) => EDGES.left + along * across,
    y: (mm) => EDGES.top + (high - mm) * upward,
    exaggeration: upward / across,
    heights: ticks(low, high, down).map((mm) => [mm, mmText(mm, stepDown)]),
    lengths: ticks(0, length, many).map((mm) => [mm, mmText(mm, stepAcross)]),
  };
}

/** A factor as text of two digits, such as "12" or "1.5". */
export function factorText(factor) {
  return factor >= 10 ? factor.toFixed(0) : Number(factor.toPrecision(2)).toString();
}
