/*
 * Where the relief is seen from. Document coordinates are vertices of the full map: x right, y down, z to the viewer,
 * all in px of the map. The screen is in CSS px from the upper left corner of the canvas.
 */

const FOCUS = 1 / Math.tan((15 * Math.PI) / 180); // a field of view of 30 degrees
const DEFAULT_TURN = { yaw: -20, tilt: 48 };
const SHARE = 0.92; // of the canvas that the whole map fills
const [LEAST_ZOOM, MOST_ZOOM] = [0.01, 64];

export class Camera {
  constructor() {
    this.width = 1;
    this.height = 1;
    this.full = [1, 1]; // columns and rows of the map in px
    this.orbits = false;
    this.zoom = 1; // CSS px per px of the map; in the orbit view, at the target
    this.target = [0.5, 0.5, 0];
    this.isFitted = true; // until the user zooms or moves the view
    this.turn = { ...DEFAULT_TURN }; // degrees: about the plate's normal, and from the view straight on
  }

  /** Show the whole map. */
  fit() {
    this.isFitted = true;
    const [cols, rows] = this.full;
    this.target = [cols / 2, rows / 2, 0];
    this.zoom = SHARE * Math.min(this.width / cols, this.height / rows);
    // perspective makes near corners larger: a few steps settle it
    for (let i = 0; this.orbits && i < 6; i++) {
      const { left, right, top, bottom } = this.outline();
      this.shift((this.width - left - right) / 2, (this.height - top - bottom) / 2);
      this.zoom *= SHARE * Math.min(this.width / (right - left), this.height / (bottom - top));
    }
  }

  /** The box of the plate's corners on the screen. */
  outline() {
    const [cols, rows] = this.full;
    const corners = [0, cols].flatMap((x) => [0, rows].map((y) => this.toScreen(x, y)));
    const [xs, ys] = [corners.map(({ x }) => x), corners.map(({ y }) => y)];
    return { left: Math.min(...xs), right: Math.max(...xs), top: Math.min(...ys), bottom: Math.max(...ys) };
  }

  /** Look at the plate from the default direction. */
  reset() {
    this.turn = { ...DEFAULT_TURN };
    this.fit();
  }

  /** Directions of the screen in document coordinates: right, up, and to the viewer. */
  axes() {
    if (!this.orbits) return { right: [1, 0, 0], up: [0, -1, 0], near: [0, 0, 1] };
    const [yaw, tilt] = [this.turn.yaw, this.turn.tilt].map((angle) => (angle * Math.PI) / 180);
    const [c, s, ct, st] = [Math.cos(yaw), Math.sin(yaw), Math.cos(tilt), Math.sin(tilt)];
    return { right: [c, s, 0], up: [s * ct, -c * ct, st], near: [-s * st, c * st, ct] };
  }

  /** Distance of the viewer from the target in px of the map. */
  get distance() {
    return (FOCUS * this.height) / 2 / this.zoom;
  }

  /** Place on the screen of a point. */
  toScreen(x, y, z = 0) {
    const from = [x - this.target[0], y - this.target[1], z - this.target[2]];
    const { right, up, near } = this.axes();
    const factor = this.orbits ? (this.zoom * this.distance) / (this.distance - dot(near, from)) : this.zoom;
    return { x: this.width / 2 + factor * dot(right, from), y: this.height / 2 - factor * dot(up, from) };
  }

  /** The line of sight through a place on the screen: a point of it and its direction. */
  ray(x, y) {
    const { right, up, near } = this.axes();
    const [u, v] = [(x - this.width / 2) / this.zoom, (this.height / 2 - y) / this.zoom];
    const inPlane = [0, 1, 2].map((i) => this.target[i] + u * right[i] + v * up[i]);
    if (!this.orbits) return { from: inPlane, way: [0, 0, -1] };
    const eye = [0, 1, 2].map((i) => this.target[i] + this.distance * near[i]);
    return { from: eye, way: unit([0, 1, 2].map((i) => inPlane[i] - eye[i])) };
  }

  /** Where a place on the screen lies in a plane of constant height; null if the line of sight does not meet it. */
  onPlane(x, y, z = 0) {
    const { from, way } = this.ray(x, y);
    if (!this.orbits) return { x: from[0], y: from[1] };
    const t = (z - from[2]) / way[2];
    if (!(t > 0 && Number.isFinite(t))) return null;
    return { x: from[0] + t * way[0], y: from[1] + t * way[1] };
  }

  /**
   * Where a place on the screen lies on a surface.
   *
   * @param {(x: number, y: number) => number} heightAt  NaN outside the surface
   * @param {number} low  lowest height
   * @param {number} high  highest height
   */
  onSurface(x, y, heightAt, low, high) {
    const { from, way } = this.ray(x, y);
    if (!this.orbits) return { x: from[0], y: from[1] };
    if (!(way[2] < -1e-6)) return null;
    const [first, last] = [high, low].map((z) => (z - from[2]) / way[2]);
    const steps = 256;
    const place = (t) => [from[0] + t * way[0], from[1] + t * way[1], from[2] + t * way[2]];
    const below = (t) => {
      const [px, py, pz] = place(t);
      return heightAt(px, py) >= pz;
    };
    let above = first;
    for (let i = 1; i <= steps; i++) {
      const t = first + ((last - first) * i) / steps;
      if (below(t)) {
        let under = t;
        for (let k = 0; k < 16; k++) {
          const middle = (above + under) / 2;
          if (below(middle)) under = middle;
          else above = middle;
        }
        const [px, py] = place(under);
        return { x: px, y: py };
      }
      above = t;
    }
    return this.onPlane(x, y, low);
  }

  /** The canvas has another size: a view that shows the whole map still does. */
  resize(width, height) {
    if (this.width === width && this.height === height) return;
    [this.width, this.height] = [width, height];
    if (this.isFitted) this.fit();
  }

  /** Change the zoom; what is at a place on the screen stays there. */
  zoomAt(x, y, factor) {
    this.isFitted = false;
    const { right, up } = this.axes();
    const before = this.zoom;
    this.zoom = Math.min(Math.max(this.zoom * factor, LEAST_ZOOM), MOST_ZOOM);
    const share = 1 / before - 1 / this.zoom;
    const [u, v] = [(x - this.width / 2) * share, (this.height / 2 - y) * share];
    this.target = this.target.map((value, i) => value + u * right[i] + v * up[i]);
  }

  /** Move what is seen by px of the screen. */
  pan(dx, dy) {
    this.isFitted = false;
    this.shift(dx, dy);
  }

  shift(dx, dy) {
    const { right, up } = this.axes();
    this.target = this.target.map((value, i) => value - (dx * right[i] - dy * up[i]) / this.zoom);
  }

  /** Turn the plate by degrees. */
  orbit(yaw, tilt) {
    this.turn = {
      yaw: ((((this.turn.yaw + yaw + 180) % 360) + 360) % 360) - 180,
      tilt: Math.min(Math.max(this.turn.tilt + tilt, 0), 88),
    };
  }

  /** Show one px of the map as `share` CSS px, about the middle of the screen. */
  scaleTo(share) {
    this.zoomAt(this.width / 2, this.height / 2, share / this.zoom);
  }

  /** Column-major matrix from document coordinates to the clip space of the graphics card. */
  matrix() {
    const { right, up, near } = this.axes();
    const far = this.distance + 2 * Math.hypot(...this.full) + this.distance;
    const close = 0.02 * this.distance;
    const [sx, sy] = [(FOCUS * this.height) / this.width, FOCUS];
    const [a, b] = [-(far + close) / (far - close), (-2 * far * close) / (far - close)];
    const rows = [
      [...right.map((v) => sx * v), -sx * dot(right, this.target)],
      [...up.map((v) => sy * v), -sy * dot(up, this.target)],
      [...near.map((v) => a * v), a * (-dot(near, this.target) - this.distance) + b],
      [...near.map((v) => -v), dot(near, this.target) + this.distance],
    ];
    return Float32Array.from([0, 1, 2, 3].flatMap((column) => rows.map((row) => row[column])));
  }
}

export function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

export function unit(v) {
  const length = Math.hypot(...v) || 1;
  return v.map((value) => value / length);
}
