// @ts-check
// The list of log entries and steps, newest first. However long it is, the page has only the rows that can be seen.

import { el, text, list, className } from "./dom.js";
import { matches } from "./state_table.js";
import { Rows, entryText, isControl } from "./log_rows.js";

const LEVELS = ["info", "notice", "warning", "error"];
const WORDS = { info: "all levels", notice: "notices and above", warning: "warnings and errors", error: "errors" };
/** Height of a row in px: one line, and two where the page is narrow. */
const [HEIGHT, NARROW_HEIGHT] = [21, 38];
const narrow = matchMedia("(max-width: 560px)");
/** Number of rows that are made on each side of those that can be seen. */
const MORE = 6;
/** Times that differ by less may arrive in another order, s. */
const DISORDER = 0.5;

export class LogList {
  /** @param {any} app @param {{ levels?: boolean }} options */
  constructor(app, options = {}) {
    this.app = app;
    this.filter = el("input", { type: "search", placeholder: "filter: call !reply  (/)", "aria-label": "Filter entries", oninput: () => app.redraw() });
    this.level = el("select", { "aria-label": "Least level", onchange: () => app.redraw() }, LEVELS.map((it) => el("option", { value: it }, WORDS[it])));
    this.fold = el("input", { type: "checkbox", checked: true, onchange: () => app.redraw() });
    this.count = el("span", { class: "faint" });
    this.tools = [el("span", { class: "grow" }), this.count, el("label", { title: "Counts entries of the same kind between others" }, this.fold, " fold"), options.levels ? this.level : null, el("span", {}, this.filter)];
    this.space = el("div", { class: "space", role: "list" });
    this.root = el("div", { class: "body log", role: "log", "aria-live": "off", tabindex: 0, "aria-label": "Entries, newest first", onscroll: () => this.window(), onkeydown: (event) => this.key(event) }, this.space);
    /** The whole text of the row that was picked. */
    this.detail = el("div", { class: "log-detail mono", hidden: true });
    narrow.addEventListener("change", () => { this.changes = ""; app.redraw(); });
    this.changes = ""; this.source = "";
    this.rows = new Rows(app.store, { fold: true, passes: () => true });
    /** How much of the entries and steps has become rows. */
    this.seen = { entries: -1, steps: -1, t: -Infinity };
    /** The row that the keys move, and the one at the shown time. @type {any} */ this.current = null; /** @type {any} */ this.near = null;
    /** Number of the row that the keys move, from the oldest one that there ever was. */ this.number = 0;
    /** Number of rows, and of those that were too old, when they were drawn last. */
    this.drawn = { count: 0, dropped: 0 };
  }

  get height() { return narrow.matches ? NARROW_HEIGHT : HEIGHT; }

  draw() {
    const { store } = this.app;
    const words = this.filter.value.trim().split(/\s+/).filter(Boolean);
    // the server sends only what passes, and what it has kept of it
    store.filter(words, this.level.value);
    const shown = [store.cursor, this.fold.checked].join();
    const changes = [store.changes.log, store.changes.steps, shown, this.filter.value, this.level.value, this.root.clientHeight].join();
    if (changes === this.changes) return;
    this.changes = changes;
    this.follow(words);
    const missed = store.missed.log + store.missed.steps;
    text(this.count, store.found && !store.found.isKnown ? "asking …" : `${this.rows.passed} entries${store.recording ? " near this time" : ""}${missed ? `, ${missed} missed while this tab was too slow` : ""}`);
    this.near = store.cursor === null ? null : this.rows.near(store.cursor);
    this.scroll(shown);
    this.window();
  }

  /** Makes rows of what is new, or of everything if something else is shown than before. @param {string[]} words */
  follow(words) {
    const { store } = this.app;
    const source = [store.epoch, store.recording ? store.changes.log + store.changes.steps : "", store.found?.number, store.found?.isKnown, this.filter.value, this.level.value, this.fold.checked].join();
    const isNew = source !== this.source;
    if (!isNew && this.add(this.news())) return;
    this.source = source;
    const least = LEVELS.indexOf(this.level.value);
    const passes = (it) => LEVELS.indexOf(it.level) >= least && (!words.length || matches(`${it.kind} ${it.component} ${entryText(it)}`, words));
    this.number -= this.rows.dropped;
    this.rows = new Rows(store, { fold: this.fold.checked, passes });
    this.seen = { entries: -1, steps: -1, t: -Infinity };
    this.drawn.dropped = 0;
    this.add(this.news());
    // a recording sends its entries again; after entries in another order, the row is another one in the same place
    this.current = this.current && (this.rows.find(this.current.key) ?? (isNew ? null : this.current));
  }

  /** Entries and steps since the last time, by time. @returns {any[]} */
  news() {
    const { store } = this.app;
    // a recording has all steps, also those that a running system does not report
    const steps = store.stepsSince(this.seen.steps).filter((it) => it.step.updates.length || !store.recording);
    for (const it of steps) { it.kind = "step"; it.level = "info"; it.key ??= `s${it.component}${it.step.number}`; }
    const entries = store.entriesSince(this.seen.entries);
    return [...steps, ...entries].sort((one, other) => one.t - other.t);
  }

  /** @param {any[]} news @returns {boolean} whether they follow what is shown: otherwise, all rows have to be made again */
  add(news) {
    const { store } = this.app;
    if (news.length && news[0].t < this.seen.t - DISORDER) return false;
    for (const it of news) this.rows.add(it);
    if (news.length) this.seen.t = Math.max(this.seen.t, news[news.length - 1].t);
    this.seen.entries = store.logCount;
    this.seen.steps = store.stepCount;
    return true;
  }

  /** Keeps the rows where they are while others come above them, and moves to the shown time if that is another one. @param {string} shown */
  scroll(shown) {
    const count = this.rows.count, dropped = this.rows.dropped;
    this.space.style.height = `${count * this.height}px`;
    const added = count - this.drawn.count + dropped - this.drawn.dropped;
    if (shown !== this.shown) {
      this.shown = shown;
      const index = this.near ? this.rows.indexOf(this.near) : 0;
      const first = this.root.scrollTop / this.height, seen = this.root.clientHeight / this.height;
      // a row that was clicked stays where it is
      if (index < first || index >= first + seen - 1) this.root.scrollTop = Math.max(0, (index - Math.floor(seen / 3)) * this.height);
    } else if (added > 0 && this.root.scrollTop > 0) this.root.scrollTop += added * this.height;
    this.drawn = { count, dropped };
  }

  /** Makes the rows that can be seen, and the one that has the focus. */
  window() {
    const { store } = this.app;
    const height = this.height, count = this.rows.count;
    const first = Math.max(0, Math.floor(this.root.scrollTop / height) - MORE);
    const last = Math.min(count, Math.ceil((this.root.scrollTop + this.root.clientHeight) / height) + MORE);
    const rows = this.rows.newest(first, last);
    const at = this.place();
    if (at >= 0 && (at < first || at >= last)) rows.push({ row: this.current, index: at });
    const hasFocus = this.space.contains(document.activeElement);
    list(this.space, rows, ({ row }) => row.key, ({ row }) => this.make(row.it), (element, { row, index }) => {
      const { it, times, since } = row;
      element.style.transform = `translateY(${index * height}px)`;
      element.style.height = `${height}px`;
      element.setAttribute("aria-posinset", String(index + 1));
      element.setAttribute("aria-setsize", String(count));
      element.row = row;
      text(element.lastChild.lastChild, times > 1 ? `×${times} since ${since.toFixed(2)} s` : "");
      className(element, `row ${it.level} ${it.kind === "step" ? "step" : ""} ${isControl(store, it) ? "control" : ""} ${row === this.near ? "chosen" : ""} ${row === this.current ? "current" : ""}`);
    });
    if (hasFocus && !this.space.contains(document.activeElement)) this.focus();
    const words = this.current ? entryText(this.current.it) : "";
    this.detail.hidden = !words;
    text(this.detail, words);
  }

  /** Finds the row that the keys move. Where a repetition has become the newest row, and the row is no more, the keys move the one in its place.
   * @returns {number} its number from the newest one; -1 if there is none */
  place() {
    if (!this.current || !this.rows.count) { this.current = null; return -1; }
    const { count, dropped } = this.rows;
    let at = this.rows.indexOf(this.current);
    if (at < 0) {
      at = Math.min(count - 1, Math.max(0, count - 1 + dropped - this.number));
      this.current = this.rows.newest(at, at + 1)[0].row;
    }
    this.number = dropped + count - 1 - at;
    return at;
  }

  make(it) {
    const row = el("div", { class: "row", role: "listitem", tabindex: -1, title: entryText(it) },
      el("span", { class: "t" }, it.t.toFixed(2)), el("span", { class: "kind", title: it.kind }, kind(it)), el("span", { class: "component" }, it.component), el("span", { class: "text" }, entryText(it), el("span", { class: "times badge" })));
    row.addEventListener("click", () => this.pick(row["row"]));
    return row;
  }

  /** Shows the time of a row in all views, and its whole text. @param {import("./log_rows.js").Row} row */
  pick(row) {
    this.current = row;
    this.app.seek(row.it.t);
    this.window();
  }

  /** Moves through the rows, and shows the time of one. @param {KeyboardEvent} event */
  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const page = Math.max(1, Math.floor(this.root.clientHeight / this.height) - 1);
    const by = { ArrowDown: 1, ArrowUp: -1, PageDown: page, PageUp: -page, Home: -Infinity, End: Infinity }[event.key];
    const at = this.place();
    if (event.key === "Enter" && at >= 0) this.pick(this.current);
    else if (by !== undefined && this.rows.count) this.move(at < 0 && Math.abs(by) < Infinity ? Math.floor(this.root.scrollTop / this.height) : Math.min(this.rows.count - 1, Math.max(0, at + by)));
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** Gives the focus to a row. @param {number} index */
  move(index) {
    this.current = this.rows.newest(index, index + 1)[0].row;
    const top = index * this.height, bottom = top + this.height;
    if (top < this.root.scrollTop) this.root.scrollTop = top;
    else if (bottom > this.root.scrollTop + this.root.clientHeight) this.root.scrollTop = bottom - this.root.clientHeight;
    this.window();
    this.focus();
  }

  focus() {
    for (const element of this.space.children) if (element["row"] === this.current) /** @type {HTMLElement} */ (element).focus({ preventScroll: true });
  }
}

/** The kind of an entry in a word: reports of coordinators have qualified names. */
function kind(it) { return it.kind.replace(/^asm\//, "").toLowerCase(); }
