// @ts-check
// The time of a recording: a line over the whole run with control states, warnings and the shown time, and playing.

import { el, text, fitted, colour } from "./dom.js";

const SPEEDS = [0.25, 0.5, 1, 2, 5, 10];
/** Interval between moments while the recording plays, ms. */
const EVERY = 100;
/** Time that a key moves, s. */
const JUMP = 5;

export class Playback {
  /** @param {any} app */
  constructor(app) {
    this.app = app;
    this.playing = false;
    this.speed = 1;
    this.waits = false; this.again = false; this.last = 0; this.asked = 0;
    this.button = el("button", { type: "button", id: "play", title: "Plays the recording (Space)", onclick: () => this.play(!this.playing) }, "▶ Play");
    this.choice = el("select", { "aria-label": "Speed of playing", onchange: () => { this.speed = Number(this.choice.value); } }, SPEEDS.map((it) => el("option", { value: it, selected: it === 1 }, `${it}×`)));
    this.range = el("input", { type: "range", id: "moment", min: 0, step: "any", "aria-label": "Time of the recording, s", oninput: () => { this.play(false); app.seek(Number(this.range.value)); } });
    this.canvas = el("canvas", { role: "img", "aria-label": "Control states and warnings of the whole run" });
    this.shown = el("span", { class: "mono", id: "shown-time" });
    this.root = el("div", { class: "playback" }, this.button, el("button", { type: "button", title: "Previous step ([)", onclick: () => app.step(-1) }, "◀ step"), el("button", { type: "button", title: "Next step (])", onclick: () => app.step(1) }, "step ▶"),
      this.marks = el("button", { type: "button", id: "next-mark", title: "Next warning or error", onclick: () => this.mark() }, "⚠ next"),
      el("div", { class: "line-of-time" }, this.canvas, this.range), this.shown, this.choice);
    app.link.onmoment = () => this.received();
    app.link.onlost = () => this.lost();
  }

  /** Starts or stops playing; at the end of the run, it begins again. @param {boolean} playing */
  play(playing) {
    const { store } = this.app;
    this.playing = playing;
    this.last = performance.now();
    if (playing && store.cursor >= store.recording.end - 1e-6) this.app.seek(0);
    text(this.button, playing ? "❚❚ Pause" : "▶ Play");
  }

  /** Shows the next warning or error; after the last one, the first one. */
  mark() {
    const { store } = this.app;
    const times = store.recording.marks.map(([t]) => t).sort((one, other) => one - other);
    this.app.seek(times.find((t) => t > store.cursor + 1e-6) ?? times[0]);
  }

  /** Asks for the shown moment. One question is under way at a time; the next one is about the newest moment. */
  ask() {
    const { store, link } = this.app;
    if (this.waits) { this.again = true; return; }
    const t = store.cursor;
    const [from, to] = store.valid, span = this.app.span ?? 30;
    const window = !(t >= from && t <= to) || span > this.asked;
    const has = Object.fromEntries([...store.samples].map(([name, sample]) => [name, sample.n]));
    this.waits = link.send({ type: "seek", t, span, window, has, log: store.logFilter });
    if (this.waits && window) this.asked = span;
    this.again = false;
  }

  received() {
    this.waits = false;
    this.app.redraw();
    if (this.again) this.ask();
  }

  /** The connection was lost: nothing that was asked will be answered. */
  lost() { this.waits = this.again = false; }

  key(event) {
    const by = { ArrowLeft: -JUMP, ArrowRight: JUMP }[event.key];
    const { store } = this.app;
    // a focused line of time moves by itself
    if (event.target === this.range && event.key !== " ") return false;
    if (event.key === " ") this.play(!this.playing);
    else if (event.key === "Home") this.app.seek(0);
    else if (event.key === "End") this.app.seek(null);
    else if (by) this.app.seek(store.cursor + by);
    else return false;
    return true;
  }

  draw(now, texts) {
    const { app } = this, { store } = app, { end } = store.recording;
    // a view that shows more time needs more steps and entries
    if ((app.span ?? 30) > this.asked && !this.waits) this.ask();
    if (this.playing && now - this.last >= EVERY) {
      const t = store.cursor + (now - this.last) / 1000 * this.speed;
      this.last = now;
      app.seek(t);
      if (t >= end) this.play(false);
    }
    if (!texts) return;
    this.marks.disabled = !store.recording.marks.length;
    this.range.max = String(end);
    this.range.value = String(store.cursor);
    text(this.shown, `${store.cursor.toFixed(2)} / ${end.toFixed(1)} s`);
    this.line(end);
  }

  /** Control states as bands, warnings and errors as ticks. */
  line(end) {
    const { store } = this.app;
    const { context, width, height } = fitted(this.canvas);
    if (!width || !end) return;
    context.clearRect(0, 0, width, height);
    const x = (t) => t / end * width;
    const diagrams = store.specifications.filter((it) => it.diagram);
    const band = height / Math.max(1, diagrams.length);
    diagrams.forEach(({ component, diagram }, row) => {
      const changes = store.controlChanges(component, diagram.location);
      const parts = [{ t: 0, after: changes[0]?.before ?? diagram.initial }, ...changes];
      parts.forEach((it, index) => {
        const to = parts[index + 1]?.t ?? end;
        context.fillStyle = colour(diagram.states.indexOf(it.after) % 2 ? "accent-soft" : "note-soft");
        context.fillRect(x(it.t), row * band, Math.max(1, x(to) - x(it.t)), band - 1);
      });
    });
    for (const [t, level] of store.recording.marks) {
      context.fillStyle = colour(level === "error" ? "bad" : "note");
      context.fillRect(x(t) - 1, 0, 2, height);
    }
  }
}
