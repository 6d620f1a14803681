// @ts-check
// Components: rates, ages, broken connections in words, properties and the life cycle.

import { el, panel, text, className, list, fixed } from "./dom.js";
import { findings } from "./store.js";
import { Graph } from "./graph.js";

const TRANSITIONS = ["configure", "start", "stop", "cleanup", "recover", "reset"];
const COLUMNS = ["component", "state", "period, ms", "measured, ms", "mean, ms", "max, ms", "overruns", "lost"];

export class Components {
  constructor(app) {
    this.app = app;
    this.chosen = null;
    this.findings = el("div", { class: "body findings", id: "findings" });
    this.body = el("tbody");
    const head = el("tr", {}, COLUMNS.map((name, index) => el("th", { class: `${index > 1 ? "number" : ""} ${[4, 5].includes(index) ? "optional" : ""}` }, name)));
    this.graph = new Graph(app, (name) => this.choose(name));
    this.title = el("strong");
    this.detail = el("div", { class: "body detail" });
    this.root = el("div", { class: "grid components" },
      panel("Findings", "findings-panel", [], this.findings), panel("Connections", "graph-panel", [el("span", { class: "faint" }, "click a component")], el("div", { class: "body" }, this.graph.root)),
      panel("Components", "table-panel", [], el("div", { class: "body" }, el("table", { id: "components" }, el("thead", {}, head), this.body))), panel("Detail", "detail-panel", [this.title], this.detail));
    this.parts = null;
  }

  streams() { return []; }

  choose(name) {
    this.chosen = name;
    this.parts = null;
    this.app.redraw();
  }

  draw(now, texts) {
    if (!texts) return;
    const { store } = this.app;
    this.chosen ??= store.system.specifications[0]?.component ?? store.components[0]?.name ?? null;
    const found = findings(store);
    const shown = found.length ? found : [{ level: "fine", text: store.components.length ? "All components run, and no regular output is silent." : "Waiting for the first description of the components." }];
    list(this.findings, shown, (it) => it.text.replace(/[\d.]+/g, ""), () => el("p"), (row, it) => { className(row, it.level); text(row, it.text); });
    list(this.body, store.components, (it) => it.name, (it) => this.make(it.name), (row, it) => this.update(row, it));
    if (store.components.length) this.graph.draw(this.chosen);
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
    const stale = this.app.store.outputs.filter((output) => output.stale && output.name.startsWith(`${it.name}.`));
    const oldest = Math.max(0, ...stale.map((output) => output.age_ms));
    const running = it.state === "Running";
    text(state.firstChild, stale.length && running ? `stale ${(oldest / 1000).toFixed(0)} s` : it.state);
    className(state.firstChild, `badge ${!running ? "bad" : stale.length ? "stale" : "good"}`);
    text(period, it.period_ms ? String(it.period_ms) : "event");
    text(measured, it.rate_hz > 0 ? fixed(1000 / it.rate_hz, 1) : "–");
    text(mean, fixed(it.cycle_mean_ms, 3));
    text(max, fixed(it.cycle_max_ms, 3));
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
    for (const [transition, button] of Object.entries(buttons)) {
      button.disabled = !control.armed;
      button.title = control.armed ? `${transition} ${it.name}` : control.reason;
    }
    for (const [name, row] of ports) this.port(row, name, it);
    for (const [name, value] of it.properties) {
      const field = properties.get(name);
      field.input.disabled = field.button.disabled = !control.armed;
      field.button.title = control.reason;
      if (document.activeElement !== field.input && !field.edited) field.input.value = JSON.stringify(value);
    }
  }

  port(row, name, component) {
    const { store } = this.app;
    const output = store.output.get(name);
    const [, rate, age] = row.children;
    const input = component.inputs.find((port) => `${component.name}.${port.name}` === name);
    text(rate, output?.hz ? `${output.hz.toFixed(1)} Hz` : input?.lost ? `${input.lost} lost` : "–");
    const now = store.age(name);
    text(age, now === null ? (input ? "" : "never") : `${(now / 1000).toFixed(1)} s`);
    className(row, output?.stale ? "stale" : "");
  }

  build(it, shape) {
    const { app } = this;
    const described = app.store.system.components.find((known) => known.name === it.name);
    const buttons = Object.fromEntries(TRANSITIONS.map((transition) => [transition, el("button", { type: "button", onclick: () => app.control.wish(it.name, transition, `${transition} ${it.name}`) }, transition)]));
    const ports = new Map();
    const table = (list, head) => {
      const rows = list.map((port) => {
        const row = el("tr", {}, el("td", {}, el("code", {}, port.name), " ", el("span", { class: "faint" }, port.type)), el("td", { class: "number" }), el("td", { class: "number" }));
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
    this.parts = { shape, buttons, ports, properties };
    this.detail.replaceChildren(
      el("div", { class: "bar faint mono" }, described?.implementation ?? ""), el("div", { class: "bar" }, Object.values(buttons)),
      ...table(it.outputs, "outputs: rate, age"), ...table(it.inputs, "inputs"),
      ...(services.length ? [el("h3", {}, "services"), ...services.map((line) => el("div", { class: "service mono" }, line))] : []),
      ...(rows.length ? [el("h3", {}, "properties"), el("table", {}, el("tbody", {}, rows))] : []));
  }
}
