// @ts-check
// Values of locations over time, as a chart beneath the lanes: numbers and truth values as they are, others by name.

import { el } from "./dom.js";
import { Chart } from "./chart.js";

/** Limit on the number of locations that are shown. */
const MOST = 6;
const NUMBER = /^-?\d+(\.\d+)?(e-?\d+)?$/i;

export class Values {
  /** @param {any} app @param {() => number} labels width of the vertical axis, as that of the lanes */
  constructor(app, labels) {
    Object.assign(this, { app, labels });
    /** The shown locations, as `component location`. @type {string[]} */ this.chosen = [];
    this.select = el("select", { id: "values", "aria-label": "Show the values of a location", onchange: () => this.add(this.select.value) });
    this.root = el("div", { class: "values", hidden: true });
    this.offered = "";
  }

  add(key) {
    this.select.value = "";
    if (key && !this.chosen.includes(key)) this.chosen = [...this.chosen, key].slice(-MOST);
    this.build();
  }

  remove(key) {
    this.chosen = this.chosen.filter((it) => it !== key);
    this.build();
  }

  build() {
    for (const it of this.charts ?? []) it.chart?.destroy();
    this.charts = this.chosen.map((key) => ({ key, chart: null, kind: "" }));
    this.root.replaceChildren();
    this.root.hidden = !this.chosen.length;
    this.app.redraw();
  }

  /** Offers the locations that are known. */
  offer() {
    const { store } = this.app;
    const specifications = store.specifications;
    const keys = specifications.flatMap(({ component }) => Object.keys(store.locationsAt(component)).sort().map((location) => `${component} ${location}`));
    const offered = keys.join("\n");
    if (offered === this.offered) return;
    this.offered = offered;
    const words = (key) => (specifications.length > 1 ? key : key.split(" ").slice(1).join(" "));
    this.select.replaceChildren(el("option", { value: "" }, keys.length ? "values of …" : "no locations"), ...keys.map((key) => el("option", { value: key }, words(key))));
  }

  /** @param {number} begin @param {number} end @param {import("./folding.js").Folding} folding */
  draw(begin, end, folding) {
    this.offer();
    const { store } = this.app;
    const now = Math.min(end, store.t);
    (this.charts ?? []).forEach((it, index) => {
      const [component, ...rest] = it.key.split(" ");
      const location = rest.join(" ");
      const values = store.valuesOf(component, location);
      const present = store.locationsAt(component)[location]?.value;
      // a location that no known step has written has had its value all the time
      if (!values.length && present !== undefined) values.push([begin, present]);
      const { points, names } = scaled(values);
      if (points.length) points.push([Math.max(now, points[points.length - 1][0]), points[points.length - 1][1]]);
      const kind = JSON.stringify([names, this.labels()]);
      if (it.chart === null || it.kind !== kind) {
        it.kind = kind;
        it.chart?.destroy();
        it.chart = new Chart(this.app, location, "", { labels: this.labels(), names });
        it.chart.root.firstChild.append(el("button", { type: "button", title: "Hides the values", "aria-label": `Hides ${location}`, onclick: () => this.remove(it.key) }, "×"));
        this.root.insertBefore(it.chart.root, this.root.children[index] ?? null);
      }
      it.chart.draw([{ name: location, points, shade: `serie-${index % 6}`, stepped: true }], begin, end, { folding });
    });
  }
}

/** Values as numbers; those that are none get numbers in the order in which they appear, and their names.
 * @param {[number, string][]} values */
function scaled(values) {
  if (values.every(([, it]) => NUMBER.test(it) || it === "undef")) {
    return { points: values.map(([t, it]) => /** @type {[number, number | null]} */ ([t, it === "undef" ? null : Number(it)])), names: null };
  }
  const isTruth = values.every(([, it]) => it === "true" || it === "false");
  const names = isTruth ? ["false", "true"] : [...new Set(values.map(([, it]) => it))].slice(-12);
  return { points: values.map(([t, it]) => /** @type {[number, number | null]} */ ([t, names.includes(it) ? names.indexOf(it) : null])), names };
}
