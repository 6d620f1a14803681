// @ts-check
// The graph of components: who writes to whom, how often, and which connection has fallen silent.

import { svg, text, className, list } from "./dom.js";
import { layers } from "./layers.js";
import { orphans } from "./findings.js";

const [WIDTH, HEIGHT, COLUMN, ROW] = [158, 44, 240, 66];
/** Distance between components without connections. */
const SPACE = 22;
/** Scale below which the graph is not drawn smaller, but scrolled. */
const SMALLEST = 0.76;
/** Longest label of a connection, in characters. */
const LABEL = 18;

export class Graph {
  /** @param {any} app @param {(name: string) => void} onchoice */
  constructor(app, onchoice) {
    Object.assign(this, { app, onchoice });
    this.edges = svg("g"); this.nodes = svg("g");
    this.root = svg("svg", { class: "diagram graph", role: "img", "aria-label": "Graph of components", preserveAspectRatio: "xMidYMid meet" },
      svg("defs", {}, svg("marker", { id: "arrow", viewBox: "0 0 8 8", refX: 7, refY: 4, markerWidth: 8, markerHeight: 8, markerUnits: "userSpaceOnUse", orient: "auto" }, svg("path", { d: "M0 0 8 4 0 8z", class: "head" }))), this.edges, this.nodes);
    this.shape = "";
  }

  /** The edges: outputs to components, grouped by their ends. */
  links() {
    const { store } = this.app;
    const links = new Map();
    const of = (end) => end.slice(0, end.lastIndexOf("."));
    const waiting = new Map(store.components.flatMap((it) => [...it.inputs, ...it.services].map((end) => [`${it.name}.${end.name}`, end.waiting ?? 0])));
    const add = (from, to, output, input, isCall = false) => {
      if (from === to) return;
      const key = `${from}>${to}`;
      const link = links.get(key) ?? { key, from, to, outputs: new Set(), calls: 0, inputs: new Map() };
      // what waits there has come from any of its writers
      if (waiting.get(input)) link.inputs.set(input, waiting.get(input));
      if (isCall) link.calls++; else link.outputs.add(output);
      links.set(key, link);
    };
    const references = new Set(store.components.flatMap((it) => it.references.map((reference) => `${it.name}.${reference.name}`)));
    const known = new Set(store.components.map((it) => it.name));
    for (const { from, to } of store.presence?.joined ?? []) {
      if (known.has(of(from)) && known.has(of(to))) add(of(from), of(to), from, to, references.has(from));
    }
    for (const topic of store.presence?.topics ?? []) {
      for (const from of topic.publishers) for (const to of topic.subscribers) add(of(from), of(to), from, to);
    }
    return [...links.values()];
  }

  /** @param {string | null} chosen @param {any[]} wanted components that are shown @param {number} most rate up to which connections are shown, Hz */
  draw(chosen, wanted, most) {
    const { store } = this.app;
    const names = wanted.map((it) => it.name);
    const rate = (link) => (link.calls ? 0 : Math.min(...[...link.outputs].map((name) => store.output.get(name)?.hz ?? 0)));
    const links = this.links().filter((it) => names.includes(it.from) && names.includes(it.to) && rate(it) <= most);
    const missing = new Map(orphans(store).map(({ topic, input }) => [input.slice(0, input.lastIndexOf(".")), `nobody publishes on ${topic}`]));
    const shape = JSON.stringify([names, links.map((it) => it.key)]);
    if (shape !== this.shape) { this.shape = shape; this.place(names, links); }
    const key = (it) => it.key;
    this.taken = [...this.at.values()].map(([x, y]) => [x, y, WIDTH / 2, HEIGHT / 2 + 4]);
    list(this.edges, links, key, () => svg("g", { class: "edge" }, svg("title"), svg("path", { "marker-end": "url(#arrow)" }), svg("text"), svg("text", { class: "bytes" })), (edge, it) => this.edge(edge, it, chosen));
    list(this.nodes, wanted, (it) => it.name, (it) => this.make(it.name), (node, it) => {
      const stale = store.outputs.some((output) => output.stale && output.name.startsWith(`${it.name}.`));
      const isUp = it.state === "Running" || it.state === "";
      className(node, `node ${!isUp || stale ? "bad" : ""} ${it.name === chosen ? "chosen" : ""}`);
      const [x, y] = this.at.get(it.name);
      node.setAttribute("transform", `translate(${x} ${y})`);
      const inside = it.name.includes("/") ? it.name.slice(0, it.name.indexOf("/")) : "";
      const asked = it.period_ms ? `each ${it.period_ms} ms` : "event";
      const rate = it.rate_hz > 0 ? `${it.rate_hz.toFixed(0)} Hz` : asked;
      const took = it.cycle_mean_ms ? `  ${it.cycle_mean_ms.toFixed(2)} ms` : "";
      text(node.children[3], isUp ? stale ? `⚠ silent  ${rate}` : `${inside ? `${shortened(inside, 10)} · ` : ""}${rate}${took}` : `⚠ ${it.state}`);
      const held = it.waiting ? `▤ ${it.waiting} for later steps` : "";
      text(node.children[4], missing.has(it.name) ? `○ ${shortened(missing.get(it.name), 26)}` : held);
    });
  }

  make(name) {
    const own = name.slice(name.lastIndexOf("/") + 1);
    const short = shortened(own, 20);
    return svg("g", { class: "node", onclick: () => this.onchoice(name) }, svg("title", {}, name), svg("rect", { x: -WIDTH / 2, y: -HEIGHT / 2, width: WIDTH, height: HEIGHT, rx: 6 }),
      svg("text", { y: -3 }, short), svg("text", { class: "small", y: 12 }), svg("text", { class: "small", y: HEIGHT / 2 + 11 }));
  }

  place(names, links) {
    this.at = new Map();
    let [width, height] = [0, 8];
    const all = parts(names, links);
    for (const part of all.filter((it) => it.length > 1)) {
      const inside = links.filter((it) => part.includes(it.from)).map((it) => /** @type {[string, string]} */ ([it.from, it.to]));
      const placed = layers(part, inside);
      const columns = 1 + Math.max(...[...placed.values()].map((it) => it.layer));
      const most = Math.max(...[...Array(columns).keys()].map((layer) => [...placed.values()].filter((it) => it.layer === layer).length));
      for (const [name, { layer, place }] of placed) this.at.set(name, [10 + WIDTH / 2 + layer * COLUMN, height + place * most * ROW]);
      width = Math.max(width, columns * COLUMN - COLUMN + WIDTH + 20);
      height += most * ROW + 12;
    }
    // components without connections fill rows
    const alone = all.filter((it) => it.length === 1).flat();
    const columns = Math.max(6, Math.floor((width - WIDTH) / (WIDTH + SPACE)) + 1);
    alone.forEach((name, index) => this.at.set(name, [10 + WIDTH / 2 + (index % columns) * (WIDTH + SPACE), height + ROW / 2 + Math.floor(index / columns) * ROW]));
    if (alone.length) width = Math.max(width, Math.min(alone.length, columns) * (WIDTH + SPACE) + 20);
    height += Math.ceil(alone.length / columns) * ROW;
    this.root.setAttribute("viewBox", `0 0 ${width} ${height}`);
    // what does not fit can be scrolled to; it is not made unreadable
    this.root.style.minWidth = `${Math.round(width * SMALLEST)}px`;
    this.root.style.minHeight = `${Math.round(height * SMALLEST)}px`;
  }

  /** A place for a label of this height near this one, where it covers neither a node nor another label. */
  free(x, y, words, height) {
    const half = Math.min(words.length, LABEL) * 3.4 + 2;
    for (let shift = 0; shift < 10; shift++) {
      const row = y + (shift % 2 ? 1 : -1) * Math.ceil(shift / 2) * 12;
      if (this.taken.every(([other, at, width, room]) => Math.abs(at - row) > room || Math.abs(other - x) > half + width)) { this.taken.push([x, row, half, height]); return [x, row]; }
    }
    return [x, y];
  }

  edge(edge, it, chosen) {
    const { store } = this.app;
    const [x, y] = this.at.get(it.from), [tx, ty] = this.at.get(it.to);
    const back = tx <= x;
    const [sx, ex] = back ? [x - WIDTH / 2, tx + WIDTH / 2] : [x + WIDTH / 2, tx - WIDTH / 2];
    const path = tx === x ? `M${x + WIDTH / 2} ${y} C${x + WIDTH / 2 + 40} ${y} ${x + WIDTH / 2 + 40} ${ty} ${x + WIDTH / 2 + 2} ${ty}`
      : back ? `M${sx} ${y + 8} C${sx - 60} ${y + 34} ${ex + 60} ${ty + 34} ${ex + 2} ${ty + 8}` : `M${sx} ${y} C${sx + 44} ${y} ${ex - 44} ${ty} ${ex - 2} ${ty}`;
    const outputs = [...it.outputs].map((name) => store.output.get(name) ?? { name, n: 0, hz: null, age_ms: null, stale: false });
    const broken = outputs.some((output) => output.stale);
    const rate = (hz) => (hz < 1 ? `${(1 / hz).toFixed(0)} s` : `${hz.toFixed(0)} Hz`);
    const age = (output) => { const now = store.age(output.name); return now === null ? ", never" : `, ${(now / 1000).toFixed(1)} s ago`; };
    const words = outputs.map((output) => {
      const port = output.name.slice(output.name.lastIndexOf(".") + 1);
      if (output.stale) return `${port} ⚠ ${((store.age(output.name) ?? 0) / 1000).toFixed(0)} s`;
      return output.hz ? `${port} ${rate(output.hz)}` : port;
    });
    const amount = outputs.reduce((sum, output) => sum + (output.stale ? 0 : traffic(output)), 0);
    const bytes = amount ? perSecond(amount) : "";
    const waiting = [...it.inputs.values()].reduce((sum, count) => sum + count, 0);
    const queue = waiting ? `▤ ${waiting}` : "";
    if (it.calls) words.push("calls");
    text(edge.children[0], `${it.from} → ${it.to}\n${outputs.map((output, index) => `${words[index]}${traffic(output) ? `, ${perSecond(traffic(output))}` : ""}${age(output)}`).join("\n")}${it.calls ? "\ncalls" : ""}${[...it.inputs].map(([input, count]) => `\n${count} waiting at ${input}`).join("")}`);
    edge.children[1].setAttribute("d", path);
    const [label, size] = [edge.children[2], edge.children[3]];
    const onPath = it.from === chosen || it.to === chosen;
    const worst = words.find((it) => it.includes("⚠")) ?? words[0] ?? "";
    const all = words.length > 1 ? `${worst} +${words.length - 1}` : worst;
    const [column, row] = this.free(tx === x ? x + WIDTH / 2 + 30 : (sx + ex) / 2, (y + ty) / 2 - 3 + (back ? 28 : 0), all, bytes || queue ? 20 : 10);
    label.setAttribute("x", String(column));
    label.setAttribute("y", String(row));
    size.setAttribute("x", String(column));
    size.setAttribute("y", String(row + 11));
    // there is no room for both; the bytes are in the title
    text(size, queue || bytes);
    className(size, `bytes ${queue ? "queue" : ""}`);
    text(label, all.length > LABEL ? `${all.slice(0, LABEL - 1)}…` : all);
    className(edge, `edge ${broken ? "broken" : ""} ${queue ? "waits" : ""} ${onPath ? "chosen" : ""}`);
  }
}

/** Bytes per second of an output, as over a bus; 0 if that is not known. */
export function traffic(output) { return (output.hz ?? 0) * (output.bytes ?? 0); }

/** @param {number} bytes per second */
export function perSecond(bytes) {
  for (const unit of ["B/s", "kB/s"]) {
    if (bytes < 999.5) return `${bytes < 9.95 ? bytes.toFixed(1) : bytes.toFixed(0)} ${unit}`;
    bytes /= 1000;
  }
  return `${bytes.toFixed(1)} MB/s`;
}

function shortened(words, most) { return words.length > most ? `${words.slice(0, most - 1)}…` : words; }

/** The connected parts of a graph, the largest first. */
function parts(names, links) {
  const left = new Set(names), all = [];
  while (left.size) {
    const part = new Set([left.values().next().value]);
    for (const name of part) {
      for (const { from, to } of links) {
        if (from === name) part.add(to);
        if (to === name) part.add(from);
      }
    }
    part.forEach((name) => left.delete(name));
    all.push(names.filter((name) => part.has(name)));
  }
  return all.sort((one, other) => other.length - one.length);
}
