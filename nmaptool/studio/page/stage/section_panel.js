/* The section line on the picture, and its plot below. */

import { $ } from "../studio.js";
import { element } from "./legend.js";
import { mmText } from "./scales.js";
import { EDGES, factorText, layout, pathOf, rangeOf, sampled } from "./section.js";
import { heightAt } from "./view.js";

const HEIGHT = 170; // CSS px of the plot
const MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

export class Section {
  constructor(view) {
    this.view = view;
    this.isOn = false;
    this.ends = null; // shares of the map, so that they stay where they are if its size changes
    this.layer = $("section-layer");
    this.lines = ["under", "over"].map((name) => this.layer.appendChild(element("polyline", { class: name })));
    this.knobs = ["A", "B"].map((name, end) => this.knob(name, end));
    this.marker = this.layer.appendChild(element("circle", { r: 4, class: "marker", display: "none" }));
    $("picture").append(...this.knobs);
    $("section-on").addEventListener("click", () => this.show(!this.isOn));
    view.onView(() => this.draw());
    $("section").addEventListener("pointermove", (event) => this.point(event));
    $("section").addEventListener("pointerleave", () => this.marker.setAttribute("display", "none"));
    new ResizeObserver(() => this.draw()).observe($("section"));
  }

  show(isOn) {
    this.isOn = isOn && this.view.relief !== null;
    this.ends ??= [
      [0.1, 0.5],
      [0.9, 0.5],
    ];
    $("section-on").setAttribute("aria-pressed", this.isOn);
    $("section").hidden = !this.isOn;
    this.layer.toggleAttribute("hidden", !this.isOn);
    for (const knob of this.knobs) knob.hidden = !this.isOn;
    this.draw();
  }

  knob(name, end) {
    const knob = document.createElement("div");
    knob.className = "section-end";
    knob.id = `section-${name.toLowerCase()}`;
    knob.tabIndex = 0;
    knob.hidden = true;
    knob.textContent = name;
    knob.setAttribute("role", "slider");
    knob.setAttribute("aria-label", `End ${name} of the section; arrow keys move it`);
    knob.setAttribute("aria-valuemin", 0);
    knob.setAttribute("aria-valuemax", 100);
    knob.addEventListener("pointerdown", (event) => {
      knob.setPointerCapture(event.pointerId);
      knob.onpointermove = (moved) => {
        const place = this.view.toGrid(moved);
        if (place) this.move(end, place.x, place.y);
      };
    });
    for (const stop of ["pointerup", "pointercancel"])
      knob.addEventListener(stop, () => {
        knob.onpointermove = null;
      });
    knob.addEventListener("keydown", (event) => {
      const way = MOVES[event.key];
      if (!way) return;
      event.preventDefault();
      const step = (event.shiftKey ? 10 : 1) / Math.min(this.view.scale, 1);
      const [x, y] = this.place(end);
      this.move(end, x + step * way[0], y + step * way[1]);
    });
    return knob;
  }

  /** An end in document coordinates. */
  place(end) {
    return this.ends[end].map((share, axis) => share * this.view.camera.full[axis]);
  }

  move(end, x, y) {
    const [cols, rows] = this.view.camera.full;
    this.ends[end] = [x / cols, y / rows].map((share) => Math.min(Math.max(share, 0), 1));
    this.draw();
  }

  draw() {
    if (!this.isOn || !this.view.relief) return;
    const { relief, before, split, pxPerMm, camera } = this.view;
    const [from, to] = [this.place(0), this.place(1)];
    this.now = sampled(from, to, (x, y) => heightAt(relief, x, y), 1 / pxPerMm);
    const compares = before && split !== null;
    this.then = compares ? sampled(from, to, (x, y) => heightAt(before.relief, x, y), 1 / pxPerMm) : null;
    this.layer.setAttribute("viewBox", `0 0 ${camera.width} ${camera.height}`);
    const isFlat = !camera.orbits;
    const way = (isFlat ? [this.now.points[0], this.now.points.at(-1)] : this.now.points)
      .map(({ x, y }) => this.view.toScreen(x, y))
      .map(({ x, y }) => `${x.toFixed(1)},${y.toFixed(1)}`);
    for (const line of this.lines) line.setAttribute("points", way.join(" "));
    this.knobs.forEach((knob, end) => {
      const [x, y] = this.place(end);
      const place = this.view.toScreen(x, y);
      knob.style.left = `${place.x}px`;
      knob.style.top = `${place.y}px`;
      knob.setAttribute("aria-valuenow", Math.round(100 * this.ends[end][0]));
      const [mmX, mmY] = [x, y].map((px) => mmText(px / pxPerMm, 0.1));
      knob.setAttribute("aria-valuetext", `${mmX} mm from the left, ${mmY} mm from the top`);
    });
    this.plot();
  }

  plot() {
    const holder = $("section");
    const width = holder.clientWidth;
    if (!width) return;
    const all = [...this.now.points, ...(this.then?.points ?? [])].map(({ height }) => height);
    const range = rangeOf(all);
    const { length } = this.now;
    const title = document.createElement("figcaption");
    if (!range || length < 1e-6) {
      title.textContent = "The section does not cross the relief";
      holder.replaceChildren(title);
      return;
    }
    const plan = layout({ width, height: HEIGHT, length, range });
    this.plan = plan;
    const heights = rangeOf(this.now.points.map(({ height }) => height)) ?? range;
    const drop = Math.max(...finite(this.now)) - Math.min(...finite(this.now));
    title.textContent =
      `Section A to B: ${mmText(length, 0.1)} mm long, ` +
      (heights && Number.isFinite(drop) ? `${mmText(drop, 0.001)} mm from lowest to highest; ` : "") +
      `heights drawn ${factorText(plan.exaggeration)} times as large as lengths`;
    holder.replaceChildren(title, this.picture(plan, width));
  }

  picture(plan, width) {
    const svg = element("svg", { width, height: HEIGHT, role: "img", "aria-label": $("section").textContent });
    const bottom = HEIGHT - EDGES.bottom;
    for (const [mm, text] of plan.heights) {
      const y = Math.round(plan.y(mm)) + 0.5;
      svg.append(element("line", { class: "rule", x1: EDGES.left, x2: width - EDGES.right, y1: y, y2: y }));
      svg.append(label(text, { x: EDGES.left - 6, y: y + 4, "text-anchor": "end" }));
    }
    for (const [mm, text] of plan.lengths) {
      const x = Math.round(plan.x(mm)) + 0.5;
      svg.append(element("line", { class: "tick", x1: x, x2: x, y1: bottom, y2: bottom + 5 }));
      svg.append(label(text, { x, y: bottom + 17, "text-anchor": "middle" }));
    }
    svg.append(label("height, mm", { x: 4, y: 11 }));
    svg.append(label("length, mm", { x: width - EDGES.right, y: HEIGHT - 3, "text-anchor": "end" }));
    svg.append(element("line", { class: "tick", x1: EDGES.left, x2: width - EDGES.right, y1: bottom + 0.5, y2: bottom + 0.5 }));
    if (this.then) svg.append(element("path", { class: "then", d: pathOf(this.then.points, plan.x, plan.y) }));
    svg.append(element("path", { class: "now", d: pathOf(this.now.points, plan.x, plan.y) }));
    return svg;
  }

  /** Show on the picture where the pointer is in the plot. */
  point(event) {
    const svg = $("section").querySelector("svg");
    if (!svg || !this.now) return;
    const along = event.clientX - svg.getBoundingClientRect().left - EDGES.left;
    const share = along / (svg.clientWidth - EDGES.left - EDGES.right);
    const points = this.now.points;
    const { x, y } = points[Math.round(Math.min(Math.max(share, 0), 1) * (points.length - 1))];
    const place = this.view.toScreen(x, y);
    this.marker.setAttribute("cx", place.x);
    this.marker.setAttribute("cy", place.y);
    this.marker.setAttribute("display", "inline");
  }
}

function finite({ points }) {
  return points.map(({ height }) => height).filter(Number.isFinite);
}

function label(text, attributes) {
  const made = element("text", attributes);
  made.textContent = text;
  return made;
}
