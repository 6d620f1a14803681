// @ts-check
// Time: a lane for each component, with steps, calls, messages and faults, under the bands of the control states. Clicking moves the
// time that all views show.

import { el, panel, colour, fitted, text } from "./dom.js";
import { MARGIN } from "./chart.js";
import { Values } from "./values.js";
import { entryText } from "./log_rows.js";
import { Folding } from "./folding.js";

const COLOURS = ["ink", "faint", "line", "panel", "sunken", "accent", "accent-soft", "good", "bad", "note", "note-soft", "serie-3"];
const [BAND, AXIS] = [30, 24];
/** Width of the names of lanes, px, and of those on a narrow page. */
const [NAMES, NARROW] = [190, 104];
/** Limit on the number of arrows between two lanes, beyond which they would hide the others. */
const ARROWS = 30;
/** Limit on the number of lanes, which a canvas has to hold. */
const LANES = 190;
/** Distance from which a press is a drag, px. */
const DRAG = 6;
const SPANS = [5, 15, 30, 60, 120, 300, 600, 1800];

export class Time {
  constructor(app) {
    this.app = app;
    this.span = 30;
    this.canvas = el("canvas", { role: "img", tabindex: 0, "aria-label": "Time lines of the components; the log has the same content as text" });
    this.choice = el("select", { "aria-label": "Shown time", onchange: () => { this.span = Number(this.choice.value); app.range = null; app.redraw(); } }, SPANS.map((it) => el("option", { value: it, selected: it === 30 }, it < 60 ? `${it} s` : `${it / 60} min`)));
    this.idle = el("input", { type: "checkbox", id: "fold", onchange: () => app.redraw() });
    this.folding = new Folding(0, 1);
    this.hint = el("span", { class: "faint" }, "click: shows this time in all views · drag: range · Shift + wheel: zoom");
    this.values = new Values(app, () => this.left);
    this.left = NAMES;
    /** The times between which the pointer is dragged. @type {[number, number] | null} */ this.drag = null;
    this.note = el("p", { class: "empty", hidden: true });
    const legend = el("span", { class: "legend" }, [["accent", "step"], ["good", "call"], ["serie-3", "message"], ["bad", "fault, loss"]].map(([name, words]) => el("span", {}, swatch(name), words)));
    this.root = el("div", { class: "grid time-view" }, panel("Time", "lanes-panel", [legend, el("span", { class: "grow" }), this.hint, el("label", { title: "Long stretches without a change of a control state, a message or a fault take little room" }, this.idle, " fold idle time"), this.values.select, this.choice, app.store.recording ? null : el("button", { type: "button", onclick: () => app.seek(null) }, "Live")], el("div", { class: "body" }, this.place = el("div", { class: "lanes" }, this.canvas)), this.note, this.values.root));
    this.canvas.addEventListener("pointerdown", (event) => { this.canvas.setPointerCapture(event.pointerId); const t = this.timeAt(event); this.drag = [t, t]; this.from = event.clientX; });
    this.canvas.addEventListener("pointermove", (event) => { if (this.drag) { this.drag[1] = this.timeAt(event); app.redraw(); } else this.hover(event); });
    this.canvas.addEventListener("pointerup", (event) => this.released(event));
    this.canvas.addEventListener("pointercancel", () => { this.drag = null; });
    this.canvas.addEventListener("wheel", (event) => {
      // without a key, the wheel scrolls
      if (!event.ctrlKey && !event.shiftKey) return;
      event.preventDefault();
      const at = SPANS.indexOf(this.span) + Math.sign(event.deltaY || event.deltaX);
      this.span = SPANS[Math.min(SPANS.length - 1, Math.max(0, at))];
      this.choice.value = String(this.span);
      if (app.range) app.zoom(null);
      app.redraw();
    }, { passive: false });
    this.recolour();
  }

  recolour() { this.colours = Object.fromEntries(COLOURS.map((name) => [name, colour(name)])); }

  streams() { return []; }

  toColumn(t) { return this.left + this.folding.to(t) / this.folding.length * (this.width - this.left - MARGIN); }

  timeAt(event) {
    const box = this.canvas.getBoundingClientRect();
    return this.folding.from((event.clientX - box.left - this.left) / (this.width - this.left - MARGIN) * this.folding.length);
  }

  /** A click moves the shown time, a drag selects a range. */
  released(event) {
    const drag = this.drag;
    this.drag = null;
    if (!drag) return;
    const isDrag = Math.abs(event.clientX - this.from) > DRAG;
    const [from, to] = [Math.min(...drag), Math.min(this.app.store.t, Math.max(...drag))];
    if (isDrag && to > from) return this.app.zoom([from, to]);
    const t = this.timeAt(event);
    this.app.seek(t >= this.app.store.t ? null : Math.max(0, t));
  }

  /** Shows the nearest event under the pointer. */
  hover(event) {
    const t = this.timeAt(event), near = (this.end - this.begin) / 100;
    const box = this.canvas.getBoundingClientRect();
    const lane = Math.floor((event.clientY - box.top - this.top) / this.lane);
    const all = [...this.app.store.steps.map((it) => ({ ...it, kind: "step" })), ...this.app.store.log].filter((it) => this.laneOf(it.component) === lane && Math.abs(it.t - t) < near);
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
    [this.begin, this.end] = this.app.shown(this.span);
    // steps and entries of a recording are asked for as far as they are shown
    this.app.span = Math.max(this.span, this.end - this.begin) * 1.3;
    if (!texts) return;
    const { store } = this.app;
    const bands = store.specifications.filter((it) => it.diagram);
    this.top = AXIS + bands.length * BAND;
    const names = this.names();
    this.lanes = names.slice(0, LANES);
    this.place.style.minHeight = `${this.top + this.lanes.length * 20}px`;
    const { context, width, height } = fitted(this.canvas);
    Object.assign(this, { width, height, left: width < 620 ? NARROW : NAMES });
    if (!width) return;
    this.lane = Math.min(44, Math.max(20, (height - this.top) / this.lanes.length));
    this.folding = new Folding(this.begin, this.end);
    if (this.idle.checked) this.folding.fold(this.eventTimes());
    this.values.draw(this.begin, this.end, this.folding);
    /** Where the last label of each lane ends. */ this.labels = new Map();
    context.fillStyle = this.colours.panel;
    context.fillRect(0, 0, width, height);
    context.font = "12px sans-serif";
    context.textBaseline = "middle";
    this.axis(context);
    context.save();
    context.beginPath(); context.rect(this.left, 0, width - this.left, height); context.clip();
    bands.forEach((it, index) => this.band(context, it, AXIS + index * BAND));
    this.events(context);
    this.cursorLine(context);
    context.restore();
    this.label(context, bands);
    const first = Math.min(store.log[0]?.t ?? Infinity, store.steps[0]?.t ?? Infinity);
    this.note.hidden = Number.isFinite(first) && names.length <= LANES;
    text(this.note, names.length > LANES ? `The first ${LANES} of ${names.length} components have lanes; the log has the events of all.` : "Nothing has happened yet.");
  }

  /** When something happened: changes of control states, of any location without one, and what the log has but calls, which may be
   * made in each cycle. @returns {number[]} */
  eventTimes() {
    const { store } = this.app;
    const changes = store.specifications.flatMap(({ component, diagram }) => (diagram ? store.controlChanges(component, diagram.location) : store.stepsOf(component).filter((it) => it.step.updates.some((update) => update.before !== update.after))));
    const entries = store.log.filter((it) => it.kind !== "call" && it.kind !== "reply");
    return [...changes, ...entries].map((it) => it.t).filter((t) => t >= this.begin && t <= this.end).sort((one, other) => one - other);
  }

  /** Components with a lane: those that run now, and those that the description names. */
  names() {
    const { store } = this.app;
    const described = store.system.components.map((it) => it.name);
    const present = store.components.map((it) => it.name);
    const added = present.filter((name) => !described.includes(name));
    return [...described.filter((name) => !present.length || present.includes(name) || store.recording), ...added];
  }

  /** Number of the lane of a component, or of the component of a port; -1 without one. @param {string} name */
  laneOf(name) {
    const found = this.lanes.indexOf(name);
    return found >= 0 ? found : this.lanes.indexOf(name.slice(0, name.lastIndexOf(".")));
  }

  label(context, bands) {
    const LEFT = this.left, room = Math.floor((LEFT - 16) / 6.6);
    const shortened = (name) => (name.length > room ? `…${name.slice(1 - room)}` : name);
    context.textAlign = "right";
    bands.forEach((it, index) => {
      context.fillStyle = this.colours.ink;
      context.font = "600 12px sans-serif";
      context.fillText(shortened(bands.length > 1 ? `${it.component} ${it.diagram.location}` : it.diagram.location), LEFT - 10, AXIS + index * BAND + BAND / 2, LEFT - 16);
    });
    context.font = "12px sans-serif";
    this.lanes.forEach((name, index) => {
      const y = this.top + index * this.lane;
      const component = this.app.store.components.find((it) => it.name === name);
      context.fillStyle = component?.state && component.state !== "Running" ? this.colours.bad : this.colours.ink;
      context.fillText(shortened(name), LEFT - 10, y + this.lane / 2, LEFT - 16);
    });
  }

  axis(context) {
    const step = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300].find((it) => it / (this.end - this.begin) * (this.width - this.left) > 60) ?? 600;
    context.textAlign = "center";
    const bottom = this.top + this.lanes.length * this.lane;
    this.folds(context, bottom);
    for (let t = Math.max(0, Math.ceil(this.begin / step) * step); t <= this.end + 1e-9; t += step) {
      const column = Math.round(this.toColumn(t)) + 0.5;
      if (column < this.left || this.folding.hides(t)) continue;
      context.strokeStyle = this.colours.line;
      context.beginPath(); context.moveTo(column, AXIS - 4); context.lineTo(column, bottom); context.stroke();
      context.fillStyle = this.colours.faint;
      context.fillText(`${Number(t.toFixed(2))} s`, column, AXIS / 2);
    }
    this.lanes.forEach((_, index) => {
      const row = Math.round(this.top + (index + 1) * this.lane) + 0.5;
      context.strokeStyle = this.colours.line;
      context.beginPath(); context.moveTo(0, row); context.lineTo(this.width, row); context.stroke();
    });
  }

  /** Folded stretches, with their duration. */
  folds(context, bottom) {
    for (const { from, to } of this.folding.folds) {
      const [left, right] = [this.toColumn(from), this.toColumn(to)];
      context.fillStyle = this.colours.sunken;
      context.fillRect(left, AXIS - 4, right - left, bottom - AXIS + 4);
      context.fillStyle = this.colours.faint;
      context.textAlign = "center";
      context.fillText(`⋯${Number((to - from).toFixed(to - from < 10 ? 1 : 0))} s⋯`, (left + right) / 2, AXIS / 2);
    }
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
      const [left, right] = [Math.max(this.left, this.toColumn(from)), Math.min(this.width - MARGIN, this.toColumn(to))];
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
    const { begin, end } = this;
    const row = (name) => { const index = this.laneOf(name); return index < 0 ? null : this.top + index * this.lane + this.lane / 2; };
    const open = new Map(), oneway = new Set();
    const links = new Links(store);
    for (const it of store.steps) {
      const y = row(it.component);
      if (y === null || it.t < begin || it.t > end) continue;
      const large = it.step.updates.some((update) => update.before !== update.after);
      context.fillStyle = this.colours[it.step.updates.length ? "accent" : "faint"];
      context.fillRect(this.toColumn(it.t) - 1, y - (large ? 10 : 4), 2, large ? 20 : 8);
    }
    /** Arrows between lanes: time, rows, colour, whether it is an answer. @type {[number, number, number, string, boolean][]} */
    const arrows = [];
    for (const it of store.log) {
      const y = row(it.component);
      if (y === null || it.t > end) continue;
      const operation = it.text.split(" ")[0];
      const key = `${it.component} ${operation}`;
      const provider = it.kind === "call" || it.kind === "reply" ? row(links.provider(it.component, operation)) : null;
      if (it.kind === "call") {
        // a call that nothing answers before the next one is one-way
        if (open.has(key)) {
          if (open.get(key) >= begin) this.call(context, open.get(key), open.get(key), y, false, oneway.has(key) ? "" : operation);
          oneway.add(key);
        }
        open.set(key, it.t);
        if (provider !== null && it.t >= begin) arrows.push([it.t, y, provider, "good", false]);
      } else if (it.kind === "reply") {
        const from = open.get(key);
        open.delete(key);
        if (it.t >= begin && from !== undefined) this.call(context, from, it.t, y, it.level !== "info", operation);
        if (it.t >= begin && provider !== null) arrows.push([it.t, provider, y, it.level === "info" ? "good" : "bad", true]);
      } else if (it.t >= begin) {
        this.mark(context, it, y);
        if (it.kind === "message") for (const reader of links.readers(operation)) arrows.push([it.t, y, row(reader) ?? y, "serie-3", false]);
      }
    }
    for (const [key, from] of open) {
      const [name, operation] = key.split(" ");
      if (oneway.has(key)) this.call(context, from, from, row(name), false, "");
      else this.call(context, from, Math.min(store.t, end), row(name), false, `${operation} …`);
    }
    this.arrows(context, arrows);
  }

  /** Messages and calls from lane to lane. Those between two lanes that would hide the others are left out. */
  arrows(context, arrows) {
    const counts = new Map();
    const pair = ([, from, to]) => `${Math.min(from, to)} ${Math.max(from, to)}`;
    for (const it of arrows) counts.set(pair(it), (counts.get(pair(it)) ?? 0) + 1);
    const drawn = arrows.filter((it) => it[1] !== it[2] && counts.get(pair(it)) <= ARROWS);
    for (const [t, from, to, shade, isAnswer] of drawn) {
      const column = Math.round(this.toColumn(t)) + 0.5, way = Math.sign(to - from);
      context.strokeStyle = context.fillStyle = this.colours[shade];
      context.globalAlpha = 0.75;
      context.setLineDash(isAnswer ? [3, 3] : []);
      context.beginPath(); context.moveTo(column, from); context.lineTo(column, to - way * 5); context.stroke();
      context.setLineDash([]);
      context.beginPath(); context.moveTo(column - 3.5, to - way * 6); context.lineTo(column + 3.5, to - way * 6); context.lineTo(column, to); context.closePath(); context.fill();
      context.globalAlpha = 1;
    }
  }

  call(context, from, to, y, failed, words) {
    const [left, right] = [this.toColumn(from), this.toColumn(to)];
    context.fillStyle = failed ? this.colours.bad : this.colours.good;
    context.fillRect(left, y - 3, Math.max(3, right - left), 6);
    context.font = "10px sans-serif"; context.textAlign = "left"; context.fillStyle = this.colours.faint;
    const begin = Math.max(left, this.left) + 3;
    if (!words || begin < (this.labels.get(y) ?? 0)) return;
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
    if (this.drag) {
      const [from, to] = this.drag.map((t) => this.toColumn(t));
      context.fillStyle = this.colours.note; context.globalAlpha = 0.18;
      context.fillRect(Math.min(from, to), 0, Math.abs(to - from), this.height);
      context.globalAlpha = 1;
    }
    const column = Math.round(this.toColumn(store.cursor ?? store.t)) + 0.5;
    context.strokeStyle = store.cursor === null ? this.colours.good : this.colours.note;
    context.lineWidth = 2;
    context.beginPath(); context.moveTo(column, 0); context.lineTo(column, this.height); context.stroke();
    context.lineWidth = 1;
  }
}

/** Who receives what: readers of topics, and providers of operations. */
class Links {
  /** @param {any} store */
  constructor(store) {
    /** @type {Map<string, string[]>} */
    this.subscribers = new Map((store.presence?.topics ?? store.system.topics ?? []).map((it) => [it.name, it.subscribers]));
    /** @type {Map<string, string>} */
    this.services = new Map((store.presence?.joined ?? []).map((it) => [it.from, it.to]));
  }

  /** The inputs that read a topic. @param {string} topic @returns {string[]} */
  readers(topic) { return this.subscribers.get(topic) ?? []; }

  /** The service behind an operation of a component, `reference.operation`. @param {string} component @param {string} operation */
  provider(component, operation) { return this.services.get(`${component}.${operation.slice(0, operation.lastIndexOf("."))}`) ?? ""; }
}

function swatch(name) {
  const mark = el("i");
  mark.style.borderColor = `var(--${name})`;
  return mark;
}
