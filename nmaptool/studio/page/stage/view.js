/* The view: what is shown, from where, and when it is drawn. */

import { Camera } from "./camera.js";
import { contourStep } from "./scales.js";
import { Renderer } from "./renderer.js";

// when nothing has moved for this long, the picture is drawn in full
const REST_MS = 150;

export class View {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new Renderer(canvas);
    this.camera = new Camera();
    this.lights = [{ azimuth: 135, elevation: 30, strength: 1 }];
    this.material = "plaster";
    this.overlay = 0;
    this.shadows = true;
    this.draft = 15; // degrees
    this.relief = null; // heights and their grid; `shown` is the same on the graphics card
    this.shown = null;
    this.before = null; // { relief, shown } of the snapshot
    this.split = null; // share of the canvas that shows the snapshot
    this.listeners = [];
    this.due = false;
    this.drawn = 0;
    this.moves = false;
    this.resting = null;
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => this.restore());
  }

  /** The graphics card has lost everything, as after sleep or a new driver: give it all again. */
  restore() {
    this.renderer = new Renderer(this.canvas);
    for (const one of [this, this.before].filter((each) => each?.relief)) {
      one.shown = this.renderer.relief();
      upload(one.shown, one.relief);
    }
    this.draw();
  }

  /**
   * Show a relief: heights `z` in px of its grid, `surface`, `cols`, `rows`, `low` and `high` in mm, `pitch` in mm per px,
   * `full` (columns and rows of the map in px) and `base`, the thickness of the plate in mm. What is seen stays in place.
   */
  show(relief) {
    this.shown ??= this.renderer.relief();
    upload(this.shown, relief);
    this.relief = relief;
    const isNew = relief.full.some((size, i) => size !== this.camera.full[i]);
    this.camera.full = relief.full;
    if (isNew) this.fit();
    else this.move();
  }

  /** Keep the relief as it is, to compare. */
  keep() {
    this.before ??= { shown: this.renderer.relief() };
    this.before.relief = { ...this.relief, z: this.relief.z.slice() };
    upload(this.before.shown, this.before.relief);
    this.draw();
  }

  /** Call `listener` after each change of the zoom, the place, the turn or the size of the view. */
  onView(listener) {
    this.listeners.push(listener);
  }

  /** Change the camera, and draw. */
  look(change) {
    this.moves = true;
    this.resize();
    change(this.camera);
    for (const listener of this.listeners) listener();
    this.move();
  }

  /** Show the whole relief. */
  fit() {
    this.look((camera) => camera.fit());
  }

  /** Show the whole relief from the default direction. */
  reset() {
    this.look((camera) => camera.reset());
  }

  /** Show one px of the map per device pixel. */
  actual() {
    this.look((camera) => camera.scaleTo(1 / this.density));
  }

  zoomAt(x, y, factor) {
    this.look((camera) => camera.zoomAt(x, y, factor));
  }

  pan(dx, dy) {
    this.look((camera) => camera.pan(dx, dy));
  }

  orbit(yaw, tilt) {
    this.look((camera) => camera.orbit(yaw, tilt));
  }

  /** Change between the flat view and the orbit view. */
  turn(orbits) {
    this.look((camera) => {
      camera.orbits = orbits;
      camera.fit();
    });
  }

  /** Where a pointer event is on the map, in vertices of the full map; null if it is not on the plate's plane. */
  toGrid(event) {
    const box = this.canvas.getBoundingClientRect();
    return this.placeAt(event.clientX - box.left, event.clientY - box.top);
  }

  /** The same for a place on the canvas in CSS px. */
  placeAt(x, y) {
    const { low, high } = this.relief ?? { low: 0, high: 0 };
    const px = this.pxPerMm;
    return this.camera.onSurface(x, y, (u, v) => this.heightAt(u, v) * px, low * px, high * px);
  }

  /** Where a place of the map is on the canvas, in CSS px from its upper left corner. */
  toScreen(x, y) {
    const height = this.camera.orbits ? this.heightAt(x, y) * this.pxPerMm : 0;
    return this.camera.toScreen(x, y, Number.isFinite(height) ? height : 0);
  }

  /** CSS px per px of the full map. */
  get scale() {
    return this.camera.zoom;
  }

  /** Px of the full map per mm. */
  get pxPerMm() {
    const { cols, pitch } = this.relief ?? { cols: 2, pitch: 1 };
    return this.camera.full[0] / ((cols - 1) * pitch);
  }

  /** Height in mm at a place of the full map; NaN outside the surface. */
  heightAt(x, y, relief = this.relief) {
    return heightAt(relief, x, y);
  }

  /** Device pixels per CSS px, at most 2. */
  get density() {
    return Math.min(window.devicePixelRatio || 1, 2);
  }

  /** Pixels that are drawn per CSS px: fewer while something moves and the processor draws. */
  get drawnDensity() {
    return this.density * (this.moves ? this.renderer.coarse : 1);
  }

  /** Give the canvas the pixels of its place on the screen. */
  resize() {
    const { clientWidth, clientHeight } = this.canvas;
    const width = Math.max(1, Math.round(clientWidth * this.drawnDensity));
    const height = Math.max(1, Math.round(clientHeight * this.drawnDensity));
    this.camera.resize(Math.max(clientWidth, 1), Math.max(clientHeight, 1));
    if (this.canvas.width !== width) this.canvas.width = width;
    if (this.canvas.height !== height) this.canvas.height = height;
  }

  /** Draw coarsely at the next frame of the screen, and in full when nothing has moved for a while. */
  move() {
    this.moves = true;
    clearTimeout(this.resting);
    this.resting = setTimeout(() => {
      this.moves = false;
      this.draw();
    }, REST_MS);
    this.draw();
  }

  /** Draw at the next frame of the screen. */
  draw() {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      this.paint();
    });
  }

  paint() {
    if (!this.relief || this.renderer.gl.isContextLost()) return;
    this.resize();
    const now = { relief: this.shown, bottomPx: bottomOf(this.relief) };
    const compares = this.before && this.split !== null;
    const { relief, shown } = this.before ?? {};
    const parts = compares
      ? [
          { relief: shown, bottomPx: bottomOf(relief), range: [0, this.split] },
          { ...now, range: [this.split, 1] },
        ]
      : [{ ...now, range: [0, 1] }];
    const { camera, drawnDensity: density, moves: moving, material, overlay, shadows } = this;
    const lights = this.lights.map((light) => ({ direction: toLight(light), strength: light.strength }));
    const steepest = Math.tan(((90 - this.draft) * Math.PI) / 180);
    const contourMm = contourStep(this.relief.high - this.relief.low);
    const ground = [0.022, 0.021, 0.019];
    const rest = { camera, density, moving, material, overlay, shadows };
    this.renderer.paint({ parts, lights, steepest, contourMm, ground, ...rest });
    this.drawn += 1;
  }
}

/** Unit vector to a light: x right, y down, z to the viewer. */
export function toLight({ azimuth, elevation }) {
  const [a, e] = [azimuth, elevation].map((angle) => (angle * Math.PI) / 180);
  return [Math.cos(e) * Math.cos(a), -Math.cos(e) * Math.sin(a), Math.sin(e)];
}

/** Height in mm at a place of the full map, interpolated; NaN outside the surface. */
export function heightAt({ cols, rows, z, surface, pitch, full }, x, y) {
  const u = (x / full[0]) * (cols - 1);
  const v = (y / full[1]) * (rows - 1);
  if (!(u >= 0 && v >= 0 && u <= cols - 1 && v <= rows - 1)) return NaN;
  const [i, j] = [Math.min(Math.floor(u), cols - 2), Math.min(Math.floor(v), rows - 2)];
  const [fx, fy, at] = [u - i, v - j, j * cols + i];
  if (!(surface[at] && surface[at + 1] && surface[at + cols] && surface[at + cols + 1])) return NaN;
  const upper = z[at] * (1 - fx) + z[at + 1] * fx;
  const lower = z[at + cols] * (1 - fx) + z[at + cols + 1] * fx;
  return (upper * (1 - fy) + lower * fy) * pitch;
}

/** Height of the back of the plate in px of the grid. */
function bottomOf({ low, base, pitch }) {
  return (Math.min(low, 0) - base) / pitch;
}

function upload(shown, relief) {
  shown.fill({ ...relief, lowPx: relief.low / relief.pitch, highPx: relief.high / relief.pitch });
  shown.pitch = relief.pitch;
}
