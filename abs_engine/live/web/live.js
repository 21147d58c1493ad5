"use strict";
// The live page: the picture with its contours, the head, and the curves of the last seconds.

const SECONDS = 10, BAND = 1.96;  // standard deviations of a 95 % interval
const ROWS = [  // what a row shows, and the least range of its axis
  { label: "aperture, mm", least: [0, 10], curves: [["aperture", "#0072b2"]] },
  { label: "width, mm", least: [45, 55], curves: [["width", "#009e73"]] },
  { label: "head, degrees", least: [-10, 10],
    curves: [["head_pitch", "#d55e00"], ["head_yaw", "#0072b2"], ["head_roll", "#666666"]] },
];
const $ = (id) => document.getElementById(id);
const live = { frames: [], count: 0, head: null, drawn: 0 };

// The pixels of a canvas as they are on the screen.
function fitted(canvas) {
  const fine = window.devicePixelRatio || 1;
  const width = Math.round(canvas.clientWidth * fine), height = Math.round(canvas.clientHeight * fine);
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const g = canvas.getContext("2d");
  g.setTransform(fine, 0, 0, fine, 0, 0);
  return g;
}

function drawFilm(frame, image) {
  const canvas = $("film"), fine = 2;  // contours are finer than pixels
  const width = fine * image.width, height = fine * image.height;
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const g = canvas.getContext("2d");
  g.drawImage(image, 0, 0, width, height);
  g.lineWidth = 2;
  for (const { points, closed, colour } of frame.contours) {
    g.beginPath();
    for (const [x, y] of points) g.lineTo(fine * x, fine * y);
    if (closed) g.closePath();
    g.strokeStyle = colour;
    g.stroke();
  }
}

// The head at rest and what moves it, see Board in Python.
async function fetchHead() {
  const told = await (await fetch("/head")).json();
  const as = (Kind, name) => new Kind(bytesOf(told[name]).buffer);
  const mean = as(Float32Array, "mean"), weld = as(Uint32Array, "weld");
  const view = new HeadView($("head"), as(Uint32Array, "faces"), weld);
  let low = Infinity, high = -Infinity, front = -Infinity;
  for (let k = 0; k < mean.length; k += 3) {
    low = Math.min(low, mean[k + 1]);
    high = Math.max(high, mean[k + 1]);
    front = Math.max(front, mean[k + 2]);
  }
  view.onturn = drawHead;
  live.head = {
    view, mean, modes: as(Float32Array, "modes"), colours: as(Uint8Array, "colours"),
    positions: mean.slice(), target: [0, (low + high) / 2, front - 60], reach: 0.54 * (high - low),
  };
  drawHead();  // at rest: the next frame may be long in coming
}

function moveHead(weights) {
  const { mean, modes, positions } = live.head;
  positions.set(mean);
  weights.forEach((weight, r) => {
    const from = r * mean.length;
    for (let k = 0; k < mean.length; k++) positions[k] += weight * modes[from + k];
  });
}

function drawHead() {
  const { view, positions, colours, target, reach } = live.head;
  view.begin();
  view.draw([0, 0, 1, 1], {
    positions, colours, target, reach, moved: [0, 0, 0], lit: 1, wire: null,
    model: [1, 0, 0, 0, 1, 0, 0, 0, 1],
  });
  live.drawn += 1;
}

function drawCurves() {
  const canvas = $("curves"), g = fitted(canvas), width = canvas.clientWidth;
  const tall = canvas.clientHeight / ROWS.length, left = 44;
  const now = live.frames.at(-1).time;
  const x = (time) => width - (now - time) / SECONDS * (width - left);
  g.clearRect(0, 0, width, canvas.clientHeight);
  g.font = "12px sans-serif";
  ROWS.forEach((row, k) => drawRow(g, row, { x, left, width, top: k * tall + 18, tall: tall - 26 }));
}

function drawRow(g, { label, least, curves }, { x, left, width, top, tall }) {
  let [low, high] = least;
  for (const frame of live.frames) {
    for (const [name] of curves) {
      if (frame[name] === null) continue;
      low = Math.min(low, frame[name]);
      high = Math.max(high, frame[name]);
    }
  }
  const y = (value) => top + tall * (high - value) / (high - low);
  g.strokeStyle = "#dddddd";
  g.strokeRect(left, top, width - left, tall);
  g.fillStyle = "#666666";
  g.fillText(label, left, top - 5);
  g.fillText(high.toFixed(0), 8, top + 10);
  g.fillText(low.toFixed(0), 8, top + tall);
  curves.forEach(([name, colour], n) => {
    g.fillStyle = colour;
    if (curves.length > 1) g.fillText(name.replace("head_", ""), left + 110 + 60 * n, top - 5);
    g.save();
    g.beginPath();
    g.rect(left, top, width - left, tall);
    g.clip();
    drawBand(g, x, y, name);
    g.strokeStyle = colour;
    g.lineWidth = 1.6;
    g.beginPath();
    let begun = false;
    for (const frame of live.frames) {
      if (frame[name] !== null) g[begun ? "lineTo" : "moveTo"](x(frame.time), y(frame[name]));
      begun = frame[name] !== null;
    }
    g.stroke();
    g.restore();
  });
}

// 95 % intervals, where they are known.
function drawBand(g, x, y, name) {
  g.globalAlpha = 0.18;
  for (let k = 1; k < live.frames.length; k++) {
    const [a, b] = [live.frames[k - 1], live.frames[k]], sd = `${name}_sd`;
    if ([a[name], b[name], a[sd], b[sd]].some((v) => v === null || v === undefined)) continue;
    g.beginPath();
    for (const [f, side] of [[a, 1], [b, 1], [b, -1], [a, -1]]) {
      g.lineTo(x(f.time), y(f[name] + side * BAND * f[sd]));
    }
    g.fill();
  }
  g.globalAlpha = 1;
}

function state(frame) {
  const number = (v, unit) => (v === null ? "?" : v.toFixed(1)) + unit;
  const said = frame.found ? `aperture ${number(frame.aperture, " mm")}` : frame.status;
  return `${frame.time.toFixed(2)} s, ${said}, delay ${frame.delay_ms.toFixed(0)} ms, ` +
    `${frame.dropped} frames dropped`;
}

async function show(frame) {
  const image = new Image();
  image.src = `data:image/jpeg;base64,${frame.picture}`;
  await image.decode();
  frame.picture = null;
  live.frames.push(frame);
  live.frames = live.frames.filter((f) => f.time > frame.time - SECONDS);
  live.count += 1;
  $("state").textContent = state(frame);
  drawFilm(frame, image);
  drawCurves();
  if (frame.weights && live.head) {
    moveHead(frame.weights);
    drawHead();
  }
}

function start() {
  const events = new EventSource("/events");
  let busy = false, asked = false;
  const listen = (name, heed) => events.addEventListener(name, (e) => heed(JSON.parse(e.data)));
  listen("stage", ({ text }) => { $("state").textContent = text; });
  listen("frame", async (frame) => {
    if (!asked) {
      asked = true;
      fetchHead().catch((error) => { $("head").replaceWith(`no head is drawn: ${error.message}`); });
    }
    if (busy) return;  // a slow browser leaves frames out
    busy = true;
    try { await show(frame); } finally { busy = false; }
  });
  listen("end", ({ text }) => {
    events.close();
    $("state").textContent = text;
  });
  events.onerror = () => {
    events.close();
    $("state").textContent = "the session has ended";
  };
}

addEventListener("resize", () => {  // frames may be long in coming
  if (live.frames.length) drawCurves();
  if (live.head) drawHead();
});
start();
