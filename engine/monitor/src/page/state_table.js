// @ts-check
// The state of the specifications: locations with their values at the cursor; those of the last update set are highlighted.

import { el, panel, text, className, list } from "./dom.js";

export class StateTable {
  constructor(app) {
    this.app = app;
    this.filter = el("input", { type: "search", placeholder: "filter: mode !estop  (/)", "aria-label": "Filter locations", oninput: () => app.redraw() });
    this.title = el("span", { class: "faint" });
    this.body = el("tbody");
    this.empty = el("p", { class: "empty", hidden: true }, "This process runs no specification.");
    const head = el("tr", {}, el("th", {}, "location"), el("th", {}, "value"), el("th", { class: "number" }, "step"), el("th", { class: "number optional" }, "t, s"));
    const table = el("table", {}, el("thead", {}, head), this.body);
    this.root = panel("State", "state-panel", [this.title, el("span", { class: "grow" }), el("span", {}, this.filter)], el("div", { class: "body" }, table, this.empty));
  }

  draw() {
    const { store } = this.app;
    const rows = [], words = this.filter.value.trim().split(/\s+/).filter(Boolean);
    const specifications = store.system.specifications;
    for (const { component, diagram, monitored } of specifications) {
      const locations = store.locationsAt(component);
      const last = store.stepAt(component);
      const changed = new Map((last?.step.updates ?? []).map((it) => [it.location, it]));
      if (specifications.length > 1) rows.push({ key: component, heading: component });
      for (const name of monitored) if (!Object.keys(locations).some((it) => it === name || it.startsWith(`${name}(`))) locations[name] = { value: "not read yet", monitored: true, step: null, t: null };
      const order = (name) => (name === diagram?.location ? 0 : locations[name].monitored ? 2 : 1);
      const names = Object.keys(locations).sort((one, other) => order(one) - order(other) || (one < other ? -1 : 1));
      for (const name of names) {
        if (!matches(name, words)) continue;
        const update = changed.get(name);
        rows.push({ key: `${component} ${name}`, name, ...locations[name], changed: update && update.before !== update.after, written: !!update, control: name === diagram?.location });
      }
    }
    this.empty.hidden = specifications.length > 0;
    const steps = specifications.map(({ component }) => store.stepAt(component)?.step.number).filter(Boolean);
    text(this.title, steps.length ? `step ${steps.join(", ")}` : "");
    list(this.body, rows, (it) => it.key, (it) => this.make(it), (row, it) => this.update(row, it));
  }

  make(it) {
    if (it.heading) return el("tr", {}, el("th", { colspan: 4 }, it.heading));
    return el("tr", {}, el("td", {}, el("code", {}, it.name), " ", el("span", { class: "faint" })), el("td", { class: "value" }), el("td", { class: "number" }), el("td", { class: "number optional" }));
  }

  update(row, it) {
    if (it.heading) return;
    const [name, value, step, t] = row.children;
    text(name.lastChild, it.monitored ? "monitored" : "");
    text(value, `${it.changed ? "● " : it.written ? "○ " : ""}${it.value}`);
    value.title = it.changed ? "changed by the last update set" : it.written ? "in the last update set, with the value it had" : "";
    text(step, it.step === null ? "" : it.step === 0 ? "initial" : String(it.step));
    text(t, it.t === null || it.step === 0 ? "" : it.t.toFixed(2));
    className(row, it.changed ? "changed" : "");
  }
}

/** Whether a text matches all words; `!word` excludes. @param {string} name @param {string[]} words */
export function matches(name, words) {
  const lower = name.toLowerCase();
  return words.every((word) => (word.startsWith("!") ? word.length === 1 || !lower.includes(word.slice(1).toLowerCase()) : lower.includes(word.toLowerCase())));
}
