// @ts-check
// The guards of a step: what was asked on the way to each update, and the values that decided it.

import { el, text, className, list } from "./dom.js";

/** Interval between questions while steps follow each other, ms: a step is repeated to answer one. */
const EVERY = 2000;

export class Guards {
  /** @param {any} app @param {(place: string) => void} onplace */
  constructor(app, onplace) {
    Object.assign(this, { app, onplace });
    this.head = el("h3", {});
    this.body = el("tbody");
    this.empty = el("p", { class: "empty" });
    this.table = el("table", { id: "guards" }, el("thead", {}, el("tr", {}, ["guard", "was", "because of", "on the way to"].map((name) => el("th", {}, name)))), this.body);
    this.root = el("section", { class: "part", "aria-label": "Guards of the step" }, this.head, this.table, this.empty);
    this.asked = ""; this.at = -EVERY;
  }

  /** @param {string} component @param {any} entry the shown step @param {number} now */
  draw(component, entry, now) {
    const { store, link } = this.app;
    this.root.hidden = !entry;
    if (!entry) return;
    const { number } = entry.step, key = `${component} ${number} ${entry.t}`;
    const stands = store.isBack || !!store.recording;
    if (key !== this.asked && entry.step.updates.length && (now - this.at >= EVERY || stands) && link.send({ type: "guards", component, number, t: entry.t })) [this.asked, this.at] = [key, now];
    const known = store.guards?.component === component ? store.guards : null;
    const isShown = known?.number === number;
    // while steps follow each other, those of the last question stay
    const found = isShown || !stands ? known : null;
    text(this.head, `guards of step ${found?.number ?? number}`);
    const rows = grouped(found?.updates ?? []);
    this.table.hidden = !rows.length;
    text(this.empty, !entry.step.updates.length ? "The step wrote nothing." : found?.problem ? `Not known: ${found.problem}.` : !found ? "…" : rows.length ? "" : "The updates depend on no guard.");
    list(this.body, rows, (it) => it.key, () => el("tr", { class: "pick" }, el("td", {}, el("code")), el("td", {}, el("span", { class: "badge" })), el("td", { class: "value" }), el("td", { class: "faint mono" })), (row, it) => {
      const [guard, was, values, updates] = row.children;
      text(guard.firstChild, it.text);
      text(was.firstChild, it.holds ? "✓ true" : "✗ false");
      className(was.firstChild, `badge ${it.holds ? "good" : ""}`);
      text(values, it.values.map(([name, value]) => `${name} = ${value}`).join(", "));
      text(updates, it.updates.join(", "));
      row.title = it.place;
      row.onclick = () => this.onplace(it.place);
    });
  }
}

/** The guards of all updates, each once, with the locations whose updates it decided, outermost first. */
function grouped(updates) {
  const rows = new Map();
  for (const { location, guards } of updates) {
    for (const it of guards) {
      const key = JSON.stringify([it.place, it.text, it.holds, it.values]);
      if (!rows.has(key)) rows.set(key, { ...it, key, updates: [] });
      rows.get(key).updates.push(location);
    }
  }
  return [...rows.values()];
}
