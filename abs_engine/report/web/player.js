"use strict";
// One clock for the video, the heads and the lines on the charts.

class Player {
  constructor(told, film, onframe) {
    this.rate = told.rate;
    this.length = told.played;
    this.times = told.times.slice(0, told.played).map((one) => one - told.times[0]);
    this.film = film;
    this.onframe = onframe;
    this.frame = 0;
    this.playing = false;
    this.speed = 1;
    this.began = null;
    if (film) {
      film.loop = true;
      film.addEventListener("play", () => this.follow());
      if (film.requestVideoFrameCallback) {
        const seen = (_now, facts) => {
          // a seek that is not yet done must not take the slider back
          if (!film.seeking) this.show(frameAt(told.times[0] + facts.mediaTime));
          film.requestVideoFrameCallback(seen);
        };
        film.requestVideoFrameCallback(seen);
      }
    }
  }

  show(frame) {
    this.frame = Math.max(0, Math.min(this.length - 1, frame));
    this.onframe(this.frame);
  }

  // The last frame that has begun at a time, and when a frame ends, s since the first.
  begun(time) {
    const next = this.times.findIndex((one) => one > time + 1e-4);
    return next < 0 ? this.length - 1 : next - 1;
  }

  end(frame) {
    return frame + 1 < this.length ? this.times[frame + 1] : this.times[frame] + 1 / this.rate;
  }

  seek(frame) {
    if (frame >= this.length) return;
    this.pause();
    const from = this.times[frame], within = Math.min(this.end(frame) - from, 1 / this.rate) / 2;
    if (this.film) this.film.currentTime = from + within;
    this.show(frame);
  }

  play() {
    this.playing = true;
    this.began = null;
    if (this.film) {
      this.film.playbackRate = this.speed;
      this.film.play().catch(() => this.pause());
    } else {
      requestAnimationFrame((now) => this.tick(now));
    }
    this.onframe(this.frame);
  }

  pause() {
    this.playing = false;
    if (this.film) this.film.pause();
    this.onframe(this.frame);
  }

  setSpeed(speed) {
    this.speed = speed;
    this.began = null;
    if (this.film) this.film.playbackRate = speed;
  }

  // Where the browser does not tell which picture it shows.
  follow() {
    if (this.film.requestVideoFrameCallback || !this.playing) return;
    this.show(this.begun(this.film.currentTime));
    requestAnimationFrame(() => this.follow());
  }

  // Without a video.
  tick(now) {
    if (!this.playing) return;
    if (this.began === null) this.began = now - 1000 * this.times[this.frame] / this.speed;
    const time = (now - this.began) * this.speed / 1000, ended = time >= this.end(this.length - 1);
    if (ended) this.began = null;
    const next = ended ? 0 : this.begun(time);
    if (next !== this.frame) this.show(next);
    requestAnimationFrame((later) => this.tick(later));
  }
}

// Contours of the lips on the picture of the video. The picture is drawn with them, since the
// browser may show the element's own a little earlier or later.
class Contours {
  constructor(canvas, film, told) {
    this.canvas = canvas;
    this.film = film;
    this.size = told.film.size;
    this.lines = told.contours.map((one) => ({
      ...one, shown: true, loops: one.loops.map((l) => ({ points: unpack(l), count: l.shape[1] })),
    }));
  }

  show(frame) {
    const fine = window.devicePixelRatio || 1, canvas = this.canvas;
    canvas.width = Math.max(1, canvas.clientWidth * fine);
    canvas.height = Math.max(1, canvas.clientHeight * fine);
    const context = canvas.getContext("2d"), scale = canvas.width / this.size[0];
    if (this.film.readyState >= 2 && !this.film.seeking) {
      context.drawImage(this.film, 0, 0, canvas.width, canvas.height);
    }
    for (const line of this.lines) {
      if (!line.shown) continue;
      for (const { points, count } of line.loops) {
        const from = 2 * count * frame;
        if (!isFinite(points[from])) continue;
        context.beginPath();
        for (let k = 0; k < count; k++) {
          // centres of pixels are at integers
          const x = (points[from + 2 * k] + 0.5) * scale, y = (points[from + 2 * k + 1] + 0.5) * scale;
          if (k) context.lineTo(x, y); else context.moveTo(x, y);
        }
        context.closePath();
        context.strokeStyle = line.stroke.colour;
        context.lineWidth = line.stroke.width * fine;
        context.setLineDash(line.stroke.dash.map((part) => 0.7 * part * fine));
        context.stroke();
      }
    }
  }
}
