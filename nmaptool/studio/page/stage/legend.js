/* The legend of the overlay: its colours, with numbers. */

import { $ } from "../studio.js";
import { colourAt, OVERLAYS } from "./materials.js";
import { contourStep, mmText, roundUp, ticks } from "./scales.js";

const WIDTH = 220; // CSS px of the colour bar
const EDGE = 18; // beside it, for numbers that are centred on its ends

/** Share of the surface that is steeper than `steepest` (rise per run), from heights and spacing in the same unit. */
export function steepShare({ z, surface, cols, rows }, steepest) {
  let steep = 0;
  let all = 0;
  const limit = steepest * steepest;
  for (let y = 1; y < rows - 1; y++)
    for (let x = 1, i = y * cols + 1; x < cols - 1; x++, i++) {
      if (!surface[i]) continue;
      all += 1;
      const across = surface[i - 1] && surface[i + 1] ? (z[i + 1] - z[i - 1]) / 2 : 0;
      const down = surface[i - cols] && surface[i + cols] ? (z[i + cols] - z[i - cols]) / 2 : 0;
      if (across * across + down * down > limit) steep += 1;
    }
  return all ? steep / all : 0;
}

/** What a legend says: a title, and a scale of colours with its numbers, or marks with their meaning. */
export function legendOf(overlay, relief, draft) {
  if (overlay === OVERLAYS["heights and contours"]) {
    const { low, high } = relief;
    const step = roundUp(Math.max(high - low, 1e-6) / 5);
    const numbers = ticks(low, high, 5).map((mm) => [(mm - low) / Math.max(high - low, 1e-9), mmText(mm, step)]);
    const line = contourStep(high - low);
    return { title: `Height in mm; a line every ${mmText(line, line)} mm`, scale: "height", numbers };
  }
  if (overlay === OVERLAYS.slope) {
    const numbers = [0, 15, 30, 45, 60, 75, 90].map((angle) => [angle / 90, `${angle}`]);
    return { title: "Slope in degrees", scale: "slope", numbers };
  }
  if (overlay === OVERLAYS["draft angle"]) {
    const share = 100 * steepShare(relief, Math.tan(((90 - draft) * Math.PI) / 180));
    const found = share > 0 && share < 0.1 ? "less than 0.1" : share.toFixed(1);
    return {
      title: `Draft: ${found} % of the surface has less than ${draft} degrees`,
      marks: [["steep", `steeper than ${90 - draft} degrees`]],
    };
  }
  if (overlay === OVERLAYS["background and coverage"])
    return { title: "Coverage of the map", marks: [["bare", "background: the map is not defined"]] };
  if (overlay === OVERLAYS.curl) {
    const numbers = [0.001, 0.01, 0.1, 1].map((curl, i) => [i / 3, `${curl}`]);
    return { title: "Curl of the map in slope per px; a surface has 0", scale: "curl", numbers };
  }
  return null;
}

/** Show a legend in an element; null hides it. */
export function showLegend(holder, legend) {
  holder.hidden = legend === null;
  if (legend === null) return;
  const title = document.createElement("figcaption");
  title.textContent = legend.title;
  holder.replaceChildren(title, ...(legend.scale ? [bar(legend)] : legend.marks.map(mark)));
}

function bar({ scale, numbers }) {
  const svg = element("svg", { width: WIDTH + 2 * EDGE, height: 34, "aria-hidden": true });
  const strips = 64;
  for (let i = 0; i < strips; i++) {
    const fill = `rgb(${colourAt(scale, (i + 0.5) / strips)})`;
    svg.append(element("rect", { x: EDGE + (i * WIDTH) / strips, width: WIDTH / strips + 0.5, y: 0, height: 12, fill }));
  }
  for (const [share, text] of numbers) {
    const x = EDGE + share * WIDTH;
    svg.append(element("line", { x1: x, x2: x, y1: 12, y2: 16 }));
    const number = element("text", { x, y: 29, "text-anchor": "middle" });
    number.textContent = text;
    svg.append(number);
  }
  return svg;
}

function mark([kind, text]) {
  const row = document.createElement("p");
  const swatch = document.createElement("span");
  swatch.className = `swatch ${kind}`;
  row.append(swatch, text);
  return row;
}

/** An SVG element with attributes. */
export function element(name, attributes = {}) {
  const made = document.createElementNS($("section-layer").namespaceURI, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}
