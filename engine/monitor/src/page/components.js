// @ts-check
// Components: rates, ages, broken connections in words, properties and the life cycle.

import { el, panel, text, className, list, fixed } from "./dom.js";
import { findings, readersOf, writersOf } from "./findings.js";
import { Graph, perSecond, traffic } from "./graph.js";
import { matches } from "./state_table.js";

const TRANSITIONS = ["configure", "start", "stop", "cleanup", "recover", "reset"];
const COLUMNS = ["component", "state", "period, ms", "measured, ms", "mean, ms", "max, ms", "overruns", "lost"];

export class Components {
  constructor(app) {
    this.app = app;
    this.chosen = null;
    /** The port whose newest sample is shown. @type {string | null} */ this.inspected = null;
    this.findings = el("div", { class: "body findings", id: "findings" });
    this.body = el("tbody");
    const head = el("tr", {}, COLUMNS.map((name, index) => el("th", { class: `${index > 1 ? "number" : ""} ${[4, 5].includes(index) ? "optional" : ""}` }, name)));
    this.graph = new Graph(app, (name) => this.choose(name));
    this.filter = el("input", { type: "search", placeholder: "filter: Rover !laser  (/)", "aria-label": "Filter components", oninput: () => app.redraw() });
    this.slow = el("select", { "aria-label": "Hide frequent connections", onchange: () => app.redraw() }, [["", "all connections"], [30, "up to 30 Hz"], [10, "up to 10 Hz"], [1, "up to 1 Hz"]].map(([hz, words]) => el("option", { value: hz }, words)));
    this.title = el("strong");
    this.detail = el("div", { class: "body detail" });
    this.root = el("div", { class: "grid components" },
      panel("Findings", "findings-panel", [], this.findings), panel("Connections", "graph-panel", [el("span", { class: "faint" }, "click a component"), el("span", { class: "grow" }), this.slow, el("span", {}, this.filter)], el("div", { class: "body" }, this.graph.root)),
      panel("Components", "table-panel", [], el("div", { class: "body" }, el("table", { id: "components" }, el("thead", {}, head), this.body))), panel("Detail", "detail-panel", [this.title], this.detail));
    this.parts = null;
  }

  streams() { return this.inspected ? [this.inspected] : []; }

  choose(name) {
    this.chosen = name;
    this.inspected = null;
    this.parts = null;
    this.app.redraw();
  }

  draw(now, texts) {
    if (!texts) return;
    const { store } = this.app;
    this.chosen ??= store.specifications[0]?.component ?? store.components[0]?.name ?? null;
    const found = findings(store);
    const shown = found.length ? found : [{ level: "fine", text: store.components.length ? "All components run, and no regular output is silent." : store.recording ? "The composite is not attached to the recording, so its connections are not known." : "Waiting for the first description of the components." }];
    list(this.findings, shown, (it) => it.text.replace(/[\d.]+/g, ""), () => el("p"), (row, it) => {
      className(row, `${it.level} ${it.component ? "pick" : ""}`);
      text(row, it.text);
      row.onclick = it.component ? () => this.choose(it.component) : null;
    });
    const words = this.filter.value.trim().split(/\s+/).filter(Boolean);
    const wanted = store.components.filter((it) => matches(it.name, words));
    list(this.body, wanted, (it) => it.name, (it) => this.make(it.name), (row, it) => this.update(row, it));
    if (store.components.length) this.graph.draw(this.chosen, wanted, Number(this.slow.value) || Infinity);
    this.drawDetail();
  }

  make(name) {
    const cells = COLUMNS.map((_, index) => el("td", { class: `${index > 1 ? "number" : ""} ${[4, 5].includes(index) ? "optional" : ""}` }));
    cells[1].append(el("span", { class: "badge" }));
    return el("tr", { class: "pick", tabindex: 0, onclick: () => this.choose(name), onkeydown: (event) => { if (event.key === "Enter") this.choose(name); } }, cells);
  }

  update(row, it) {
    const [name, state, period, measured, mean, max, overruns, lost] = row.children;
    text(name, it.name);
    name.title = it.name;
    const stale = this.app.store.outputs.filter((output) => output.stale && output.name.startsWith(`${it.name}.`));
    const oldest = Math.max(0, ...stale.map((output) => this.app.store.age(output.name) ?? 0));
    const running = it.state === "Running" || it.state === "";
    text(state.firstChild, stale.length && running ? `stale ${(oldest / 1000).toFixed(0)} s` : it.state || "–");
    className(state.firstChild, `badge ${!running ? "bad" : stale.length ? "stale" : it.state ? "good" : ""}`);
    text(period, it.period_ms ? String(it.period_ms) : "event");
    text(measured, it.rate_hz > 0 ? fixed(1000 / it.rate_hz, 1) : "–");
    // a recording has no durations of cycles
    text(mean, it.cycle_mean_ms ? fixed(it.cycle_mean_ms, 3) : "–");
    text(max, it.cycle_max_ms ? fixed(it.cycle_max_ms, 3) : "–");
    text(overruns, String(it.overruns));
    text(lost, String(it.dropped + it.misfits));
    className(row, `pick ${it.name === this.chosen ? "chosen" : ""} ${stale.length || !running ? "stale" : ""}`);
  }

  drawDetail() {
    const { store, control } = this.app;
    const it = store.components.find((known) => known.name === this.chosen);
    text(this.title, this.chosen ?? "");
    if (!it) return;
    const shape = JSON.stringify([it.name, it.inputs.map((port) => port.name), it.outputs.map((port) => port.name), it.properties.map(([name]) => name)]);
    if (this.parts?.shape !== shape) this.build(it, shape);
    const { buttons, ports, properties } = this.parts;
    this.sample();
    for (const [transition, button] of Object.entries(buttons)) {
      button.disabled = !control.armed;
      button.title = control.armed ? `${transition} ${it.name}` : control.reason;
    }
    for (const [name, row] of ports) this.drawPort(row, name, it);
    for (const [name, value] of it.properties) {
      const field = properties.get(name);
      field.input.disabled = field.button.disabled = !control.armed;
      field.button.title = control.reason;
      if (document.activeElement !== field.input && !field.edited) field.input.value = JSON.stringify(value);
    }
  }

  drawPort(row, name, component) {
    const { store } = this.app;
    const [, rate, age] = row.children;
    const input = component.inputs.find((port) => `${component.name}.${port.name}` === name);
    // an input is as fast and as old as what leads to it
    const sources = input ? [name, ...writersOf(store, name)] : [name];
    const outputs = sources.map((it) => store.output.get(it)).filter((it) => it?.n);
    const output = outputs.sort((one, other) => (store.age(one.name) ?? Infinity) - (store.age(other.name) ?? Infinity))[0];
    const words = [outputs.length === 1 && output.hz ? `${output.hz.toFixed(1)} Hz` : "", outputs.length === 1 && traffic(output) ? perSecond(traffic(output)) : "", input?.waiting ? `▤ ${input.waiting} wait` : "", input?.lost ? `${input.lost} lost` : ""].filter(Boolean);
    text(rate, words.join(", ") || "–");
    const now = output ? store.age(output.name) : null;
    text(age, now === null ? "never" : `${(now / 1000).toFixed(1)} s`);
    row.title = input && sources.length > 1 ? `from ${sources.slice(1).join(", ")}` : "Click: the newest sample";
    className(row, `pick ${output?.stale ? "stale" : ""} ${name === this.inspected ? "chosen" : ""}`);
  }

  /** The newest sample of the chosen port. */
  sample() {
    const { place, title, value } = this.parts.sample;
    place.hidden = !this.inspected;
    if (!this.inspected) return;
    const { store } = this.app;
    const sample = store.samples.get(this.inspected);
    const readers = readersOf(store, this.inspected);
    const age = store.age(this.inspected);
    text(title, `${this.inspected}${age === null ? "" : `, ${(age / 1000).toFixed(1)} s ago`}${readers.length ? ` → ${readers.join(", ")}` : ""}`);
    text(value, sample ? brief(sample.data) : store.isBack ? "Samples of the past are in a recording." : "No sample has been written yet.");
  }

  build(it, shape) {
    const { app } = this;
    const described = app.store.system.components.find((known) => known.name === it.name);
    const buttons = Object.fromEntries(TRANSITIONS.map((transition) => [transition, el("button", { type: "button", onclick: () => app.control.wish(it.name, transition, `${transition} ${it.name}`) }, transition)]));
    const ports = new Map();
    const table = (list, head) => {
      const rows = list.map((port) => {
        const name = `${it.name}.${port.name}`;
        const inspect = () => {
          // the sample of an input is that of what leads to it
          const shown = [name, ...writersOf(app.store, name)].find((it) => app.store.output.get(it)?.n) ?? name;
          this.inspected = this.inspected === shown ? null : shown;
          app.redraw();
        };
        const row = el("tr", { tabindex: 0, title: "Click: the newest sample", onclick: inspect, onkeydown: (event) => { if (event.key === "Enter") inspect(); } }, el("td", {}, el("code", {}, port.name), " ", el("span", { class: "faint" }, port.type)), el("td", { class: "number" }), el("td", { class: "number" }));
        ports.set(`${it.name}.${port.name}`, row);
        return row;
      });
      return list.length ? [el("h3", {}, head), el("table", {}, el("tbody", {}, rows))] : [];
    };
    const properties = new Map();
    const rows = it.properties.map(([name]) => {
      const field = { edited: false, input: el("input", { "aria-label": name }), button: el("button", { type: "button" }, "Set") };
      field.input.addEventListener("input", () => { field.edited = true; });
      const set = async () => {
        let value;
        try { value = JSON.parse(field.input.value); } catch { value = field.input.value; }
        await app.control.wish(it.name, { set: [[name, value]] }, `${it.name}.${name} = ${field.input.value}`);
        field.edited = false;
      };
      field.button.addEventListener("click", set);
      field.input.addEventListener("keydown", (event) => { if (event.key === "Enter") set(); });
      properties.set(name, field);
      return el("tr", {}, el("td", {}, el("code", {}, name)), el("td", { class: "number" }, field.input, " ", field.button));
    });
    const services = [...it.services.map((service) => `provides ${service.name}: ${service.interface}`), ...it.references.map((reference) => `requires ${reference.name}: ${reference.type}`)];
    const sample = { title: el("h3", { class: "as-is" }), value: el("pre", { id: "sample" }), place: /** @type {any} */ (null) };
    sample.place = el("div", { hidden: true }, sample.title, sample.value);
    this.parts = { shape, buttons, ports, properties, sample };
    this.detail.replaceChildren(...[
      el("div", { class: "bar faint mono" }, described?.implementation ?? ""), app.store.recording ? null : el("div", { class: "bar" }, Object.values(buttons)),
      ...table(it.outputs, "outputs: rate, age"), ...table(it.inputs, "inputs: rate, age"), sample.place,
      ...(services.length ? [el("h3", {}, "services"), ...services.map((line) => el("div", { class: "service mono" }, line))] : []),
      ...(rows.length ? [el("h3", {}, "properties"), el("table", {}, el("tbody", {}, rows))] : [])].filter(Boolean));
  }
}

/** Limit on the length of a shown sample, in characters, and on that of a list, in elements. */
const [LENGTH, ELEMENTS] = [4000, 12];

/** A sample as text, with the beginnings of its lists. */
function brief(data) {
  const cut = (_, value) => {
    const isList = Array.isArray(value) || ArrayBuffer.isView(value);
    if (!isList) return value;
    const all = Array.from(/** @type {any} */ (value));
    return all.length > ELEMENTS ? [...all.slice(0, ELEMENTS), `… ${all.length} in all`] : all;
  };
  const words = JSON.stringify(data, cut, 1);
  return words.length > LENGTH ? `${words.slice(0, LENGTH)} …` : words;
}
