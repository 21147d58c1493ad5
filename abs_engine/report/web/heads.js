"use strict";
// Heads drawn with WebGL 2: several in one canvas, turned together with the mouse.

const VERTEX = `#version 300 es
in vec3 position; in vec3 normal; in vec3 colour;
uniform mat3 model; uniform vec3 moved; uniform mat3 view; uniform vec3 target;
uniform float reach; uniform float aspect;
out vec3 facing; out vec3 ink; out vec3 place;
const float FAR = 700.0;  // mm from the target to the eye
void main() {
  vec3 p = view * (model * position + moved - target);
  facing = view * (model * normal);
  ink = colour;
  place = vec3(p.xy, p.z - FAR);
  float w = (FAR - p.z) / FAR, z = -p.z / 400.0;
  gl_Position = vec4(p.x / (reach * aspect), p.y / reach, z * w, w);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
in vec3 facing; in vec3 ink; in vec3 place;
uniform vec4 flat_ink; uniform float lit;
out vec4 result;
void main() {
  if (lit == 0.0) { result = vec4(flat_ink.rgb * flat_ink.a, flat_ink.a); return; }
  vec3 n = normalize(facing), eye = normalize(-place);
  if (dot(n, eye) < 0.0) n = -n;
  float key = max(dot(n, normalize(vec3(0.4, 0.6, 0.9))), 0.0);
  float fill = max(dot(n, normalize(vec3(-0.7, 0.1, 0.6))), 0.0);
  float shade = mix(1.0, 0.38 + 0.56 * key + 0.20 * fill, lit);
  result = vec4(min(ink * shade, 1.0), 1.0);
}`;

const BREADTH = 0.92;  // of a head, as a share of its height

class HeadView {
  constructor(canvas, faces, weld) {
    const options = { antialias: true, preserveDrawingBuffer: true, alpha: false };
    const gl = canvas.getContext("webgl2", options);
    if (!gl) throw new Error("WebGL 2 is not available");
    this.canvas = canvas;
    this.gl = gl;
    this.faces = faces;
    this.weld = weld;
    this.normals = new Float32Array(3 * weld.length);
    this.program = this.link();
    this.buffers = {};
    for (const name of ["position", "normal", "colour"]) this.buffers[name] = gl.createBuffer();
    this.solid = this.indices(faces);
    this.wire = this.indices(edgesOf(faces, weld.length));
    this.turn = { yaw: 0, pitch: 0 };
    this.zoom = 1;
    this.onturn = () => {};
    this.listen();
  }

  link() {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      throw new Error(`the shaders do not link: ${gl.getProgramInfoLog(program)}`);
    }
    return program;
  }

  indices(list) {
    const gl = this.gl, buffer = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, Uint32Array.from(list), gl.STATIC_DRAW);
    return { buffer, count: list.length };
  }

  listen() {
    const canvas = this.canvas;
    let from = null;
    canvas.addEventListener("pointerdown", (event) => {
      from = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!from) return;
      this.turn.yaw += (event.clientX - from[0]) * 0.008;
      this.turn.pitch += (event.clientY - from[1]) * 0.008;
      this.turn.pitch = Math.max(-1.5, Math.min(1.5, this.turn.pitch));
      from = [event.clientX, event.clientY];
      this.onturn();
    });
    for (const name of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(name, () => { from = null; });
    }
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.shiftKey) return;  // else the page scrolls
      event.preventDefault();
      this.zoom = Math.max(0.3, Math.min(8, this.zoom * Math.exp(-(event.deltaY || event.deltaX) * 0.002)));
      this.onturn();
    }, { passive: false });
  }

  // Fit the pixels to the element, and clear them.
  begin() {
    const gl = this.gl, canvas = this.canvas, fine = window.devicePixelRatio || 1;
    const width = Math.max(1, Math.round(canvas.clientWidth * fine));
    const height = Math.max(1, Math.round(canvas.clientHeight * fine));
    if (canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
    }
    gl.disable(gl.SCISSOR_TEST);
    gl.clearColor(0.953, 0.949, 0.937, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(this.program);
  }

  // Draw a head. `box`: left, bottom, width, height as shares of the canvas. `look`: positions,
  // colours (bytes), model (9 numbers, by rows), moved, target, reach (mm), wire (ink) or lit.
  draw(box, look) {
    const gl = this.gl, w = this.canvas.width, h = this.canvas.height;
    const pixels = [box[0] * w, box[1] * h, box[2] * w, box[3] * h].map(Math.round);
    gl.viewport(...pixels);
    const yaw = this.turn.yaw + (look.yaw || 0);
    const at = (name) => gl.getUniformLocation(this.program, name);
    gl.uniformMatrix3fv(at("model"), true, look.model);
    gl.uniform3fv(at("moved"), look.moved);
    gl.uniformMatrix3fv(at("view"), true, viewOf(yaw, this.turn.pitch));
    gl.uniform3fv(at("target"), look.target);
    const aspect = pixels[2] / Math.max(1, pixels[3]);
    const reach = Math.max(look.reach, BREADTH * look.reach / aspect);  // a narrow box
    gl.uniform1f(at("reach"), reach / this.zoom);
    gl.uniform1f(at("aspect"), aspect);
    gl.uniform1f(at("lit"), look.wire ? 0 : look.lit);
    gl.uniform4fv(at("flat_ink"), look.wire || [0, 0, 0, 1]);
    this.feed("position", look.positions, gl.FLOAT);
    normalsOf(look.positions, this.faces, this.weld, this.normals);
    this.feed("normal", this.normals, gl.FLOAT);
    this.feed("colour", look.colours, gl.UNSIGNED_BYTE);
    const list = look.wire ? this.wire : this.solid;
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, list.buffer);
    gl.drawElements(look.wire ? gl.LINES : gl.TRIANGLES, list.count, gl.UNSIGNED_INT, 0);
  }

  feed(name, values, kind) {
    const gl = this.gl, place = gl.getAttribLocation(this.program, name);
    if (place < 0) return;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[name]);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, kind, kind === gl.UNSIGNED_BYTE, 0, 0);
  }
}

function viewOf(yaw, pitch) {
  const c = Math.cos(yaw), s = Math.sin(yaw), d = Math.cos(pitch), t = Math.sin(pitch);
  return [c, 0, s, t * s, d, -t * c, -d * s, t, d * c];
}

// Smooth normals: those of the facets around a vertex, weighted by area. Vertices in the same
// place have the same.
function normalsOf(p, faces, weld, out) {
  out.fill(0);
  for (let f = 0; f < faces.length; f += 3) {
    const a = 3 * faces[f], b = 3 * faces[f + 1], c = 3 * faces[f + 2];
    const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2];
    const vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    for (let k = 0; k < 3; k++) {
      const v = 3 * weld[faces[f + k]];
      out[v] += x; out[v + 1] += y; out[v + 2] += z;
    }
  }
  for (let v = 0; v < weld.length; v++) {
    if (weld[v] !== v) for (let k = 0; k < 3; k++) out[3 * v + k] = out[3 * weld[v] + k];
  }
}

function edgesOf(faces, vertices) {
  const seen = new Set(), list = [];
  for (let f = 0; f < faces.length; f += 3) {
    for (let k = 0; k < 3; k++) {
      const a = faces[f + k], b = faces[f + (k + 1) % 3];
      const key = Math.min(a, b) * vertices + Math.max(a, b);
      if (!seen.has(key)) {
        seen.add(key);
        list.push(a, b);
      }
    }
  }
  return list;
}
