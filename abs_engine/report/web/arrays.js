"use strict";
// Arrays out of deflated text, meshes out of modes.

const KINDS = { f4: Float32Array, i2: Int16Array, u1: Uint8Array, u2: Uint16Array, u4: Uint32Array };

const LOST = -32768;  // of 16 bits: what is not a number

let store = null;  // the bytes of all arrays

function bytesOf(text) {
  const letters = atob(text), bytes = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k++) bytes[k] = letters.charCodeAt(k);
  return bytes;
}

// The bytes that an element holds deflated.
async function inflated(name) {
  const packed = bytesOf(document.getElementById(name).textContent);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// An array out of the store, see Store in Python.
function unpack({ kind, shape, at, row, step }) {
  const Kind = KINDS[kind], wide = Kind.BYTES_PER_ELEMENT;
  const count = shape.reduce((a, b) => a * b, 1), bytes = new Uint8Array(count * wide);
  for (let b = 0; b < wide; b++) {
    for (let k = 0; k < count; k++) bytes[k * wide + b] = store[at + b * count + k];
  }
  const numbers = new Kind(bytes.buffer);
  if (row) for (let k = row; k < count; k++) numbers[k] += numbers[k - row];
  if (step === null) return numbers;
  return Float32Array.from(numbers, (n) => (n === LOST ? NaN : n * step));
}

// A moving mesh: mean + weights x modes, see LinearSurface in Python.
class Motion {
  constructor(packed) {
    this.mean = unpack(packed.mean);
    this.modes = unpack(packed.modes);
    this.weights = unpack(packed.weights);
    this.lost = unpack(packed.lost);
    this.count = packed.modes.shape[0];
    this.length = this.mean.length;
    this.now = new Float32Array(this.length);
    this.frame = -1;
  }

  // Vertices of a frame, x y z after x y z; null in a lost frame. Valid until the next call.
  at(frame) {
    if (this.lost[frame]) return null;
    if (frame === this.frame) return this.now;
    this.now.set(this.mean);
    for (let r = 0; r < this.count; r++) {
      const weight = this.weights[frame * this.count + r], from = r * this.length;
      if (weight === 0) continue;
      for (let k = 0; k < this.length; k++) this.now[k] += weight * this.modes[from + k];
    }
    this.frame = frame;
    return this.now;
  }
}

// A rotation vector as the rows of its matrix (Rodrigues).
function rotationOf(x, y, z) {
  const angle = Math.hypot(x, y, z);
  if (angle < 1e-9) return [1, 0, 0, 0, 1, 0, 0, 0, 1];
  const c = Math.cos(angle), s = Math.sin(angle), k = 1 - c;
  const a = x / angle, b = y / angle, d = z / angle;
  return [
    c + a * a * k, a * b * k - d * s, a * d * k + b * s,
    a * b * k + d * s, c + b * b * k, b * d * k - a * s,
    a * d * k - b * s, b * d * k + a * s, c + d * d * k,
  ];
}
