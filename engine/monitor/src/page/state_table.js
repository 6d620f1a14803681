// @ts-check
// The state of the specifications: locations with their values at the cursor; those of the last update set are highlighted.

import { el, panel, text, className, list } from "./dom.js";

export class StateTable {
  constructor(app) {
    this.app = app;
    this.filter = el("input", { type: "search", placeholder: "filter: mode !estop  (/)", "aria-label": "Filter locations", oninput: () => app.redraw() });
    this.title = el("span", { class: "faint" });
    /** Locations that stay at the top, as `component location`. @type {Set<string>} */
    this.pinned = new Set(JSON.parse(localStorage.getItem("pinned") ?? "[]"));
    this.body = el("tbody");
    this.empty = el("p", { class: "empty", hidden: true }, "This process runs no specification.");
    const head = el("tr", {}, el("th", {}, "location"), el("th", {}, "value"), el("th", { class: "number" }, "step"), el("th", { class: "number optional" }, "t, s"));
    const table = el("table", {}, el("thead", {}, head), this.body);
    this.root = panel("State", "state-panel", [this.title, el("span", { class: "grow" }), el("span", {}, this.filter)], el("div", { class: "body" }, table, this.empty));
  }

  draw() {
    const { store } = this.app;
    const rows = [], words = this.filter.value.trim().split(/\s+/).filter(Boolean);
    // a component that a later version of the composite has added is not in the description
    const added = Object.keys(store.states).filter((name) => !store.specifications.some((it) => it.component === name));
    const specifications = [...store.specifications, ...added.map((component) => ({ component, diagram: null, monitored: [] }))];
    for (const { component, diagram, monitored } of specifications) {
      const locations = store.locationsAt(component);
      const last = store.stepAt(component);
      const changed = new Map((last?.step.updates ?? []).map((it) => [it.location, it]));
      if (specifications.length > 1) rows.push({ key: component, heading: component });
      for (const name of monitored) if (!Object.keys(locations).some((it) => it === name || it.startsWith(`${name}(`))) locations[name] = { value: "not read yet", monitored: true, step: null, t: null };
      const order = (name) => (this.pinned.has(`${component} ${name}`) ? -1 : name === diagram?.location ? 0 : locations[name].monitored ? 2 : 1);
      const names = Object.keys(locations).sort((one, other) => order(one) - order(other) || (one < other ? -1 : 1));
      for (const name of names) {
        if (!matches(name, words)) continue;
        const update = changed.get(name);
        rows.push({ key: `${component} ${name}`, name, ...locations[name], changed: update && update.before !== update.after, before: update?.before, written: !!update });
      }
    }
    this.empty.hidden = specifications.length > 0;
    const steps = specifications.map(({ component }) => store.stepAt(component)?.step.number).filter(Boolean);
    text(this.title, steps.length === 0 ? "" : steps.length < 4 ? `step ${steps.join(", ")}` : `${steps.length} specifications`);
    list(this.body, rows, (it) => it.key, (it) => this.make(it), (row, it) => this.update(row, it));
  }

  make(it) {
    if (it.heading) return el("tr", {}, el("th", { colspan: 4 }, it.heading));
    const pin = () => this.pin(it.key);
    return el("tr", { tabindex: 0, title: "Click: keeps the location at the top", onclick: pin, onkeydown: (event) => { if (event.key === "Enter") pin(); } },
      el("td", {}, el("code", {}, it.name), " ", el("span", { class: "faint" })), el("td", { class: "value" }, el("span"), el("span", { class: "was" })), el("td", { class: "number" }), el("td", { class: "number optional" }));
  }

  update(row, it) {
    if (it.heading) return;
    const [name, value, step, t] = row.children;
    text(name.lastChild, [this.pinned.has(it.key) ? "★" : "", it.monitored ? "monitored" : ""].filter(Boolean).join(" "));
    text(value.firstChild, `${it.changed ? "● " : it.written ? "○ " : ""}${it.value}`);
    text(value.lastChild, it.changed ? ` was ${it.before}` : "");
    value.title = it.changed ? "changed by the last update set" : it.written ? "in the last update set, with the value it had" : "";
    text(step, it.step === null ? "" : it.step === 0 ? "initial" : String(it.step));
    text(t, it.t === null || it.step === 0 ? "" : it.t.toFixed(2));
    className(row, `pick ${it.changed ? "changed" : ""}`);
  }

  pin(key) {
    if (!this.pinned.delete(key)) this.pinned.add(key);
    localStorage.setItem("pinned", JSON.stringify([...this.pinned]));
    this.app.redraw();
  }
}

/** Whether a text matches all words; `!word` excludes. @param {string} name @param {string[]} words */
export function matches(name, words) {
  const lower = name.toLowerCase();
  return words.every((word) => (word.startsWith("!") ? word.length === 1 || !lower.includes(word.slice(1).toLowerCase()) : lower.includes(word.toLowerCase())));
}
