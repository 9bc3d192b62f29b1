/* WebGL 2: programs, textures and targets. */

/** Start WebGL with what the view needs; throws an error in plain words if it is not there. */
export function start(canvas) {
  const gl = canvas.getContext("webgl2", { antialias: false, depth: true, preserveDrawingBuffer: true });
  if (!gl) throw new Error("this browser has no WebGL 2; use a current Firefox, Chrome, Edge or Safari");
  if (!gl.getExtension("EXT_color_buffer_float") && !gl.getExtension("EXT_color_buffer_half_float"))
    throw new Error("this graphics card cannot draw to floating-point textures; use another browser or computer");
  const isLinear = Boolean(gl.getExtension("OES_texture_float_linear"));
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  return { gl, isLinear, isSoftware: isSoftware(gl) };
}

/** Whether the processor draws instead of a graphics card: then less is computed at once. */
function isSoftware(gl) {
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(String(name));
}

/** A program whose uniforms are set from an object: numbers, arrays, and textures. */
export class Program {
  constructor(gl, vertex, fragment) {
    this.gl = gl;
    this.program = gl.createProgram();
    for (const [kind, text] of [
      [gl.VERTEX_SHADER, vertex],
      [gl.FRAGMENT_SHADER, fragment],
    ]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
      gl.deleteShader(shader);
    }
    gl.linkProgram(this.program);
    this.uniforms = null;
  }

  /** Read the uniforms; a program is linked by then, or the reason why not is thrown. */
  finish() {
    const { gl, program } = this;
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      const logs = gl.getAttachedShaders(program).map((shader) => gl.getShaderInfoLog(shader));
      throw new Error([gl.getProgramInfoLog(program), ...logs].filter(Boolean).join("\n"));
    }
    this.uniforms = new Map();
    let unit = 0;
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
      const { name, type } = gl.getActiveUniform(program, i);
      const place = gl.getUniformLocation(program, name);
      const isTexture = type === gl.SAMPLER_2D;
      this.uniforms.set(name.replace("[0]", ""), { place, type, unit: isTexture ? unit++ : null });
    }
  }

  /** Use the program with these values. */
  use(values) {
    const { gl } = this;
    if (!this.uniforms) this.finish();
    gl.useProgram(this.program);
    for (const [name, value] of Object.entries(values)) {
      const uniform = this.uniforms.get(name);
      if (uniform) this.set(uniform, value);
    }
  }

  set({ place, type, unit }, value) {
    const { gl } = this;
    if (unit !== null) {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, value);
      gl.uniform1i(place, unit);
    } else if (type === gl.FLOAT) gl.uniform1fv(place, [value].flat());
    else if (type === gl.INT || type === gl.BOOL) gl.uniform1i(place, value);
    else if (type === gl.INT_VEC2) gl.uniform2iv(place, value);
    else if (type === gl.FLOAT_VEC2) gl.uniform2fv(place, value);
    else if (type === gl.FLOAT_VEC3) gl.uniform3fv(place, value);
    else if (type === gl.FLOAT_VEC4) gl.uniform4fv(place, value);
    else if (type === gl.FLOAT_MAT4) gl.uniformMatrix4fv(place, false, value);
  }
}

/** A program of WebGL, linked; throws the reason if it cannot be. */
export function linked(gl, vertex, fragment) {
  const made = new Program(gl, vertex, fragment);
  made.finish();
  return made.program;
}

const FORMATS = {
  R8: ["RED", "UNSIGNED_BYTE"],
  R32F: ["RED", "FLOAT"],
  RG16F: ["RG", "HALF_FLOAT"],
  RGBA16F: ["RGBA", "HALF_FLOAT"],
  RGBA8: ["RGBA", "UNSIGNED_BYTE"],
};

/** A texture of a fixed format that keeps its memory as long as its size does. */
export class Texture {
  /** @param {object} how  `filter` and `wrap` as in WebGL, and `levels`: true for a pyramid of smaller pictures */
  constructor(gl, format, { filter = "LINEAR", wrap = "CLAMP_TO_EDGE", levels = false } = {}) {
    Object.assign(this, { gl, format, filter, wrap, levels, width: 0, height: 0, texture: null, frame: null });
  }

  resize(width, height) {
    if (this.width === width && this.height === height) return;
    const { gl } = this;
    this.free();
    [this.width, this.height] = [width, height];
    this.texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    const levels = this.levels ? 1 + Math.floor(Math.log2(Math.max(width, height))) : 1;
    gl.texStorage2D(gl.TEXTURE_2D, levels, gl[this.format], width, height);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl[this.filter]);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl[this.levels ? "LINEAR_MIPMAP_LINEAR" : this.filter]);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl[this.wrap]);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl[this.wrap]);
  }

  /** Fill the texture with numbers. */
  fill(numbers, width, height) {
    const { gl } = this;
    this.resize(width, height);
    const [kind, type] = FORMATS[this.format];
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl[kind], gl[type], numbers);
    this.reduce();
  }

  /** Compute the smaller pictures. */
  reduce() {
    if (!this.levels) return;
    this.gl.bindTexture(this.gl.TEXTURE_2D, this.texture);
    this.gl.generateMipmap(this.gl.TEXTURE_2D);
  }

  /** Draw a program over the whole texture. */
  draw(program, values) {
    const { gl } = this;
    if (!this.frame) {
      this.frame = gl.createFramebuffer();
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.texture, 0);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    gl.viewport(0, 0, this.width, this.height);
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.SCISSOR_TEST);
    program.use(values);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  free() {
    this.gl.deleteTexture(this.texture);
    this.gl.deleteFramebuffer(this.frame);
    Object.assign(this, { texture: null, frame: null, width: 0, height: 0 });
  }
}
