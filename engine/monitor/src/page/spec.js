// @ts-check
// Spec: the source with last values, the control-state diagram, and the update set of each recent step.

import { el, panel, text, className, list } from "./dom.js";
import { Diagram } from "./diagram.js";
import { Properties } from "./properties.js";
import { LocationHistory } from "./location_history.js";
import { Guards } from "./guards.js";

const WORDS = /\b(asm|module|import|signature|definitions|default|init|domain|enum|abstract|subsetof|controlled|monitored|shared|out|static|derived|function|rule|macro|main|par|endpar|seq|endseq|if|then|else|endif|switch|case|otherwise|endswitch|let|in|endlet|forall|with|do|choose|ifnone|extend|skip|and|or|not|implies|iff|invariant|over|CTLSPEC|LTLSPEC|undef|true|false|agent|local|while|iterate)\b/;

export class Spec {
  constructor(app) {
    this.app = app;
    this.component = app.store.specifications[0]?.component;
    this.choice = el("select", { "aria-label": "Specification", hidden: app.store.specifications.length < 2, onchange: () => { this.component = this.choice.value; this.build(); app.redraw(); } },
      app.store.specifications.map((it) => el("option", {}, it.component)));
    this.source = el("div", { class: "body source" });
    this.sourceTitle = el("span", { class: "faint mono" });
    this.coverage = el("span", { class: "faint", id: "coverage" });
    this.place = el("div", { class: "body" });
    this.step = el("strong", { class: "mono", id: "step" });
    this.updates = el("tbody");
    this.inputs = el("tbody");
    this.choices = el("p", { class: "faint" });
    this.properties = new Properties(app, (place) => this.reveal(place));
    this.guards = new Guards(app, (place) => this.reveal(place));
    this.history = new LocationHistory(app, (place) => this.reveal(place));
    const button = (words, title, action) => el("button", { type: "button", title, onclick: action }, words);
    const steps = [this.step, el("span", { class: "grow" }), button("◀ state", "Previous change of the control state ({)", () => app.change(-1, this.component)), button("◀ step", "Previous step ([)", () => this.move(-1)), button("step ▶", "Next step (])", () => this.move(1)),
      button("state ▶", "Next change of the control state (})", () => app.change(1, this.component)), app.store.recording ? null : button("Live", "Back to live (Esc)", () => app.seek(null))];
    const head = (...names) => el("thead", {}, el("tr", {}, names.map((name) => el("th", {}, name))));
    const sets = el("div", { class: "body" },
      el("table", { id: "updates" }, head("location", "before", "after", "by"), this.updates),
      el("table", { id: "inputs" }, head("input that was read", "value"), this.inputs), el("div", { class: "empty" }, this.choices), this.guards.root, this.history.root, this.properties.root);
    this.root = el("div", { class: "grid spec" }, panel("Source", "source-panel", [this.sourceTitle, el("span", { class: "grow" }), this.coverage, this.choice], this.source),
      panel("Control state", "diagram-panel", [], this.place), panel("Update set", "update-panel", steps, sets));
    this.build();
  }

  streams() { return []; }

  get specification() { return this.app.store.specifications.find((it) => it.component === this.component); }

  recolour() { this.history.recolour(); }

  build() {
    const specification = this.built = this.specification;
    this.lines = new Map();
    this.worths = [];
    this.source.replaceChildren();
    this.place.replaceChildren();
    this.diagram = null;
    this.history.choose(this.component, null);
    if (!specification) {
      this.source.append(el("p", { class: "empty" }, "This process runs no specification."));
      return;
    }
    const versions = this.app.store.system.specifications.filter((it) => it.component === this.component);
    const version = versions.length > 1 ? ` · version ${versions.indexOf(specification) + 1} of ${versions.length}, from ${specification.from.toFixed(2)} s` : "";
    text(this.sourceTitle, `${specification.files[0]?.name ?? ""} · ${this.component}${version}`);
    for (const file of specification.files) this.file(file);
    if (specification.diagram) {
      this.diagram = new Diagram(specification.diagram, (line) => this.reveal(`${specification.files[0].name}:${line}`));
      this.place.append(this.diagram.root);
    } else this.place.append(el("p", { class: "empty" }, "No controlled function without arguments takes the literals of an enumeration, so there is no control state."));
  }

  file(file) {
    file.text.split("\n").forEach((line, index) => {
      const worth = el("span", { class: "worth", hidden: true });
      const row = el("div", { class: "line" }, el("span"), el("span", { class: "number" }, index + 1), el("span", { class: "heat" }), el("span", { class: "code" }, coloured(line)), worth);
      this.source.append(row);
      const declared = /^\s*(controlled|monitored|out|shared)\s+(\w+)\s*:/.exec(line);
      if (declared) {
        this.worths.push({ worth, name: declared[2] });
        worth.addEventListener("click", () => this.choose(declared[2]));
      }
      this.lines.set(`${file.name}:${index + 1}`, { row, updates: /:=/.test(line) });
    });
  }

  /** Shows the history of a function's first known location. @param {string} name */
  choose(name) {
    const known = Object.keys(this.app.store.locationsAt(this.component));
    this.history.choose(this.component, known.find((it) => it === name || it.startsWith(`${name}(`)) ?? name);
    this.app.redraw();
  }

  reveal(place) { this.lines.get(place)?.row.scrollIntoView({ block: "center" }); }

  /** Moves to the previous or next step of this specification. */
  move(by) {
    const { store } = this.app;
    const steps = store.stepsOf(this.component);
    const at = steps.indexOf(store.stepAt(this.component));
    const next = by < 0 && store.cursor === null ? steps.at(-2) ?? steps.at(-1) : steps[at + by];
    if (next) this.app.seek(next.t); else if (by > 0 && !store.recording) this.app.seek(null);
    const place = next?.step.updates[0]?.place;
    if (place) this.reveal(place);
  }

  draw(now, texts) {
    if (!texts || !this.specification) return;
    // another version of a recording may have run at the cursor
    if (this.specification !== this.built) this.build();
    const { store } = this.app;
    const entry = store.stepAt(this.component);
    const step = entry?.step;
    const locations = store.locationsAt(this.component);
    text(this.step, step ? `step ${step.number} at ${entry.t.toFixed(2)} s` : "no step has written anything yet");
    const make = (count) => () => el("tr", {}, Array.from({ length: count }, (_, index) => el("td", { class: index ? "value" : "" })));
    list(this.updates, step?.updates ?? [], (it) => it.location, make(4), (row, it) => {
      const [location, before, after, by] = row.children;
      text(location, it.location); text(before, it.before); text(after, `${it.before === it.after ? "○" : "●"} ${it.after}`); text(by, it.place.replace(/^.*:/, "line "));
      row.onclick = () => { this.reveal(it.place); this.history.choose(this.component, it.location); this.app.redraw(); };
      className(row, it.before === it.after ? "pick" : "pick changed");
    });
    list(this.inputs, step?.inputs ?? [], (it) => it[0], make(2), (row, [location, value]) => { text(row.children[0], location); text(row.children[1], value); });
    text(this.choices, step?.choices.length ? `Choices: ${step.choices.map(([index, count]) => `candidate ${index + 1} of ${count}`).join(", ")}` : "The step made no choice.");
    this.values(locations, new Set((step?.updates ?? []).filter((it) => it.before !== it.after).map((it) => it.location)));
    this.heat(new Set((step?.updates ?? []).map((it) => it.place)));
    this.drawDiagram(locations, entry);
    this.guards.draw(this.component, entry, now);
    this.history.draw(locations);
    this.properties.draw(this.specification);
  }

  /** Writes the last values beside the declarations. */
  values(locations, changed) {
    for (const { worth, name } of this.worths) {
      const found = Object.entries(locations).filter(([location]) => location === name || location.startsWith(`${name}(`));
      const words = found.slice(0, 4).map(([location, it]) => (location === name ? `= ${it.value}` : `${location.slice(name.length)} = ${it.value}`)).join("  ") + (found.length > 4 ? ` … ${found.length} in all` : "");
      worth.hidden = false;
      text(worth, words || "not read yet");
      worth.title = found.map(([location, it]) => `${location} = ${it.value}`).join("\n");
      className(worth, `worth ${found.some(([location]) => changed.has(location)) ? "changed" : found.length ? "" : "unknown"}`);
    }
  }

  /** Marks the updates of the step, and how often each update was made. */
  heat(fired) {
    const heat = this.app.store.states[this.component]?.heat ?? {};
    const most = Math.max(1, ...Object.values(heat));
    let [made, all] = [0, 0];
    for (const [place, { row, updates }] of this.lines) {
      const count = heat[place] ?? 0;
      if (!updates && !count) continue;
      all++;
      if (count) made++;
      text(row.children[2], count ? `${count}×` : "never");
      className(row, `line ${fired.has(place) ? "fired" : ""} ${count ? "" : "never"}`);
      const share = count ? 0.25 + 0.75 * Math.log1p(count) / Math.log1p(most) : 0;
      row.firstChild.style.background = count ? `color-mix(in srgb, var(--note) ${Math.round(share * 100)}%, transparent)` : "";
    }
    text(this.coverage, all ? `${made} of ${all} updates made` : "");
  }

  drawDiagram(locations, entry) {
    if (!this.diagram) return;
    const { location } = this.specification.diagram;
    const counts = new Map();
    let last;
    for (const it of this.app.store.stepsOf(this.component)) {
      const update = it.step.updates.find((known) => known.location === location && known.before !== known.after);
      if (!update) continue;
      counts.set(update.after, (counts.get(update.after) ?? 0) + 1);
      if (entry && it.t <= entry.t + 1e-9) last = update;
    }
    const initial = this.specification.diagram.initial;
    if (initial && !counts.has(initial)) counts.set(initial, 1);
    this.diagram.draw(locations[location]?.value, last, counts);
  }
}

/** A line of source as text nodes with classes. */
function coloured(line) {
  const parts = [];
  let rest = line;
  const comment = line.indexOf("//");
  const tail = comment >= 0 ? el("span", { class: "comment" }, line.slice(comment)) : null;
  if (comment >= 0) rest = line.slice(0, comment);
  for (const part of rest.split(/(\b\w+\b)/)) {
    if (WORDS.test(part) && part.match(WORDS)?.[0] === part) parts.push(el("span", { class: "word" }, part));
    else if (/^([A-Z][A-Z0-9_]+|\d+(\.\d+)?)$/.test(part)) parts.push(el("span", { class: "literal" }, part));
    else if (part) parts.push(part);
  }
  return tail ? [...parts, tail] : parts;
}
