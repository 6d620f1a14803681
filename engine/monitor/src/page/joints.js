// @ts-check
// Joints: the status of all joints, a chart for each, and the period of the driver.

import { el, panel, text, className, list, fixed } from "./dom.js";
import { Chart } from "./chart.js";

const TYPE = "youbot/JointStatus";
const SIGNALS = [["position", "rad"], ["velocity", "rad/s"], ["current", "A"], ["temperature", "°C"]];
const DRAW = 50;

export class Joints {
  constructor(app) {
    this.app = app;
    this.chosen = "all"; this.signal = "position"; this.span = 30; this.last = 0;
    this.output = null;
    this.tabs = el("div", { class: "bar", role: "tablist", "aria-label": "Joints" });
    this.select = el("select", { "aria-label": "Signal of all joints", onchange: () => { this.signal = this.select.value; this.build(); } }, SIGNALS.map(([name]) => el("option", {}, name)));
    /** The arm, if there are several: the output with its status. */
    this.arms = el("select", { id: "arm", "aria-label": "Arm", onchange: () => { this.period.value = ""; app.redraw(); } });
    this.spans = el("select", { "aria-label": "Shown time", onchange: () => { this.span = Number(this.spans.value); app.range = null; app.redraw(); } }, [10, 30, 60, 120].map((it) => el("option", { value: it, selected: it === 30 }, `${it} s`)));
    this.period = el("input", { id: "period", size: 6, inputmode: "decimal", value: "", "aria-label": "Period of the driver, ms" });
    this.apply = el("button", { type: "button", id: "apply", class: "primary", onclick: () => this.setPeriod() }, "Apply");
    this.period.addEventListener("keydown", (event) => { if (event.key === "Enter") this.setPeriod(); });
    this.measured = el("strong", { class: "mono", id: "measured" });
    this.badge = el("span", { class: "badge good", id: "age" });
    this.body = el("tbody");
    this.charts = el("div", { class: "charts" });
    const head = el("tr", {}, ["joint", ...SIGNALS.map(([name, unit]) => `${name}, ${unit}`), "flags"].map((name, index) => el("th", { class: index && index < 5 ? "number" : "" }, name)));
    const control = app.store.recording ? [] : [el("label", {}, "driver period, ms ", this.period), this.apply];
    const driver = [this.arms, this.badge, el("span", { class: "grow" }), ...control, el("span", {}, "measured ", this.measured)];
    this.empty = el("p", { class: "empty" }, "No output of the type youbot/JointStatus has written anything.");
    this.root = el("div", { class: "grid joints" }, panel("Joints", "joints-panel", driver, this.empty, el("div", { class: "body" }, el("table", { id: "joints" }, el("thead", {}, head), this.body))),
      el("div", { class: "bar" }, this.tabs, this.select, this.spans, el("span", { class: "faint" }, "click: all views show this time · drag: a range"), el("button", { type: "button", onclick: () => this.export() }, "CSV of what is shown"), app.store.recording ? null : el("button", { type: "button", onclick: () => this.clear() }, "Clear history")), this.charts);
  }

  streams() { return []; }

  /** The input of the driver that takes its period in seconds. */
  get periodPort() {
    const component = this.output?.slice(0, this.output.lastIndexOf("."));
    const found = this.app.store.components.find((it) => it.name === component);
    return found?.inputs.some((port) => port.name === "period" && port.type === "std_msgs/Float64") ? component : null;
  }

  /** The least and the greatest value of a signal of a joint that are fine, from the driver's property `SIGNAL_limits`: a pair for each
   * joint, or one for all of them. @param {string} signal @param {number} joint @returns {[number, number] | null} */
  limits(signal, joint) {
    const component = this.output?.slice(0, this.output.lastIndexOf("."));
    const properties = this.app.store.components.find((it) => it.name === component)?.properties ?? [];
    const pairs = properties.find(([name]) => name === `${signal}_limits`)?.[1];
    const pair = Array.isArray(pairs) ? (pairs.length === 1 ? pairs[0] : pairs[joint]) : null;
    return Array.isArray(pair) && pair.length === 2 && pair.every(Number.isFinite) ? /** @type {[number, number]} */ (pair) : null;
  }

  async setPeriod() {
    const milliseconds = Number(this.period.value);
    if (!Number.isFinite(milliseconds) || milliseconds < 1 || milliseconds > 10000) return this.app.control.say(`period ${this.period.value} ms: expected 1 to 10000`, true);
    await this.app.control.wish(this.periodPort, { write: ["period", { data: milliseconds / 1000 }] }, `driver period ${milliseconds} ms`);
  }

  clear() { this.app.store.series.clear(); this.app.redraw(); }

  /** Saves what the charts show as a table. */
  export() {
    const { store } = this.app;
    const samples = this.shown();
    const columns = SIGNALS.flatMap(([name]) => (samples[0]?.[name] ?? []).map((_, joint) => `${name}${joint + 1}`));
    const rows = samples.map((it) => [it.t, ...SIGNALS.flatMap(([name]) => [...it[name]])].join(","));
    const link = el("a", { href: URL.createObjectURL(new Blob([[`t,${columns.join(",")}`, ...rows].join("\n") + "\n"], { type: "text/csv" })), download: "joints.csv" });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  shown() {
    const [begin, end] = this.app.shown(this.span);
    return (this.app.store.series.get(this.output) ?? []).filter((it) => it.t >= begin && it.t <= end);
  }

  build() {
    const joints = this.count ?? 0;
    const names = ["all", ...Array.from({ length: joints }, (_, index) => String(index + 1))];
    this.tabs.replaceChildren(...names.map((name) => el("button", { type: "button", role: "tab", "aria-selected": String(name === this.chosen), "aria-pressed": String(name === this.chosen), onclick: () => { this.chosen = name; this.build(); this.app.redraw(); } }, name === "all" ? "All joints" : `Joint ${name}`)));
    this.select.hidden = this.chosen !== "all";
    const unit = Object.fromEntries(SIGNALS);
    for (const it of this.drawn ?? []) it.chart.destroy();
    this.drawn = this.chosen === "all"
      ? Array.from({ length: joints }, (_, joint) => ({ joint, signal: this.signal, chart: new Chart(this.app, `Joint ${joint + 1} ${this.signal}`, unit[this.signal]) }))
      : SIGNALS.map(([signal]) => ({ joint: Number(this.chosen) - 1, signal, chart: new Chart(this.app, `Joint ${this.chosen} ${signal}`, unit[signal]) }));
    this.charts.replaceChildren(...this.drawn.map((it) => it.chart.root));
  }

  draw(now, texts) {
    const { store } = this.app;
    const arms = store.ofType(TYPE);
    list(this.arms, arms, (it) => it, (it) => el("option", { value: it }, it.slice(0, it.lastIndexOf("."))), () => {});
    this.arms.hidden = arms.length < 2;
    const output = arms.includes(this.arms.value) ? this.arms.value : arms[0] ?? null;
    // the charts of another arm are others
    if (output !== this.output) { this.output = output; this.count = 0; }
    const sample = this.output && store.samples.get(this.output);
    this.empty.hidden = !!sample;
    if (!sample) return;
    if (this.count !== sample.data.position.length) { this.count = sample.data.position.length; this.build(); }
    if (texts) this.table(sample);
    if (now - this.last < DRAW && !texts) return;
    this.last = now;
    const [begin, end] = this.app.shown(this.span);
    // samples of a recording are asked for as far as they are shown
    this.app.span = Math.max(this.span, end - begin) * 1.3;
    const samples = store.series.get(this.output) ?? [];
    for (const { joint, signal, chart } of this.drawn) {
      const points = samples.map((it) => [it.t, it[signal][joint]]);
      chart.draw([{ name: signal, points, shade: `serie-${joint % 6}` }], begin, end, { marks: raised(samples, joint), limits: this.limits(signal, joint) });
    }
  }

  table(sample) {
    const { store, control } = this.app;
    const at = store.cursor === null ? sample.data : (store.series.get(this.output) ?? []).findLast((it) => it.t <= store.cursor) ?? sample.data;
    const rows = Array.from({ length: this.count }, (_, joint) => ({ joint, data: at }));
    const stale = store.isStale(this.output);
    list(this.body, rows, (it) => String(it.joint), () => el("tr", {}, Array.from({ length: 6 }, (_, index) => el("td", { class: index && index < 5 ? "number" : "" }))), (row, { joint, data }) => {
      text(row.children[0], `joint ${joint + 1}`);
      SIGNALS.forEach(([name], index) => {
        const [value, limits] = [data[name][joint], this.limits(name, joint)];
        const beyond = limits && (value < limits[0] || value > limits[1]);
        text(row.children[index + 1], `${beyond ? "⚠ " : ""}${fixed(value, 3)}`);
        row.children[index + 1].title = limits ? `fine from ${fixed(limits[0], 3)} to ${fixed(limits[1], 3)}` : "";
      });
      const flags = data.error_flags[joint];
      const bits = [...Array(16).keys()].filter((bit) => flags & (1 << bit));
      text(row.children[5], bits.length ? `⚠ error bit ${bits.join(", ")}` : "✓ none");
      className(row, stale ? "stale" : "");
    });
    const output = store.output.get(this.output);
    const age = (store.age(this.output) ?? 0) / 1000;
    text(this.badge, stale ? `⚠ stale ${age.toFixed(1)} s` : `● ${output?.hz?.toFixed(1) ?? "–"} Hz`);
    className(this.badge, `badge ${stale ? "stale" : "good"}`);
    text(this.measured, stale || !output?.hz ? "–" : `${fixed(1000 / output.hz, 1)} ms`);
    const component = store.components.find((it) => this.output.startsWith(`${it.name}.`));
    if (this.period.value === "" && component?.period_ms) this.period.value = String(component.period_ms);
    this.apply.disabled = this.period.disabled = !control.armed || !this.periodPort;
    this.apply.title = control.armed ? (this.periodPort ? "Sets the period from the next cycle on" : "This driver has no input for its period") : control.reason;
  }
}

/** Times at which the flags of a joint change, and whether any is raised then. @returns {[number, boolean][]} */
function raised(samples, joint) {
  const changes = [];
  let before = samples[0]?.error_flags[joint] ?? 0;
  for (const it of samples) {
    const flags = it.error_flags[joint];
    if (flags !== before) changes.push([it.t, flags !== 0]);
    before = flags;
  }
  return changes;
}
