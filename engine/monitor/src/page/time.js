// @ts-check
// Time: a lane for each component, with steps, calls, messages and faults, under the bands of the control states. Clicking moves the
// time that all views show.

import { el, panel, colour, fitted, text } from "./dom.js";
import { entryText } from "./log_list.js";

const COLOURS = ["ink", "faint", "line", "panel", "sunken", "accent", "accent-soft", "good", "bad", "note", "note-soft", "serie-3"];
const [LEFT, BAND, AXIS] = [190, 30, 24];
const SPANS = [5, 15, 30, 60, 120, 300, 600, 1800];

export class Time {
  constructor(app) {
    this.app = app;
    this.span = 30;
    this.canvas = el("canvas", { role: "img", tabindex: 0, "aria-label": "Time lines of the components; the log has the same content as text" });
    this.choice = el("select", { "aria-label": "Shown time", onchange: () => { this.span = Number(this.choice.value); app.redraw(); } }, SPANS.map((it) => el("option", { value: it, selected: it === 30 }, it < 60 ? `${it} s` : `${it / 60} min`)));
    this.hint = el("span", { class: "faint" }, "click: all views show this time · wheel: more or less");
    this.note = el("p", { class: "empty", hidden: true });
    const legend = el("span", { class: "legend" }, [["accent", "step"], ["good", "call"], ["serie-3", "message"], ["bad", "fault, loss"]].map(([name, words]) => el("span", {}, swatch(name), words)));
    this.root = el("div", { class: "grid time-view" }, panel("Time", "lanes-panel", [legend, el("span", { class: "grow" }), this.hint, this.choice, app.store.recording ? null : el("button", { type: "button", onclick: () => app.seek(null) }, "Live")], el("div", { class: "lanes" }, this.canvas), this.note));
    this.canvas.addEventListener("pointerdown", (event) => this.point(event));
    this.canvas.addEventListener("pointermove", (event) => { if (event.buttons) this.point(event); else this.hover(event); });
    this.canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const at = SPANS.indexOf(this.span) + Math.sign(event.deltaY);
      this.span = SPANS[Math.min(SPANS.length - 1, Math.max(0, at))];
      this.choice.value = String(this.span);
      app.redraw();
    }, { passive: false });
    this.recolour();
  }

  recolour() { this.colours = Object.fromEntries(COLOURS.map((name) => [name, colour(name)])); }

  streams() { return []; }

  /** The end of what is shown: now, or a little after a cursor that lies before it. */
  get end() {
    const { store } = this.app;
    const cursor = store.cursor;
    const end = cursor === null || cursor > store.t - this.span * 0.9 ? store.t : Math.min(store.t, cursor + this.span * 0.3);
    return Math.max(end, this.span);
  }

  toColumn(t) { return LEFT + (t - (this.end - this.span)) / this.span * (this.width - LEFT - 10); }

  timeAt(event) {
    const box = this.canvas.getBoundingClientRect();
    return this.end - this.span + (event.clientX - box.left - LEFT) / (this.width - LEFT - 10) * this.span;
  }

  point(event) {
    const t = this.timeAt(event);
    this.app.seek(t >= this.app.store.t ? null : Math.max(0, t));
  }

  /** Shows the nearest event under the pointer. */
  hover(event) {
    const t = this.timeAt(event), near = this.span / 100;
    const box = this.canvas.getBoundingClientRect();
    const lane = this.lanes?.[Math.floor((event.clientY - box.top - this.top) / this.lane)];
    const all = [...this.app.store.steps.map((it) => ({ ...it, kind: "step" })), ...this.app.store.log].filter((it) => it.component === lane && Math.abs(it.t - t) < near);
    all.sort((one, other) => Math.abs(one.t - t) - Math.abs(other.t - t));
    this.canvas.title = all.slice(0, 4).map((it) => `${it.t.toFixed(2)} s  ${it.kind}  ${entryText(it)}`).join("\n");
  }

  key(event) {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!by) return false;
    this.app.step(by);
    return true;
  }

  draw(now, texts) {
    // steps and entries of a recording are asked for as far as they are shown
    this.app.span = this.span * 1.3;
    if (!texts) return;
    const { store } = this.app;
    const { context, width, height } = fitted(this.canvas);
    Object.assign(this, { width, height });
    if (!width) return;
    const bands = store.system.specifications.filter((it) => it.diagram);
    this.top = AXIS + bands.length * BAND;
    this.lanes = store.system.components.map((it) => it.name);
    this.lane = Math.min(44, Math.max(20, (height - this.top) / this.lanes.length));
    /** Where the last label of each lane ends. */ this.labels = new Map();
    context.fillStyle = this.colours.panel;
    context.fillRect(0, 0, width, height);
    context.font = "12px sans-serif";
    context.textBaseline = "middle";
    this.axis(context);
    context.save();
    context.beginPath(); context.rect(LEFT, 0, width - LEFT, height); context.clip();
    bands.forEach((it, index) => this.band(context, it, AXIS + index * BAND));
    this.events(context);
    this.cursorLine(context);
    context.restore();
    this.names(context, bands);
    const first = Math.min(store.log[0]?.t ?? Infinity, store.steps[0]?.t ?? Infinity);
    this.note.hidden = Number.isFinite(first);
    text(this.note, "Nothing has happened yet.");
  }

  names(context, bands) {
    context.textAlign = "right";
    bands.forEach((it, index) => {
      context.fillStyle = this.colours.ink;
      context.font = "600 12px sans-serif";
      context.fillText(bands.length > 1 ? `${it.component} ${it.diagram.location}` : it.diagram.location, LEFT - 10, AXIS + index * BAND + BAND / 2, LEFT - 16);
    });
    context.font = "12px sans-serif";
    this.lanes.forEach((name, index) => {
      const y = this.top + index * this.lane;
      const component = this.app.store.components.find((it) => it.name === name);
      context.fillStyle = component && component.state !== "Running" ? this.colours.bad : this.colours.ink;
      context.fillText(name.length > 26 ? `…${name.slice(-25)}` : name, LEFT - 10, y + this.lane / 2, LEFT - 16);
    });
  }

  axis(context) {
    const step = [0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300].find((it) => it / this.span * (this.width - LEFT) > 60) ?? 600;
    context.textAlign = "center";
    const bottom = this.top + this.lanes.length * this.lane;
    for (let t = Math.max(0, Math.ceil((this.end - this.span) / step) * step); t <= this.end + 1e-9; t += step) {
      const column = Math.round(this.toColumn(t)) + 0.5;
      if (column < LEFT) continue;
      context.strokeStyle = this.colours.line;
      context.beginPath(); context.moveTo(column, AXIS - 4); context.lineTo(column, bottom); context.stroke();
      context.fillStyle = this.colours.faint;
      context.fillText(`${Number(t.toFixed(1))} s`, column, AXIS / 2);
    }
    this.lanes.forEach((_, index) => {
      const row = Math.round(this.top + (index + 1) * this.lane) + 0.5;
      context.strokeStyle = this.colours.line;
      context.beginPath(); context.moveTo(0, row); context.lineTo(this.width, row); context.stroke();
    });
  }

  /** The control state over time. */
  band(context, { component, diagram }, y) {
    const { store } = this.app;
    const changes = store.controlChanges(component, diagram.location);
    const present = store.states[component]?.locations[diagram.location]?.value ?? diagram.initial ?? "";
    const parts = changes.map((it, index) => ({ from: it.t, to: changes[index + 1]?.t ?? store.t, state: it.after }));
    // what was before the first known step is not known
    parts.unshift({ from: store.recording ? 0 : store.knownSince.get(component) ?? 0, to: changes[0]?.t ?? store.t, state: changes[0]?.before ?? present });
    for (const { from, to, state } of parts) {
      const [left, right] = [Math.max(LEFT, this.toColumn(from)), Math.min(this.width - 10, this.toColumn(to))];
      if (right <= left) continue;
      const index = diagram.states.indexOf(state);
      context.fillStyle = index % 2 ? this.colours["accent-soft"] : this.colours["note-soft"];
      context.fillRect(left, y + 3, right - left, BAND - 6);
      context.strokeStyle = this.colours.faint;
      context.strokeRect(left + 0.5, y + 3.5, right - left - 1, BAND - 7);
      context.font = "600 11px monospace";
      if (right - left > state.length * 7) {
        context.fillStyle = this.colours.ink; context.textAlign = "center";
        context.fillText(state, (left + right) / 2, y + BAND / 2 + 1);
      }
    }
  }

  events(context) {
    const { store } = this.app;
    const row = (component) => { const index = this.lanes.indexOf(component); return index < 0 ? null : this.top + index * this.lane + this.lane / 2; };
    const begin = this.end - this.span;
    const open = new Map();
    for (const it of store.log) {
      const y = row(it.component);
      if (y === null) continue;
      const operation = it.text.split(" ")[0];
      const key = `${it.component} ${operation}`;
      if (it.kind === "call") open.set(key, it.t);
      else if (it.kind === "reply") {
        const from = open.get(key);
        open.delete(key);
        if (it.t >= begin && from !== undefined) this.call(context, from, it.t, y, it.level !== "info", operation);
      } else if (it.t >= begin && it.t <= this.end) this.mark(context, it, y);
    }
    for (const [key, from] of open) this.call(context, from, store.t, row(key.split(" ")[0]), false, `${key.split(" ")[1]} …`);
    context.fillStyle = this.colours.accent;
    for (const it of store.steps) {
      const y = row(it.component);
      if (y === null || it.t < begin || it.t > this.end) continue;
      const large = it.step.updates.some((update) => update.before !== update.after);
      context.fillStyle = this.colours[it.step.updates.length ? "accent" : "faint"];
      context.fillRect(this.toColumn(it.t) - 1, y - (large ? 10 : 4), 2, large ? 20 : 8);
    }
  }

  call(context, from, to, y, failed, words) {
    const [left, right] = [this.toColumn(from), this.toColumn(to)];
    context.fillStyle = failed ? this.colours.bad : this.colours.good;
    context.fillRect(left, y - 3, Math.max(3, right - left), 6);
    context.font = "10px sans-serif"; context.textAlign = "left"; context.fillStyle = this.colours.faint;
    const begin = Math.max(left, LEFT) + 3;
    if (begin < (this.labels.get(y) ?? 0)) return;
    context.fillText(words, begin, y - 9);
    this.labels.set(y, begin + context.measureText(words).width + 6);
  }

  mark(context, it, y) {
    const column = this.toColumn(it.t);
    const bad = it.level === "error" || it.level === "warning";
    context.fillStyle = context.strokeStyle = bad ? this.colours.bad : it.kind === "message" ? this.colours["serie-3"] : this.colours.faint;
    context.lineWidth = 2;
    context.beginPath();
    if (bad) { context.moveTo(column - 5, y - 5); context.lineTo(column + 5, y + 5); context.moveTo(column + 5, y - 5); context.lineTo(column - 5, y + 5); context.stroke(); }
    else if (it.kind === "message") { context.arc(column, y, 3.5, 0, 2 * Math.PI); context.fill(); }
    else { context.moveTo(column, y - 5); context.lineTo(column + 5, y); context.lineTo(column, y + 5); context.lineTo(column - 5, y); context.closePath(); context.stroke(); }
    context.lineWidth = 1;
  }

  cursorLine(context) {
    const { store } = this.app;
    const column = Math.round(this.toColumn(store.cursor ?? store.t)) + 0.5;
    context.strokeStyle = store.cursor === null ? this.colours.good : this.colours.note;
    context.lineWidth = 2;
    context.beginPath(); context.moveTo(column, 0); context.lineTo(column, this.height); context.stroke();
    context.lineWidth = 1;
  }
}

function swatch(name) {
  const mark = el("i");
  mark.style.borderColor = `var(--${name})`;
  return mark;
}
