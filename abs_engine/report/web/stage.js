"use strict";
// What the canvases show: heads side by side or over each other, and errors painted on faces.

const STILL = [1, 0, 0, 0, 1, 0, 0, 0, 1];
const NO_ERROR_KNOWN = [200, 198, 194];
const VIEWS = [-0.7, 0, 0.7];  // radians
const MAP_HEIGHT = 270;  // px

// One system's or the true head.
class Actor {
  constructor(told, colours) {
    this.name = told.name;
    this.colour = told.colour;
    this.truth = told.truth;
    this.motion = new Motion(told.motion);
    this.turns = told.rotations && unpack(told.rotations);
    this.moves = told.translations && unpack(told.translations);
    this.map = told.map && unpack(told.map);
    this.clay = colours;
    this.painted = new Uint8Array(colours.length);
  }

  // Rotation (by rows) and shift of a frame, with y up and z to the viewer; null if not known.
  pose(frame, origin) {
    if (!this.turns || !this.moves || !isFinite(this.turns[3 * frame])) return null;
    const r = rotationOf(...this.turns.subarray(3 * frame, 3 * frame + 3));
    const t = this.moves.subarray(3 * frame, 3 * frame + 3);
    for (let k = 3; k < 9; k++) r[k] = -r[k];
    return [r, [t[0] - origin[0], origin[1] - t[1], origin[2] - t[2]]];
  }
}

// Where a head is between its top and its bottom, and how far it reaches, mm, with some air.
function wholeOf(points) {
  let low = Infinity, high = -Infinity;
  for (let k = 1; k < points.length; k += 3) {
    low = Math.min(low, points[k]);
    high = Math.max(high, points[k]);
  }
  return { middle: (low + high) / 2, reach: 0.54 * (high - low) };
}

// Colours of errors in mm; grey where there is none.
class Ramp {
  constructor(told) {
    this.colours = unpack(told.colours);
    this.end = told.end;
  }

  paint(out, vertex, error) {
    const last = this.colours.length / 3 - 1;
    const step = 3 * Math.min(last, Math.round(last * error / this.end));
    for (let k = 0; k < 3; k++) {
      out[3 * vertex + k] = isFinite(error) ? this.colours[step + k] : NO_ERROR_KNOWN[k];
    }
  }
}

class Stage {
  constructor(root, told, actors, faces, ramp) {
    this.root = root;
    this.told = told;
    this.actors = actors;
    this.ramp = ramp;
    this.view = new HeadView(root.querySelector("canvas"), faces, unpack(told.weld));
    this.whole = wholeOf(actors[0].motion.mean);
    this.mode = "beside";
    this.close = false;
    this.motion = false;
    this.tags = [];
  }

  get canvas() { return this.view.canvas; }

  // The boxes that are drawn: which heads each shows.
  boxes() {
    const truth = this.actors.filter((a) => a.truth), rest = this.actors.filter((a) => !a.truth);
    if (this.mode === "over" && truth.length) return rest.map((a) => [truth[0], a]);
    if (this.mode === "error" && truth.length) return rest.map((a) => [a]);
    return this.actors.map((a) => [a]);
  }

  show(frame) {
    const boxes = this.boxes();
    const columns = boxes.length < 4 ? boxes.length : boxes.length < 5 ? 2 : 3;
    const lines = Math.ceil(boxes.length / columns);
    this.canvas.style.height = `${lines > 1 ? 300 * lines : columns > 2 ? 320 : 400}px`;
    this.view.begin();
    this.label(boxes, columns, lines, frame);
    boxes.forEach((heads, k) => {
      const column = k % columns, line = Math.floor(k / columns);
      const box = [column / columns, 1 - (line + 1) / lines, 1 / columns, 1 / lines];
      heads.forEach((head, j) => this.head(box, head, frame, j > 0));
    });
  }

  head(box, actor, frame, wire) {
    const positions = actor.motion.at(frame);
    if (!positions) return;
    const { target, origin } = this.aim();
    const pose = this.motion ? actor.pose(frame, origin) : null;
    if (this.motion && !pose) return;
    let colours = actor.clay;
    if (this.mode === "error" && !actor.truth) colours = this.errors(actor, positions, frame);
    const ink = wire ? [...inkOf(actor.colour), 0.4] : null;
    this.view.draw(box, {
      positions, colours, model: pose ? pose[0] : STILL, moved: pose ? pose[1] : [0, 0, 0],
      target, wire: ink, lit: colours === actor.clay ? 1 : 0.55,
      reach: this.close ? 36 : this.whole.reach * (this.motion ? 1.14 : 1),
    });
  }

  // What the eye looks at: the mouth, or the middle of the face.
  aim() {
    const focus = this.told.focus;
    const place = this.close ? focus : [0, this.whole.middle, focus[2] - 40];
    if (!this.motion) return { target: place, origin: [0, 0, 0] };
    const first = this.actors.find((a) => a.moves && isFinite(a.moves[0]));
    if (!first) return { target: place, origin: [0, 0, 0] };
    const origin = first.moves.subarray(0, 3);
    const [r] = first.pose(0, origin);
    const target = [0, 1, 2].map((k) => r[3 * k] * place[0] + r[3 * k + 1] * place[1] + r[3 * k + 2] * place[2]);
    return { target, origin };
  }

  errors(actor, positions, frame) {
    const truth = this.actors.find((a) => a.truth), true_ = truth && truth.motion.at(frame);
    if (!true_) return actor.clay;
    for (let v = 0; v < positions.length / 3; v++) {
      const x = positions[3 * v] - true_[3 * v], y = positions[3 * v + 1] - true_[3 * v + 1];
      this.ramp.paint(actor.painted, v, Math.hypot(x, y, positions[3 * v + 2] - true_[3 * v + 2]));
    }
    return actor.painted;
  }

  label(boxes, columns, lines, frame) {
    this.tags.forEach((tag) => tag.remove());
    this.tags = boxes.map((heads, k) => {
      const tag = document.createElement("div"), last = heads[heads.length - 1];
      tag.className = "tag";
      tag.textContent = heads.map((a) => a.name).join(" + ");
      if (!last.motion.at(frame)) tag.textContent += ": lost";
      tag.style.color = last.colour;
      tag.style.left = `${100 * (k % columns) / columns}%`;
      tag.style.top = `${100 * Math.floor(k / columns) / lines}%`;
      this.root.append(tag);
      return tag;
    });
  }
}

// Mean errors on the true head at rest: a line for each system, from three sides.
class ErrorMaps {
  constructor(root, told, actors, faces) {
    this.root = root;
    this.told = told;
    this.actors = actors.filter((a) => a.map);
    this.rest = (actors.find((a) => a.truth) || actors[0]).motion.mean;
    this.view = new HeadView(root.querySelector("canvas"), faces, unpack(told.weld));
    this.whole = wholeOf(this.rest);
    this.view.canvas.style.height = `${MAP_HEIGHT * this.actors.length}px`;
    this.view.onturn = () => this.show();
    for (const [k, actor] of this.actors.entries()) {
      const tag = document.createElement("div");
      tag.className = "tag";
      tag.textContent = actor.name;
      tag.style.color = actor.colour;
      tag.style.top = `${MAP_HEIGHT * k}px`;
      root.append(tag);
    }
  }

  paint(ramp) {
    for (const actor of this.actors) {
      actor.mapColours = new Uint8Array(3 * this.told.vertices);
      for (let v = 0; v < this.told.vertices; v++) ramp.paint(actor.mapColours, v, actor.map[v]);
    }
    this.show();
  }

  show() {
    this.view.begin();
    const lines = this.actors.length, focus = this.told.focus;
    const target = [0, this.whole.middle, focus[2] - 55];
    this.actors.forEach((actor, line) => VIEWS.forEach((yaw, column) => {
      const box = [column / 3, 1 - (line + 1) / lines, 1 / 3, 1 / lines];
      this.view.draw(box, {
        positions: this.rest, colours: actor.mapColours, model: STILL, moved: [0, 0, 0],
        target, reach: this.whole.reach, yaw, lit: 0.55,
      });
    }));
  }
}

function inkOf(colour) {
  return [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16) / 255);
}
