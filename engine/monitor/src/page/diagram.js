// @ts-check
// The control-state diagram: drawn from the specification; the present state and the last transition are lit.

import { svg, text, className } from "./dom.js";
import { layers } from "./layers.js";

const HEIGHT = 30, LAYER = 84;

export class Diagram {
  /** @param {any} diagram @param {(line: number) => void} online */
  constructor(diagram, online) {
    this.diagram = diagram;
    this.root = svg("svg", { class: "diagram", role: "img", "aria-label": `Control states of ${diagram.location}`, preserveAspectRatio: "xMidYMid meet" });
    /** @type {Map<string, any>} */ this.nodes = new Map();
    /** @type {any[]} */ this.edges = [];
    this.build(online);
  }

  build(online) {
    const { states, transitions, initial } = this.diagram;
    // transitions that are possible in many states would hide the others: they are drawn as one arrow into their target
    const wide = (it) => it.from.length > 2;
    const narrow = transitions.filter((it) => !wide(it)).flatMap((it) => it.from.map((from) => [from, it.to]));
    // a state that is entered from anywhere follows the initial one
    const entered = transitions.filter((it) => wide(it) && it.to !== initial).map((it) => [initial ?? states[0], it.to]);
    const placed = layers(states, /** @type {any} */ ([...narrow, ...entered]), initial ? [initial] : []);
    const rows = 1 + Math.max(...[...placed.values()].map((it) => it.layer));
    const most = Math.max(...[...Array(rows).keys()].map((row) => [...placed.values()].filter((it) => it.layer === row).length));
    const size = Math.max(78, ...states.map((state) => state.length * 7.4 + 22));
    const [width, height] = [Math.max(460, most * (size + 150)), rows * LAYER];
    this.root.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.root.append(svg("defs", {}, svg("marker", { id: "head", viewBox: "0 0 8 8", refX: 7, refY: 4, markerWidth: 8, markerHeight: 8, markerUnits: "userSpaceOnUse", orient: "auto" }, svg("path", { d: "M0 0 8 4 0 8z", class: "head" }))));
    const at = new Map(states.map((state) => {
      const { layer, place } = placed.get(state);
      return [state, [place * width, LAYER / 2 + layer * LAYER]];
    }));
    const edges = svg("g"), nodes = svg("g");
    this.root.append(edges, nodes);
    this.drawEdges(edges, transitions, at, size, online);
    for (const state of states) {
      const [x, y] = at.get(state);
      const node = svg("g", { class: "node" }, svg("rect", { x: x - size / 2, y: y - HEIGHT / 2, width: size, height: HEIGHT, rx: 8 }), svg("text", { x, y }, state),
        svg("text", { class: "count", x: x + size / 2 - 4, y: y + HEIGHT / 2 + 9 }));
      if (state === initial) node.prepend(svg("circle", { class: "head", cx: x - size / 2 - 9, cy: y, r: 4 }));
      nodes.append(node);
      this.nodes.set(state, node);
    }
  }

  drawEdges(place, transitions, at, size, online) {
    const groups = new Map();
    for (const it of transitions) {
      const wide = it.from.length > 2;
      for (const from of wide ? [null] : it.from) {
        const key = `${from}>${it.to}`;
        const group = groups.get(key) ?? { from, to: it.to, all: [], sources: new Set() };
        group.all.push(it);
        it.from.forEach((state) => group.sources.add(state));
        groups.set(key, group);
      }
    }
    const wideInto = new Map();
    /** Places of labels, none of which may cover another. @type {number[][]} */ const taken = [];
    const free = ([x, y], words) => {
      const half = words.length * 3 + 3;
      for (let shift = 0; shift < 8; shift++) {
        const row = y + (shift % 2 ? 1 : -1) * Math.ceil(shift / 2) * 12;
        if (taken.every(([other, at, width]) => Math.abs(at - row) > 11 || Math.abs(other - x) > half + width)) { taken.push([x, row, half]); return [x, row]; }
      }
      return [x, y];
    };
    for (const [x, y] of at.values()) taken.push([x, y + 4, size / 2], [x, y - 8, size / 2]);
    for (const group of groups.values()) {
      const { from, to, all } = group;
      const guards = all.map((it) => (it.guards.at(-1) ?? "always"));
      const label = shortened([...new Set(guards)].join(" | "));
      const hint = all.map((it) => `${it.from.join(", ")} → ${it.to}${it.guards.length ? `\nif ${it.guards.join("\nand ")}` : ""}\nline ${it.line}`).join("\n\n");
      let path, mid;
      if (from === null) {
        const count = wideInto.get(to) ?? 0;
        wideInto.set(to, count + 1);
        const [x, y] = at.get(to);
        const [sx, sy] = [x + size / 2 + 34, y - 20 + 14 * count];
        path = `M${sx} ${sy} L${x + size / 2 + 2} ${y - 5 + 8 * count}`;
        mid = [sx + 3, sy - 3];
      } else [path, mid] = curve(at.get(from), at.get(to), size, groups.has(`${to}>${from}`));
      const words = from === null ? `any: ${label}` : label;
      mid = free(mid, words);
      const edge = svg("g", { class: `edge ${from === null ? "wide" : ""}`, onclick: () => online(all[0].line) }, svg("title", {}, hint),
        svg("path", { d: path, "marker-end": "url(#head)" }), svg("text", { x: mid[0], y: mid[1] }, words));
      place.append(edge);
      this.edges.push({ element: edge, wide: from === null, from: group.sources, to });
    }
  }

  /** @param {string | undefined} now @param {{ before: string, after: string } | undefined} last @param {Map<string, number>} counts */
  draw(now, last, counts) {
    for (const [state, node] of this.nodes) {
      const before = last && last.before === state && state !== now;
      className(node, `node ${state === now ? "now" : before ? "before" : counts.get(state) ? "" : "unseen-yet"}`);
      text(node.querySelector(".count"), counts.get(state) ? `${counts.get(state)}×` : "");
    }
    const lit = last && this.edges.filter((it) => it.to === last.after && it.from.has(last.before));
    const best = lit?.find((it) => !it.wide) ?? lit?.[0];
    for (const it of this.edges) className(it.element, `edge ${it.wide ? "wide" : ""} ${it === best ? "lit" : ""}`);
  }
}

function shortened(label) { return label.length > 26 ? `${label.slice(0, 25)}…` : label; }

/** A path between two nodes, and the place of its label. */
function curve([x, y], [tx, ty], size, both) {
  if (x === tx && y === ty) return [`M${x + size / 2} ${y + 6} c26 12 26 -24 1 -14`, [x + size / 2 + 40, y + 22]];
  const shift = both ? 10 : 0;
  if (ty > y) {
    const [sx, ex] = [x + shift, tx + shift];
    return [`M${sx} ${y + HEIGHT / 2} C${sx} ${y + 42} ${ex} ${ty - 42} ${ex} ${ty - HEIGHT / 2 - 1}`, [(sx + ex) / 2, (y + ty) / 2 + 3]];
  }
  if (ty === y) {
    const side = tx > x ? 1 : -1;
    const [sx, ex] = [x + side * size / 2, tx - side * size / 2];
    return [`M${sx} ${y} C${sx + side * 20} ${y - 14} ${ex - side * 20} ${y - 14} ${ex} ${y}`, [(sx + ex) / 2, y - 15]];
  }
  // upwards, round the side
  const side = x >= tx ? 1 : -1;
  const [sx, ex] = [x - side * size / 2, tx - side * size / 2];
  const bend = Math.min(sx * side, ex * side) * side - side * 46;
  return [`M${sx} ${y} C${bend} ${y} ${bend} ${ty} ${ex - side * 1} ${ty}`, [(sx + ex) / 8 + bend * 0.75, (y + ty) / 2]];
}
