"use strict";
// Puts the page together from its data.

let told = null;
const $ = (name) => document.getElementById(name);

function drawCharts(seek) {
  const drawn = [];
  for (const [name, figure] of Object.entries(told.charts)) {
    const place = $(`chart-${name}`);
    const config = {
      displaylogo: false, responsive: true, doubleClick: "autosize",
      modeBarButtons: [["toImage", "zoom2d", "pan2d", "resetScale2d"]],
    };
    const ready = Plotly.newPlot(place, figure.data, figure.layout, config);
    drawn.push(ready);
    if (name === "boxes") continue;
    const line = document.createElement("div");
    line.className = "cursor";
    place.append(line);
    ready.then(() => {
      place.on("plotly_click", (event) => seek(frameAt(event.points[0].x)));
      place.on("plotly_relayout", () => mark(player ? player.frame : 0));
    });
  }
  return Promise.all(drawn);
}

// The line on the charts that says where the player is.
function mark(frame) {
  for (const line of document.querySelectorAll(".cursor")) {
    const settled = line.parentElement._fullLayout;
    if (!settled || !settled.xaxis) continue;
    const axis = settled.xaxis, at = axis.l2p(told.times[frame]);
    const within = at >= 0 && at <= axis._length;
    line.style.display = within ? "block" : "none";
    line.style.left = `${axis._offset + at}px`;
    line.style.top = `${settled.margin.t}px`;
    line.style.height = `${settled.height - settled.margin.t - settled.margin.b}px`;
  }
}

// The frame that is shown nearest to a time.
function frameAt(time) {
  const away = told.times.map((one) => Math.abs(one - time));
  return away.reduce((best, one, k) => (one < away[best] ? k : best), 0);
}

function phonemeAt(time) {
  const one = told.said.find((s) => time >= s[1] && time < s[2]);
  return one ? one[0] : "";
}

let player = null, stage = null, maps = null, contours = null, film = null;

function filmElement() {
  if (!told.film) return null;
  const element = document.querySelector(".film video");
  element.src = URL.createObjectURL(new Blob([unpack(told.film.data)], { type: "video/mp4" }));
  element.addEventListener("loadeddata", () => player && onframe(player.frame));
  element.addEventListener("seeked", () => player && !player.playing && onframe(player.frame));
  return element;
}

function onframe(frame) {
  if (!player) return;
  if (stage) stage.show(frame);
  if (contours) contours.show(frame);
  mark(frame);
  const time = told.times[frame], said = phonemeAt(time);
  $("scrub").value = frame;
  $("where").textContent = `frame ${frame}, ${time.toFixed(2)} s${said ? `, /${said}/` : ""}`;
  $("play").textContent = player.playing ? "Pause" : "Play";
}

function listen() {
  const redraw = () => stage && stage.show(player.frame);
  $("play").onclick = () => (player.playing ? player.pause() : player.play());
  $("scrub").oninput = () => player.seek(Number($("scrub").value));
  $("speed").onchange = () => player.setSpeed(Number($("speed").value));
  for (const button of document.querySelectorAll("[data-mode]")) {
    button.onclick = () => { stage.mode = button.dataset.mode; choose(button); redraw(); };
  }
  for (const button of document.querySelectorAll("[data-yaw]")) {
    button.onclick = () => {
      stage.view.turn = { yaw: Number(button.dataset.yaw), pitch: 0 };
      stage.view.zoom = 1;
      redraw();
    };
  }
  if ($("close")) $("close").onchange = () => { stage.close = $("close").checked; redraw(); };
  if ($("motion")) $("motion").onchange = () => { stage.motion = $("motion").checked; redraw(); };
  document.querySelectorAll("[data-contour]").forEach((box) => {
    box.onchange = () => {
      contours.lines[Number(box.dataset.contour)].shown = box.checked;
      contours.show(player.frame);
    };
  });
  document.querySelectorAll("[data-frame]").forEach((image) => {
    image.onclick = () => {
      player.seek(Number(image.dataset.frame));
      document.querySelector(".player").scrollIntoView({ behavior: "smooth", block: "center" });
    };
  });
  window.addEventListener("resize", () => { onframe(player.frame); if (maps) maps.show(); });
}

function choose(button) {
  for (const other of button.parentElement.querySelectorAll("[data-mode]")) {
    other.classList.toggle("chosen", other === button);
  }
}

function openHeads() {
  if (!told.heads.length) return;
  const faces = unpack(told.faces), colours = unpack(told.colours), ramp = new Ramp(told.ramp);
  const actors = told.heads.map((head) => new Actor(head, colours));
  try {
    stage = new Stage(document.querySelector(".stage"), told, actors, faces, ramp);
    stage.view.onturn = () => stage.show(player.frame);
    if (document.querySelector(".maps")) {
      maps = new ErrorMaps(document.querySelector(".maps"), told, actors, faces);
      maps.paint(ramp);
      $("scale").onchange = () => {
        ramp.end = Number($("scale").value);
        document.querySelectorAll(".ticks span").forEach((tick, k) => {
          tick.textContent = `${+(ramp.end * k / 4).toPrecision(3)}${k === 4 ? "+" : ""}`;
        });
        maps.paint(ramp);
        stage.show(player.frame);
      };
    }
  } catch (error) {
    stage = null;
    document.querySelectorAll(".no-webgl").forEach((note) => { note.hidden = false; });
  }
}

// Inflates what the page holds: its data, the arrays, and plotly, which is run as a script.
async function load() {
  const [data, arrays, plotly] = await Promise.all(["data", "arrays", "plotly"].map(inflated));
  const text = new TextDecoder();
  told = JSON.parse(text.decode(data));
  store = arrays;
  const script = document.createElement("script");
  script.textContent = text.decode(plotly);
  document.head.append(script);
}

async function start() {
  if (!window.DecompressionStream) {
    document.querySelector(".too-old").hidden = false;
    return;
  }
  await load();
  film = filmElement();
  if (film) contours = new Contours(document.querySelector(".film canvas"), film, told);
  openHeads();
  player = new Player(told, film, onframe);
  listen();
  await drawCharts((frame) => player.seek(frame));
  onframe(player.frame);
}

const ready = start();
// for tests: what the page is doing
window.report = {
  ready, get frame() { return player.frame; }, get playing() { return player.playing; },
  get film() { return film; }, get stage() { return stage; },
};
