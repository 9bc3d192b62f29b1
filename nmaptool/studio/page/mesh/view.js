/* Draws a mesh on a canvas as the camera of a bake sees it. */

import { clipMatrix } from "./camera.js";
import { linked } from "../stage/gl.js";

const VERTEX = `#version 300 es
layout(location = 0) in vec3 position;
uniform mat4 clip;
uniform mat3 turned;
out highp vec3 eye;
void main() {
  eye = turned * position;
  gl_Position = clip * vec4(position, 1.0);
}`;
const FRAGMENT = `#version 300 es
precision highp float;
in highp vec3 eye;
uniform bool as_map;   /* colours of a normal map instead of light and shade */
uniform vec2 canvas;   /* its size in px */
uniform vec2 slant;    /* x and y of the line of sight at the right and upper edge, for z = 1; 0 if orthographic */
out vec4 colour;
void main() {
  vec3 n = cross(dFdx(eye), dFdy(eye));
  float size = length(n);
  n = size > 0.0 ? n / size : vec3(0.0, 0.0, 1.0);
  if (as_map) {
    /* the map of a bake refers to the line of sight, like a height field seen in perspective */
    n = normalize(vec3(n.xy, dot(n, vec3((1.0 - 2.0 * gl_FragCoord.xy / canvas) * slant, 1.0))));
    colour = vec4(0.5 + 0.5 * n, 1.0);
    return;
  }
  float key = max(dot(n, normalize(vec3(-0.55, 0.6, 0.75))), 0.0);
  float fill = 0.5 + 0.5 * dot(n, normalize(vec3(0.6, -0.3, 0.6)));
  vec3 tone = vec3(0.72, 0.7, 0.66) * (0.72 * key + 0.2 * fill + 0.06);
  colour = vec4(pow(clamp(tone, 0.0, 1.0), vec3(1.0 / 2.2)), 1.0);
}`;

export class MeshView {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext("webgl2", { antialias: true, alpha: false, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error("this browser has no WebGL 2; use a current Firefox, Chrome, Edge or Safari");
    this.program = linked(this.gl, VERTEX, FRAGMENT);
    this.asMap = false;
    this.mesh = null;
    this.camera = null;
    this.due = false;
    this.drawn = 0;
  }

  /** Take a mesh as `decodeMesh` returns it; null frees its memory. */
  load(mesh) {
    const gl = this.gl;
    if (this.array) {
      gl.deleteVertexArray(this.array);
      for (const buffer of this.buffers) gl.deleteBuffer(buffer);
      this.array = null;
    }
    this.mesh = mesh;
    if (!mesh) return;
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    this.buffers = [
      [gl.ARRAY_BUFFER, mesh.positions],
      [gl.ELEMENT_ARRAY_BUFFER, mesh.triangles],
    ].map(([kind, values]) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(kind, buffer);
      gl.bufferData(kind, values, gl.STATIC_DRAW);
      return buffer;
    });
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
  }

  /** Show the mesh by a camera of `frameCamera` at the next frame of the screen; null shows nothing. */
  show(camera) {
    this.camera = camera;
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      this.paint();
    });
  }

  /** Make the canvas as large as its place allows, in the proportions of the picture. */
  fit({ cols, rows }) {
    const place = this.canvas.parentElement;
    const scale = Math.min(place.clientWidth / cols, place.clientHeight / rows);
    const [width, height] = [Math.max(1, Math.floor(cols * scale)), Math.max(1, Math.floor(rows * scale))];
    const density = Math.min(window.devicePixelRatio || 1, 2);
    Object.assign(this.canvas.style, { width: `${width}px`, height: `${height}px` });
    const size = [Math.round(width * density), Math.round(height * density)];
    if (this.canvas.width !== size[0]) this.canvas.width = size[0];
    if (this.canvas.height !== size[1]) this.canvas.height = size[1];
  }

  paint() {
    const { gl, camera, mesh } = this;
    if (camera) this.fit(camera);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...(this.asMap ? [0.5, 0.5, 1] : [0.13, 0.125, 0.115]), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.drawn += 1;
    if (!mesh || !camera) return;
    gl.enable(gl.DEPTH_TEST);
    gl.useProgram(this.program);
    gl.bindVertexArray(this.array);
    const place = (name) => gl.getUniformLocation(this.program, name);
    gl.uniformMatrix4fv(place("clip"), false, clipMatrix(camera, mesh.header.origin));
    gl.uniformMatrix3fv(place("turned"), true, new Float32Array(camera.rotation));
    gl.uniform1i(place("as_map"), this.asMap ? 1 : 0);
    const half = camera.distance === null ? 0 : camera.unitPerPx / camera.distance / 2;
    gl.uniform2f(place("slant"), half * camera.cols, half * camera.rows);
    gl.uniform2f(place("canvas"), this.canvas.width, this.canvas.height);
    gl.drawElements(gl.TRIANGLES, mesh.triangles.length, gl.UNSIGNED_INT, 0);
  }
}
