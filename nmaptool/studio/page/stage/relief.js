/* A relief on the graphics card: its heights, and what is computed from them for the picture. */

import { Program, Texture } from "./gl.js";
import { HEIGHTS, OCCLUSION, SHADOW, SLOPES, WHOLE } from "./passes.js";

/** Longest side of what is computed while something moves, and when it rests; on a card or on the processor. */
const SIZES = {
  card: { moving: { shadow: 1024, occlusion: 512 }, resting: { shadow: 2048, occlusion: 1024 } },
  processor: { moving: { shadow: 160, occlusion: 96 }, resting: { shadow: 1024, occlusion: 512 } },
};

// while heights move, the occlusion is computed again after this time
const OCCLUSION_MS = 120;

/**
 * Give vertices off the surface a height: that of the surface beside them, so that its edge is not bent down between
 * vertices, and the lowest farther away, so that they cast no shadow.
 */
export function close({ z, surface, cols, rows, lowPx }, into) {
  for (let y = 0, i = 0; y < rows; y++)
    for (let x = 0; x < cols; x++, i++) {
      if (surface[i]) {
        into[i] = z[i];
        continue;
      }
      let [sum, count] = [0, 0];
      for (let v = Math.max(y - 1, 0); v <= Math.min(y + 1, rows - 1); v++)
        for (let u = Math.max(x - 1, 0); u <= Math.min(x + 1, cols - 1); u++) {
          const beside = v * cols + u;
          if (!surface[beside]) continue;
          sum += z[beside];
          count += 1;
        }
      into[i] = count ? sum / count : lowPx;
    }
}

/** The programs that reliefs share. */
export class Passes {
  constructor({ gl, isLinear, isSoftware }) {
    this.gl = gl;
    this.isLinear = isLinear;
    this.sizes = SIZES[isSoftware ? "processor" : "card"];
    const made = (text) => new Program(gl, WHOLE, HEIGHTS(isLinear) + text);
    const slopes = (quick, holes) => made(`#define QUICK ${quick}\n#define HOLES ${holes}\n${SLOPES}`);
    this.slopes = [0, 1].map((quick) => [0, 1].map((holes) => slopes(quick, holes)));
    this.quick = isSoftware;
    this.occlusion = made(OCCLUSION);
    this.shadow = made(SHADOW);
  }
}

export class Relief {
  constructor(passes) {
    const { gl } = passes;
    this.passes = passes;
    this.heights = new Texture(gl, "R32F", { filter: passes.isLinear ? "LINEAR" : "NEAREST" });
    this.surface = new Texture(gl, "R8");
    this.slopes = new Texture(gl, "RGBA16F", { levels: true });
    this.occlusion = new Texture(gl, "R8");
    this.shadows = [0, 1].map(() => new Texture(gl, "RG16F"));
    this.mask = null;
    this.grid = [1, 1];
    this.done = { slopes: null, occlusion: null, shadow: null };
    this.occludedAt = -Infinity;
  }

  /** Take heights in px of the grid, a mask, and the lowest and highest height. */
  fill({ z, surface, cols, rows, lowPx, highPx }) {
    this.grid = [cols, rows];
    this.range = [lowPx, highPx];
    if (this.mask !== surface) {
      this.mask = surface;
      this.surface.fill(surface, cols, rows);
      this.hasHoles = surface.includes(0);
    }
    if (this.hasHoles && this.closed?.length !== z.length) this.closed = new Float32Array(z.length);
    if (this.hasHoles) close({ z, surface, cols, rows, lowPx }, this.closed);
    this.heights.fill(this.hasHoles ? this.closed : z, cols, rows);
    this.done = { slopes: null, occlusion: null, shadow: null };
  }

  get inputs() {
    return { heights: this.heights.texture, surface: this.surface.texture, grid: this.grid };
  }

  /** Compute what is out of date: coarsely while something moves, finely when it rests. */
  prepare({ light, moving, shadows }) {
    const { resting } = this.passes.sizes;
    const now = moving ? this.passes.sizes.moving : resting;
    const wanted = (most) => Math.min(most, Math.max(...this.grid));
    const quick = Number(moving && this.passes.quick);
    if (this.done.slopes === null || this.done.slopes > quick) this.slope(quick);
    this.prepareOcclusion(wanted(now.occlusion), wanted(resting.occlusion), moving);
    if (!shadows) return;
    const key = (size) => [...light, size].join();
    const isFine = this.done.shadow === key(wanted(resting.shadow));
    if (isFine || this.done.shadow === key(wanted(now.shadow))) return;
    this.cast(light, wanted(now.shadow));
    this.done.shadow = key(wanted(now.shadow));
  }

  /** While heights move, the occlusion may be a little older than they are: it changes less than they do. */
  prepareOcclusion(size, fine, moving) {
    const isYoung = moving && this.occlusion.texture && performance.now() - this.occludedAt < OCCLUSION_MS;
    if (isYoung || this.done.occlusion === fine || this.done.occlusion === size) return;
    this.occlude(size);
    this.occludedAt = performance.now();
  }

  slope(quick) {
    this.slopes.resize(...this.grid);
    this.slopes.draw(this.passes.slopes[quick][Number(this.hasHoles)], this.inputs);
    this.slopes.reduce();
    this.done.slopes = quick;
  }

  scaled(longest) {
    const share = longest / Math.max(...this.grid);
    return this.grid.map((count) => Math.max(1, Math.round(count * share)));
  }

  occlude(longest) {
    const target = this.scaled(longest);
    this.occlusion.resize(...target);
    const reach = 0.05 * Math.max(...this.grid);
    const values = { slopes: this.slopes.texture, target, reach, taps: longest > 200 ? 6 : 4 };
    this.occlusion.draw(this.passes.occlusion, { ...this.inputs, ...values });
    this.done.occlusion = longest;
  }

  /** Cast the shadow of a light: a unit vector, x right, y down, z to the viewer. */
  cast(light, longest) {
    const target = this.scaled(longest);
    for (const texture of this.shadows) texture.resize(...target);
    const level = Math.max(Math.hypot(light[0], light[1]), 1e-4);
    const rise = Math.max(light[2], 1e-3) / level;
    const way = [light[0] / level, light[1] / level];
    const pace = Math.max(1, this.grid[0] / target[0]);
    const end = Math.min((this.range[1] - this.range[0]) / rise, Math.hypot(...this.grid));
    for (let far = 0; far === 0 || far < end; far = far === 0 ? pace : 2 * far) {
      const values = { before: this.shadows[1].texture, target, way, rise, far, pace };
      this.shadows[0].draw(this.passes.shadow, { ...this.inputs, ...values });
      this.shadows.reverse();
    }
  }

  /** The textures of the picture. */
  get textures() {
    return {
      ...this.inputs,
      slopes: this.slopes.texture,
      occlusion: this.occlusion.texture,
      shadow: this.shadows[1].texture,
    };
  }

  free() {
    for (const texture of [this.heights, this.surface, this.slopes, this.occlusion, ...this.shadows]) texture.free();
  }
}
