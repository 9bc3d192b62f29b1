/* Draws reliefs on the canvas: flat or turned, one or two beside each other. */

import { dot } from "./camera.js";
import { Program, start, Texture } from "./gl.js";
import { MATERIALS, noise, palette } from "./materials.js";
import { HEIGHTS, WHOLE } from "./passes.js";
import { Passes, Relief } from "./relief.js";
import { BACKDROP, FLAT, LIFTED, SIDE, SIDES, TURNED } from "./shaders.js";
import { CHOICES, SHADING } from "./shading.js";

// vertices along the longer side of the mesh in the orbit view
const MESH = { card: { moving: 513, resting: 1025 }, processor: { moving: 65, resting: 257 } };
const SAMPLES = 4;

export class Renderer {
  constructor(canvas) {
    const context = start(canvas);
    const { gl, isLinear } = context;
    this.gl = gl;
    this.passes = new Passes(context);
    /** Share of the device pixels that are drawn while something moves. */
    this.coarse = context.isSoftware ? 0.4 : 1;
    this.meshes = MESH[context.isSoftware ? "processor" : "card"];
    this.head = HEIGHTS(isLinear);
    this.built = new Map(); // programs by what they draw and the choices
    this.backdrop = new Program(gl, WHOLE, BACKDROP);
    this.noise = picture(gl, noise(), "REPEAT");
    this.palette = picture(gl, palette(), "CLAMP_TO_EDGE");
    this.layer = new Texture(gl, "R8");
    this.layer.fill(new Uint8Array(1), 1, 1);
    this.triangles = { key: "", count: 0, buffer: gl.createBuffer() };
    this.smooth = null; // a multisampled target for the outline of the turned plate
  }

  /** The program that draws the relief "flat", "turned" or its "sides" for a scene; built when it is first needed. */
  program(kind, scene, { relief }) {
    const stuff = MATERIALS[scene.material];
    const choices = [
      stuff.kind,
      Number(stuff.finish[0] > 0.3),
      Number(stuff.finish[1] < 0.7),
      kind === "sides" ? 0 : scene.overlay,
      scene.lights.length,
      Number(scene.shadows),
      Number(relief.hasHoles),
    ];
    const key = [kind, ...choices].join();
    if (!this.built.has(key)) {
      const chosen = CHOICES.map((name, i) => `#define ${name} ${choices[i]}\n`).join("");
      const [vertex, fragment] = {
        flat: [WHOLE, FLAT],
        turned: [this.head + LIFTED, TURNED],
        sides: [this.head + SIDES, SIDE],
      }[kind];
      this.built.set(key, new Program(this.gl, vertex, this.head + chosen + SHADING + fragment));
    }
    return this.built.get(key);
  }

  relief() {
    return new Relief(this.passes);
  }

  /** Show bytes of the studio, such as the curl, over the relief. */
  showLayer({ values, width, height }) {
    this.layer.fill(values, width, height);
  }

  /**
   * Draw.
   *
   * @param {object} scene  `camera`, `density`, `moving`, `lights` (direction, strength), `material`, `overlay`, `shadows`,
   *   `contour` and `steepest`, and `parts`: reliefs with the range of the canvas, 0 to 1, that each is shown in
   */
  paint(scene) {
    const { gl } = this;
    const first = scene.lights[0].direction;
    for (const { relief } of scene.parts)
      relief.prepare({ light: first, moving: scene.moving, shadows: scene.shadows });
    const { width, height } = gl.canvas;
    const isSmooth = scene.camera.orbits && !scene.moving;
    if (isSmooth) this.openSmooth(width, height);
    gl.viewport(0, 0, width, height);
    for (const part of scene.parts) {
      const [left, right] = part.range.map((share) => Math.round(share * width));
      gl.enable(gl.SCISSOR_TEST);
      gl.scissor(left, 0, right - left, height);
      if (scene.camera.orbits) this.paintTurned(scene, part);
      else this.paintFlat(scene, part);
      gl.disable(gl.SCISSOR_TEST);
    }
    if (isSmooth) this.closeSmooth(width, height);
  }

  paintFlat(scene, part) {
    const { gl } = this;
    const { camera, density } = scene;
    const corner = camera.onPlane(0, camera.height);
    const ratio = part.relief.grid.map((count, i) => (count - 1) / camera.full[i]);
    const pace = 1 / (camera.zoom * density);
    this.program("flat", scene, part).use({
      ...this.looks(scene, part),
      corner: [corner.x * ratio[0], corner.y * ratio[1]],
      step_px: [pace * ratio[0], -pace * ratio[1]],
    });
    gl.disable(gl.DEPTH_TEST);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  paintTurned(scene, part) {
    const { gl } = this;
    const { camera } = scene;
    const { grid } = part.relief;
    gl.disable(gl.DEPTH_TEST);
    this.backdrop.use({ ground: scene.ground, size: [gl.canvas.width, gl.canvas.height] });
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.enable(gl.DEPTH_TEST);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    const { near } = camera.axes();
    const values = {
      ...this.looks(scene, part),
      matrix: camera.matrix(),
      unit: grid.map((count, i) => camera.full[i] / (count - 1)),
      bottom: part.bottomPx,
      eye: camera.target.map((value, i) => value + camera.distance * near[i]),
    };
    const mesh = this.mesh(grid, scene.moving);
    this.program("turned", scene, part).use({ ...values, mesh });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.triangles.buffer);
    gl.drawElements(gl.TRIANGLES, this.triangles.count, gl.UNSIGNED_INT, 0);
    const sides = this.program("sides", scene, part);
    [
      [0, -1, 0],
      [1, 0, 0],
      [0, 1, 0],
      [-1, 0, 0],
    ].forEach((outward, side) => {
      const edge = [1, 2].includes(side) ? camera.full : [0, 0];
      if (dot(outward, values.eye) <= dot(outward, [...edge, 0])) return; // seen from behind
      const count = mesh[side % 2];
      sides.use({ ...values, side, count, outward });
      gl.drawArrays(gl.TRIANGLE_STRIP, 0, 2 * count);
    });
  }

  /** Build the triangles over a grid, if they are not there; returns columns and rows of vertices. */
  mesh(grid, moving) {
    const { gl } = this;
    const longest = Math.min(this.meshes[moving ? "moving" : "resting"], Math.max(...grid));
    const share = (longest - 1) / (Math.max(...grid) - 1);
    const size = grid.map((count) => Math.max(2, Math.round((count - 1) * share) + 1));
    if (this.triangles.key === size.join()) return size;
    const indices = triangles(...size);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.triangles.buffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    Object.assign(this.triangles, { key: size.join(), count: indices.length });
    return size;
  }

  looks(scene, { relief }) {
    const stuff = MATERIALS[scene.material];
    return {
      ...relief.textures,
      noise: this.noise.texture,
      palette: this.palette.texture,
      layer: this.layer.texture,
      to_light: scene.lights.flatMap((light) => light.direction),
      strength: scene.lights.map((light) => light.strength),
      albedo: stuff.albedo,
      hollow: stuff.hollow,
      finish: stuff.finish,
      range: relief.range,
      contour: [scene.contourMm / relief.pitch, 5],
      steepest: scene.steepest,
      ground: scene.ground,
    };
  }

  openSmooth(width, height) {
    const { gl } = this;
    if (this.smooth?.width !== width || this.smooth?.height !== height) {
      if (this.smooth) {
        gl.deleteFramebuffer(this.smooth.frame);
        for (const buffer of this.smooth.buffers) gl.deleteRenderbuffer(buffer);
      }
      const frame = gl.createFramebuffer();
      gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
      const buffers = [
        [gl.RGBA8, gl.COLOR_ATTACHMENT0],
        [gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT],
      ].map(([format, place]) => {
        const buffer = gl.createRenderbuffer();
        gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
        gl.renderbufferStorageMultisample(gl.RENDERBUFFER, SAMPLES, format, width, height);
        gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, buffer);
        return buffer;
      });
      this.smooth = { width, height, frame, buffers };
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.smooth.frame);
  }

  closeSmooth(width, height) {
    const { gl } = this;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.smooth.frame);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }
}

/** Two triangles for each cell of a grid of vertices. */
export function triangles(cols, rows) {
  const indices = new Uint32Array(6 * (cols - 1) * (rows - 1));
  let at = 0;
  for (let j = 0; j < rows - 1; j++)
    for (let i = 0; i < cols - 1; i++) {
      const corner = j * cols + i;
      indices[at++] = corner;
      indices[at++] = corner + cols;
      indices[at++] = corner + 1;
      indices[at++] = corner + 1;
      indices[at++] = corner + cols;
      indices[at++] = corner + cols + 1;
    }
  return indices;
}

function picture(gl, { pixels, width, height }, wrap) {
  const texture = new Texture(gl, "RGBA8", { wrap, levels: wrap === "REPEAT" });
  texture.fill(pixels, width, height);
  return texture;
}
