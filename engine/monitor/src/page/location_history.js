// @ts-check
// The history of a location: when which rule gave it which value, and its values as a chart.

import { el, text, className, list } from "./dom.js";
import { Chart } from "./chart.js";

/** Limit on the number of changes in the table. */
const MOST = 40;

export class LocationHistory {
  /** @param {any} app @param {(place: string) => void} reveal */
  constructor(app, reveal) {
    Object.assign(this, { app, reveal });
    this.isNew = false;
    this.component = ""; this.location = /** @type {string | null} */ (null);
    this.title = el("h3", { id: "history" });
    this.place = el("div");
    this.body = el("tbody");
    const close = el("button", { type: "button", onclick: () => { this.choose(this.component, null); app.redraw(); } }, "Close");
    const head = el("thead", {}, el("tr", {}, ["t, s", "step", "before", "after", "by"].map((name) => el("th", {}, name))));
    this.root = el("section", { class: "part", "aria-label": "History of a location", hidden: true }, el("div", { class: "bar" }, this.title, el("span", { class: "grow" }), close), this.place, el("table", {}, head, this.body));
  }

  /** @param {string} component @param {string | null} location null shows none */
  choose(component, location) {
    Object.assign(this, { component, location });
    this.root.hidden = location === null;
    text(this.title, `history of ${location ?? ""}`);
    this.recolour();
    this.isNew = location !== null;
  }

  /** The next drawing makes another chart. */
  recolour() {
    this.chart?.destroy();
    this.chart = null;
  }

  draw(locations) {
    if (this.location === null) return;
    const { store } = this.app;
    const steps = store.stepsOf(this.component);
    const writes = steps.flatMap((it) => it.step.updates.filter((update) => update.location === this.location && update.before !== update.after).map((update) => ({ t: it.t, number: it.step.number, ...update })));
    const values = store.valuesOf(this.component, this.location);
    const reads = writes.length ? [] : changes(values);
    const rows = [...writes, ...reads].slice(-MOST).reverse();
    const at = store.cursor ?? Infinity;
    const current = rows.find((it) => it.t <= at + 1e-9);
    list(this.body, rows, (it) => `${it.t} ${it.number ?? ""}`, () => el("tr", { class: "pick" }, Array.from({ length: 5 }, (_, index) => el("td", { class: index > 1 && index < 4 ? "value" : index < 2 ? "number" : "" }))), (row, it) => {
      const words = [it.t.toFixed(2), it.number === undefined ? "" : String(it.number), it.before, it.after, it.place?.replace(/^.*:/, "line ") ?? "the environment"];
      words.forEach((value, index) => text(row.children[index], value));
      className(row, `pick ${it === current ? "chosen" : ""}`);
      row.onclick = () => { this.app.seek(it.t); if (it.place) this.reveal(it.place); };
    });
    if (this.isNew) this.root.scrollIntoView({ block: "nearest" });
    this.isNew = false;
    const numbers = values.map(([t, it]) => /** @type {[number, number | null]} */ ([t, it === "undef" ? null : Number(it)]));
    if (numbers.length < 2 || numbers.some(([, it]) => it !== null && !Number.isFinite(it))) return this.recolour();
    if (!this.chart) {
      this.chart = new Chart(this.app, this.location, "");
      this.place.replaceChildren(this.chart.root);
    }
    const [begin, end] = this.app.shown(30);
    numbers.push([Math.max(Math.min(end, store.t), numbers[numbers.length - 1][0]), numbers[numbers.length - 1][1]]);
    this.chart.draw([{ name: this.location, points: numbers, shade: "serie-0", stepped: true }], begin, end);
  }
}

/** Changes of values that the environment determines. @param {[number, string][]} values */
function changes(values) {
  return values.flatMap(([t, after], index) => (index && values[index - 1][1] !== after ? [{ t, before: values[index - 1][1], after }] : []));
}
