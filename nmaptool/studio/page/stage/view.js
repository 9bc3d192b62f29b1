/* Draws a relief on a canvas, and moves and zooms it. */

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
    this.zoom = 0;
    this.origin = [0, 0];
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
    const before = this.relief;
    this.relief = { cols, rows, ...mm };
    if (!before) this.fit();
    else if (before.cols !== cols) {
      const factor = (cols - 1) / (before.cols - 1);
      this.zoom /= factor;
      this.origin = this.origin.map((v) => v * factor);
    }
    this.draw();
  }

  /** Show the whole relief. */
  fit() {
    this.resize();
    const { cols, rows } = this.relief;
    this.zoom = 0.94 * Math.min(this.canvas.width / cols, this.canvas.height / rows);
    this.center((cols - 1) / 2, (rows - 1) / 2);
  }

  /** Show one vertex per device pixel. */
  actual() {
    const middle = this.under(this.canvas.width / 2, this.canvas.height / 2);
    this.zoom = 1;
    this.center(...middle);
  }

  center(x, y) {
    this.origin = [x - this.canvas.width / 2 / this.zoom, y - this.canvas.height / 2 / this.zoom];
    this.draw();
  }

  under(x, y) {
    return [this.origin[0] + x / this.zoom, this.origin[1] + y / this.zoom];
  }

  zoomAt(x, y, factor) {
    const [u, v] = this.under(x, y);
    this.zoom = Math.min(Math.max(this.zoom * factor, 0.02), 64);
    this.origin = [u - x / this.zoom, v - y / this.zoom];
    this.draw();
  }

  pan(dx, dy) {
    this.origin = [this.origin[0] - dx / this.zoom, this.origin[1] - dy / this.zoom];
    this.draw();
  }

  resize() {
    const density = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.max(1, Math.round(this.canvas.clientWidth * density));
    const height = Math.max(1, Math.round(this.canvas.clientHeight * density));
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
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
    gl.uniform2f(u("origin"), ...this.origin);
    gl.uniform1f(u("zoom"), this.zoom);
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
