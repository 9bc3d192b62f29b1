/* The knobs of the lights: each is dragged over a dome above the relief. */

import { dot, unit } from "./camera.js";
import { MOST_LIGHTS } from "./settings.js";
import { toLight } from "./view.js";

// radius of the dome as a share of the shorter side of the picture
const DOME = 0.42;
const [LOWEST, HIGHEST] = [3, 89]; // degrees
const TURNS = { ArrowLeft: [3, 0], ArrowRight: [-3, 0], ArrowUp: [0, 2], ArrowDown: [0, -2] };

/** Azimuth and elevation of a direction, in degrees. */
export function anglesOf([x, y, z]) {
  const azimuth = ((Math.atan2(-y, x) * 180) / Math.PI + 360) % 360;
  const elevation = (Math.asin(Math.min(Math.max(z, -1), 1)) * 180) / Math.PI;
  return { azimuth, elevation: Math.min(Math.max(elevation, LOWEST), HIGHEST) };
}

/**
 * The direction whose knob is at (u, v) on the dome, right and up, in radii. Of the two on the line of sight, the one
 * above the plate that is nearer to the direction `now`.
 */
export function directionAt(u, v, { right, up, near }, now) {
  const size = Math.hypot(u, v);
  const [a, b] = size > 0.999 ? [(u / size) * 0.999, (v / size) * 0.999] : [u, v];
  const depth = Math.sqrt(1 - a * a - b * b);
  const least = Math.sin((LOWEST * Math.PI) / 180);
  const both = [depth, -depth].map((w) => [0, 1, 2].map((i) => a * right[i] + b * up[i] + w * near[i]));
  const above = both.filter((direction) => direction[2] >= least);
  if (above.length) return above.reduce((one, other) => (dot(other, now) > dot(one, now) ? other : one));
  return unit([both[0][0], both[0][1], least]);
}

/** Another light: opposite the last one, and weaker. */
export function another(lights) {
  const last = lights[lights.length - 1];
  const azimuth = (last.azimuth + (lights.length === 1 ? 160 : 100)) % 360;
  return { azimuth, elevation: 40, strength: 0.3 };
}

export class Lights {
  /**
   * @param {import("./view.js").View} view
   * @param {HTMLElement} holder  of the knobs
   * @param {() => void} changed  called when a light was added, removed, chosen or moved
   */
  constructor(view, holder, changed) {
    this.view = view;
    this.holder = holder;
    this.changed = changed;
    this.chosen = 0;
    this.knobs = [];
    view.onView(() => this.place());
    this.build();
  }

  build() {
    this.knobs = this.view.lights.map((_, number) => this.knob(number));
    this.holder.replaceChildren(...this.knobs);
    this.choose(Math.min(this.chosen, this.knobs.length - 1));
    this.place();
  }

  knob(number) {
    const knob = document.createElement("div");
    knob.className = "light";
    knob.id = `light-${number + 1}`;
    knob.tabIndex = 0;
    knob.textContent = number + 1;
    knob.setAttribute("role", "slider");
    knob.setAttribute("aria-label", `Direction of light ${number + 1}; left and right turn it, up and down raise it`);
    knob.setAttribute("aria-valuemin", 0);
    knob.setAttribute("aria-valuemax", 360);
    knob.addEventListener("focus", () => this.choose(number));
    knob.addEventListener("keydown", (event) => this.key(event, number));
    knob.addEventListener("pointerdown", (event) => {
      knob.setPointerCapture(event.pointerId);
      knob.onpointermove = (moved) => this.drag(moved, number);
    });
    for (const end of ["pointerup", "pointercancel"])
      knob.addEventListener(end, () => {
        knob.onpointermove = null;
      });
    return knob;
  }

  key(event, number) {
    const light = this.view.lights[number];
    const turn = TURNS[event.key];
    const finer = event.shiftKey ? 1 / 3 : 1;
    if (turn) this.move(number, { azimuth: light.azimuth + finer * turn[0], elevation: light.elevation + finer * turn[1] });
    else if (event.key === "Delete") this.remove(number);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  drag(event, number) {
    const { camera, canvas } = this.view;
    const box = canvas.getBoundingClientRect();
    const radius = DOME * Math.min(camera.width, camera.height);
    const u = (event.clientX - box.left - camera.width / 2) / radius;
    const v = (box.top + camera.height / 2 - event.clientY) / radius;
    const now = toLight(this.view.lights[number]);
    this.move(number, anglesOf(directionAt(u, v, camera.axes(), now)));
  }

  move(number, { azimuth, elevation }) {
    const light = this.view.lights[number];
    light.azimuth = (azimuth + 360) % 360;
    light.elevation = Math.min(Math.max(elevation, LOWEST), HIGHEST);
    this.place();
    this.view.move();
    this.changed();
  }

  add() {
    if (this.view.lights.length >= MOST_LIGHTS) return;
    this.view.lights.push(another(this.view.lights));
    this.chosen = this.view.lights.length - 1;
    this.update();
  }

  remove(number) {
    if (this.view.lights.length < 2) return;
    this.view.lights.splice(number, 1);
    this.update();
    this.knobs[this.chosen].focus();
  }

  update() {
    this.build();
    this.view.move();
    this.changed();
  }

  choose(number) {
    this.chosen = number;
    this.knobs.forEach((knob, i) => knob.classList.toggle("chosen", i === number && this.knobs.length > 1));
    this.changed();
  }

  /** Put the knobs where their lights are. */
  place() {
    const { camera } = this.view;
    const { right, up, near } = camera.axes();
    const radius = DOME * Math.min(camera.width, camera.height);
    this.knobs.forEach((knob, number) => {
      const light = this.view.lights[number];
      const direction = toLight(light);
      knob.style.left = `${camera.width / 2 + radius * dot(right, direction)}px`;
      knob.style.top = `${camera.height / 2 - radius * dot(up, direction)}px`;
      knob.classList.toggle("behind", dot(near, direction) < 0);
      const [turned, high] = [light.azimuth, light.elevation].map(Math.round);
      knob.setAttribute("aria-valuenow", turned);
      knob.setAttribute("aria-valuetext", `${turned} degrees, ${high} degrees high`);
    });
  }
}
