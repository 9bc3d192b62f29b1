/* Draws a relief on a canvas, and moves and zooms it. */

import { Camera } from "./camera.js";
import { FRAGMENT, VERTEX } from "./shaders.js";

export const MATERIALS = {
  clay: { albedo: [0.55, 0.32, 0.22], gloss: [0.03, 12], kind: 0, grain: 0 },
  plaster: { albedo: [0.78, 0.76, 0.72], gloss: [0.02, 8], kind: 0, grain: 0 },
  bronze: { albedo: [0.36, 0.22, 0.1], gloss: [0.55, 26], kind: 0, grain: 0 },
  silver: { albedo: [0.45, 0.46, 0.48], gloss: [0.75, 36], kind: 0, grain: 0 },
  walnut: { albedo: [0.3, 0.17, 0.09], gloss: [0.08, 18], kind: 1, grain: 0.4 },
  marble: { albedo: [0.74, 0.74, 0.73], gloss: [0.16, 40], kind: 2, grain: 0.45 },
};
export const OVERLAYS = { nothing: 0, "heights and contours": 1, slope: 2 };

export class View {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error("this browser has no WebGL 2; use a current Firefox, Chrome, Edge or Safari");
    this.program = build(this.gl);
    this.places = {};
    this.texture = this.gl.createTexture();
    this.light = { azimuth: 135, elevation: 30 };
    this.material = "plaster";
    this.overlay = 0;
    this.shadows = true;
    this.camera = new Camera();
    this.listeners = [];
    this.relief = null;
    this.due = false;
    this.drawn = 0;
  }

  /** Show heights in px; `surface` is 1 on the relief. The place on the canvas stays if the proportions do. */
  show(z, surface, cols, rows, mm) {
    const gl = this.gl;
    const packed = new Float32Array(2 * cols * rows);
    for (let i = 0; i < cols * rows; i++) {
      packed[2 * i] = z[i];
      packed[2 * i + 1] = surface[i];
    }
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG32F, cols, rows, 0, gl.RG, gl.FLOAT, packed);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    const isFirst = !this.relief;
    this.relief = { cols, rows, z, surface, ...mm };
    const full = mm.full ?? [cols - 1, rows - 1];
    const isNew = isFirst || full.some((size, i) => size !== this.camera.full[i]);
    this.camera.full = full;
    if (isNew) this.fit();
    else this.draw();
  }

  /** Call `listener` after each change of the zoom, the place, the turn or the size of the view. */
  onView(listener) {
    this.listeners.push(listener);
  }

  /** Change the camera, and draw. */
  look(change) {
    this.resize();
    change(this.camera);
    for (const listener of this.listeners) listener();
    this.draw();
  }

  fit() {
    this.look((camera) => camera.fit());
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

  /** Where a pointer event is on the map, in vertices of the full map; null if it is not on the plate's plane. */
  toGrid(event) {
    const box = this.canvas.getBoundingClientRect();
    const { low, high } = this.relief ?? { low: 0, high: 0 };
    const px = this.pxPerMm;
    const heightAt = (x, y) => this.heightAt(x, y) * px;
    return this.camera.onSurface(event.clientX - box.left, event.clientY - box.top, heightAt, low * px, high * px);
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
  heightAt(x, y) {
    const { cols, rows, z, surface, pitch } = this.relief;
    const u = (x / this.camera.full[0]) * (cols - 1);
    const v = (y / this.camera.full[1]) * (rows - 1);
    if (!(u >= 0 && v >= 0 && u <= cols - 1 && v <= rows - 1)) return NaN;
    const [i, j] = [Math.min(Math.floor(u), cols - 2), Math.min(Math.floor(v), rows - 2)];
    const [fx, fy, at] = [u - i, v - j, j * cols + i];
    if (!(surface[at] && surface[at + 1] && surface[at + cols] && surface[at + cols + 1])) return NaN;
    const upper = z[at] * (1 - fx) + z[at + 1] * fx;
    const lower = z[at + cols] * (1 - fx) + z[at + cols + 1] * fx;
    return (upper * (1 - fy) + lower * fy) * pitch;
  }

  get density() {
    return Math.min(window.devicePixelRatio || 1, 2);
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas;
    const width = Math.max(1, Math.round(clientWidth * this.density));
    const height = Math.max(1, Math.round(clientHeight * this.density));
    this.camera.width = Math.max(clientWidth, 1);
    this.camera.height = Math.max(clientHeight, 1);
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
      return true;
    }
    return false;
  }

  /** Unit vector to the light: x right, y down, z to the viewer. */
  get toLight() {
    const a = (this.light.azimuth * Math.PI) / 180;
    const e = (this.light.elevation * Math.PI) / 180;
    return [Math.cos(e) * Math.cos(a), -Math.cos(e) * Math.sin(a), Math.sin(e)];
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
    if (!this.relief) return;
    this.resize();
    const { gl, relief } = this;
    const stuff = MATERIALS[this.material];
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.useProgram(this.program);
    const u = (name) => (this.places[name] ??= gl.getUniformLocation(this.program, name));
    gl.uniform2f(u("grid"), relief.cols, relief.rows);
    const corner = this.camera.onPlane(0, 0);
    const ratio = (relief.cols - 1) / this.camera.full[0];
    gl.uniform2f(u("origin"), corner.x * ratio, corner.y * ratio);
    gl.uniform1f(u("zoom"), (this.camera.zoom * this.density) / ratio);
    gl.uniform1f(u("canvas_height"), this.canvas.height);
    gl.uniform3f(u("light"), ...this.toLight);
    gl.uniform3f(u("albedo"), ...stuff.albedo);
    gl.uniform2f(u("gloss"), ...stuff.gloss);
    gl.uniform1f(u("grain"), stuff.grain);
    gl.uniform1i(u("material"), stuff.kind);
    gl.uniform1i(u("overlay"), this.overlay);
    gl.uniform2f(u("range"), relief.low / relief.pitch, relief.high / relief.pitch);
    gl.uniform1f(u("contour"), contourStep(relief.high - relief.low) / relief.pitch);
    gl.uniform1i(u("steps"), this.shadows ? 28 : 0);
    gl.uniform3f(u("ground"), 0.16, 0.155, 0.145);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    this.drawn += 1;
  }
}

/** A round number of millimetres between contour lines: about 12 of them. */
export function contourStep(range) {
  const rough = Math.max(range, 1e-6) / 12;
  const power = 10 ** Math.floor(Math.log10(rough));
  return power * ([1, 2, 5, 10].find((step) => step * power >= rough) ?? 10);
}

function build(gl) {
  const program = gl.createProgram();
  for (const [kind, text] of [
    [gl.VERTEX_SHADER, VERTEX],
    [gl.FRAGMENT_SHADER, FRAGMENT],
  ]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  return program;
}
