// @ts-check
// The list of log entries and steps, newest first.

import { el, text, list, className } from "./dom.js";
import { matches } from "./state_table.js";

const LEVELS = ["info", "notice", "warning", "error"];
const WORDS = { info: "all levels", notice: "notices and above", warning: "warnings and errors", error: "errors" };
/** Kinds of entries that repeat as long as a system works. */
const ROUTINE = new Set(["step", "call", "reply", "message"]);

let nextKey = 0;

export class LogList {
  /** @param {any} app @param {{ limit: number, filtered: boolean, levels?: boolean }} options */
  constructor(app, options) {
    Object.assign(this, { app, ...options });
    this.filter = el("input", { type: "search", placeholder: "filter: call !reply  (/)", "aria-label": "Filter entries", oninput: () => app.redraw() });
    this.level = el("select", { "aria-label": "Least level", onchange: () => app.redraw() }, LEVELS.map((it) => el("option", { value: it }, WORDS[it])));
    this.fold = el("input", { type: "checkbox", checked: true, onchange: () => app.redraw() });
    this.count = el("span", { class: "faint" });
    this.tools = [el("span", { class: "grow" }), this.count, el("label", { title: "Counts entries of the same kind between others" }, this.fold, " fold"), options.levels ? this.level : null, el("span", {}, this.filter)];
    this.root = el("div", { class: "body log", role: "log", "aria-live": "off" });
    this.changes = "";
  }

  /** All entries, oldest first: log and steps by time. */
  entries() {
    const { store } = this.app;
    for (const it of store.steps) { it.kind = "step"; it.level = "info"; it.key ??= `s${it.component}${it.step.number}`; }
    const log = store.found?.entries ?? store.log;
    for (const it of log) it.key ??= `l${nextKey++}`;
    // a recording has all steps, also those that a running system does not report
    const steps = store.steps.filter((it) => it.step.updates.length || !store.recording);
    return [...steps, ...log].sort((one, other) => one.t - other.t);
  }

  draw() {
    const { store } = this.app;
    const words = this.filter.value.trim().split(/\s+/).filter(Boolean);
    // the server sends only what passes, and what it has kept of it
    store.filter(words, this.level.value);
    const changes = [store.changes.log, store.changes.steps, store.cursor, this.filter.value, this.level.value, this.fold.checked].join();
    if (changes === this.changes) return;
    this.changes = changes;
    const least = LEVELS.indexOf(this.level.value);
    const shown = this.entries().filter((it) => LEVELS.indexOf(it.level) >= least && matches(`${it.kind} ${it.component} ${entryText(it)}`, words));
    const cut = store.cursor === null ? shown : shown.filter((it) => it.t <= store.cursor + 1e-9 || shown.length < this.limit);
    const newest = (this.fold.checked ? folded(store, cut) : cut).slice(-this.limit).reverse();
    const missed = store.missed.log + store.missed.steps;
    text(this.count, store.found && !store.found.isKnown ? "asking …" : `${shown.length} entries${store.recording ? " near this time" : ""}${missed ? `, ${missed} missed while this tab was too slow` : ""}`);
    const near = store.cursor === null ? null : newest.find((it) => it.t <= store.cursor + 1e-9)?.key;
    list(this.root, newest, (it) => it.key, (it) => this.make(it), (row, it) => {
      const times = this.fold.checked && it.times > 1 ? `×${it.times} since ${it.since.toFixed(2)} s` : "";
      text(row.lastChild.lastChild, times);
      className(row, `row ${it.level} ${it.kind === "step" ? "step" : ""} ${isControl(store, it) ? "control" : ""} ${it.key === near ? "chosen" : ""}`);
    });
  }

  make(it) {
    const seek = () => this.app.seek(it.t);
    return el("div", { class: "row", onclick: seek, title: "Click: all views show this time" },
      el("span", { class: "t" }, it.t.toFixed(2)), el("span", { class: "kind", title: it.kind }, kind(it)), el("span", { class: "component" }, it.component), el("span", { class: "text" }, entryText(it), el("span", { class: "times badge" })));
  }
}

/** The kind of an entry in a word: reports of coordinators have qualified names. */
function kind(it) { return it.kind.replace(/^asm\//, "").toLowerCase(); }

/** The text of an entry. */
export function entryText(it) {
  if (it.kind !== "step") return it.text;
  const changed = it.step.updates.filter((update) => update.before !== update.after);
  const words = changed.map((update) => `${update.location} := ${update.after}`).join(", ");
  return `${it.step.number}: ${words || "changed nothing"}`;
}

function isControl(store, it) {
  if (it.kind !== "step") return false;
  const location = store.specifications.find((known) => known.component === it.component)?.diagram?.location;
  return it.step.updates.some((update) => update.location === location && update.before !== update.after);
}

/** Entries without repetitions: of routine entries that say the same between two others, the newest one with their number. */
function folded(store, entries) {
  const shown = [];
  let same = new Map();
  for (const it of entries) {
    const isRoutine = it.level === "info" && ROUTINE.has(it.kind) && !isControl(store, it);
    const key = isRoutine ? `${it.kind} ${it.component} ${subject(it)}` : "";
    const known = same.get(key);
    it.times = 1;
    it.since = it.t;
    if (isRoutine && known !== undefined) {
      [it.times, it.since] = [shown[known].times + 1, shown[known].since];
      shown[known] = null;
    } else if (!isRoutine) same = new Map();
    if (isRoutine) same.set(key, shown.length);
    shown.push(it);
  }
  return shown.filter(Boolean);
}

/** What an entry is about, without its values. */
function subject(it) {
  return it.kind === "step" ? it.step.updates.filter((update) => update.before !== update.after).map((update) => update.location).join() : it.text.split(" ")[0];
}
