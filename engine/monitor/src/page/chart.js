// @ts-check
// A chart of values over time, drawn by uPlot: the value at the pointer, the time that all views show, and ranges to look into.

import uPlot from "./vendor/uPlot.esm.js";
import { el, colour, text } from "./dom.js";
import { Folding } from "./folding.js";

/** Distance between two points from which the line between them is not drawn, s. */
const GAP = 1.5;
/** Width of the labels of an axis, and the margin at the right, px. */
export const [LABELS, MARGIN] = [58, 18];
/** Share of the range between two limits from which the nearer one is shown. */
const NEAR = 0.2;
/** Charts under one pointer have one crosshair. */
const CROSSHAIR = uPlot.sync("asmotion");

/** @typedef {{ name: string, points: [number, number | null][], shade: string, stepped?: boolean, dash?: number[] }} Series */

export class Chart {
  /** @param {any} app @param {string} title @param {string} unit @param {{ labels?: number, names?: string[] | null }} [options]
   * `labels` is the width of the vertical axis, `names` those of the values 0, 1, … of a series that has no numbers. */
  constructor(app, title, unit, options = {}) {
    Object.assign(this, { app, title, unit, options });
    this.now = el("span", { class: "now" });
    this.place = el("div", { class: "plot", tabindex: 0, role: "img", "aria-label": `${title} over time; arrow keys move the shown time` });
    this.root = el("section", { class: "panel chart", "aria-label": title }, el("div", { class: "head" }, el("h2", {}, title, unit ? el("span", { class: "unit" }, `, ${unit}`) : null), el("span", { class: "grow" }), this.now), this.place);
    this.place.addEventListener("keydown", (event) => this.key(event));
    /** @type {any} */ this.plot = null;
    this.kind = "";
    /** @type {[number, number]} */ this.size = [0, 0];
    /** @type {[number, number]} */ this.range = [0, 1];
    this.isPressed = false;
    /** @type {Series[]} */ this.series = [];
    /** @type {[number, boolean][]} */ this.marks = [];
    /** @type {[number, number] | null} */ this.limits = null;
    this.folding = new Folding(0, 1);
  }

  /** @param {Series[]} series @param {number} begin @param {number} end
   * @param {{ marks?: [number, boolean][], folding?: Folding, limits?: [number, number] | null }} [more] `marks` are times at which
   * something was raised, or cleared again; `folding` is the axis of time; `limits` are the least and the greatest value that are fine */
  draw(series, begin, end, { marks = [], folding = new Folding(begin, end), limits = null } = {}) {
    const [width, height] = [this.place.clientWidth, this.place.clientHeight];
    if (!width || !height) return;
    Object.assign(this, { series, marks, range: [begin, end], folding, limits });
    const kind = JSON.stringify([series.map((it) => [it.name, it.shade, it.stepped, it.dash]), this.options, document.documentElement.dataset.theme]);
    if (kind !== this.kind) { this.kind = kind; this.build(width, height); }
    if (width !== this.size[0] || height !== this.size[1]) { this.size = [width, height]; this.plot.setSize({ width, height }); }
    this.plot.batch(() => {
      const [times, ...values] = aligned(series.map((it) => within(it, begin, end)));
      this.plot.setData([times.map((t) => folding.to(t)), ...values], false);
      this.plot.setScale("x", { min: 0, max: Math.max(folding.length, 1e-3) });
      // the extent is that of what is shown
      this.plot.setScale("y", { min: null, max: null });
    });
    this.head();
  }

  build(width, height) {
    this.plot?.destroy();
    this.size = [width, height];
    const axis = { stroke: colour("faint"), font: "11px sans-serif", grid: { stroke: colour("line"), width: 1 }, ticks: { show: false } };
    const { names, labels } = this.options;
    const options = {
      width, height, padding: [8, MARGIN, 0, 0], legend: { show: false }, scales: { x: { time: false }, y: { range: (_, low, high) => this.extent(low, high) } },
      axes: [
        { ...axis, size: 24, gap: 2, space: 64, splits: (_, __, low, high, step) => this.ticks(low, high, step), values: (_, positions) => positions.map((it) => this.folding.from(it)).map((t) => (t < -1e-9 ? "" : `${Number(t.toFixed(2))} s`)) },
        { ...axis, size: labels ?? LABELS, gap: 4, ...(names ? { splits: names.map((_, index) => index), values: names.map((name) => (name.length > 10 ? `${name.slice(0, 9)}…` : name)) } : { values: (_, values) => values.map((it) => (it === null ? "" : String(Number(it.toPrecision(6))))) }) },
      ],
      series: [{}, ...this.series.map((it) => ({ label: it.name, stroke: colour(it.shade), width: 1.6, dash: it.dash, spanGaps: this.series.length > 1, paths: it.stepped ? uPlot.paths.stepped({ align: 1 }) : undefined, points: { show: it.stepped ? undefined : false } }))],
      cursor: { y: false, sync: { key: CROSSHAIR.key, setSeries: false }, drag: { x: true, y: false, setScale: false, dist: 6 }, points: { size: 6 } },
      hooks: { drawClear: [(plot) => this.bands(plot)], draw: [(plot) => { this.drawMarks(plot); this.cursor(plot); }], setCursor: [() => this.head()], setSelect: [(plot) => this.selected(plot)] },
    };
    this.place.replaceChildren();
    this.plot = new uPlot(options, [[], ...this.series.map(() => [])], this.place);
    let from = 0;
    this.plot.over.addEventListener("pointerdown", (event) => { from = event.clientX; this.isPressed = true; });
    this.plot.over.addEventListener("click", (event) => {
      if (Math.abs(event.clientX - from) < 6 && this.plot.cursor.left >= 0) this.app.seek(this.timeAt(this.plot.cursor.left));
    });
  }

  /** The time at a column of the plot. @param {number} left */
  timeAt(left) { return this.folding.from(this.plot.posToVal(left, "x")); }

  /** Positions of the labels of the axis: round times that are not folded. */
  ticks(low, high, step) {
    const [from, to] = [this.folding.from(low), this.folding.from(high)];
    const ticks = [];
    for (let t = Math.ceil(from / step - 1e-6) * step; t <= to + 1e-9; t += step) if (!this.folding.hides(t)) ticks.push(this.folding.to(t));
    return ticks;
  }

  /** Called when the chart is not shown any more. */
  destroy() {
    this.plot?.destroy();
    this.root.remove();
  }

  /** The extent of the values, with some air. */
  extent(low, high) {
    const { names } = this.options;
    if (names) return [-0.4, names.length - 0.6];
    if (!Number.isFinite(low) || !Number.isFinite(high)) [low, high] = [0, 1];
    const air = (high - low || Math.abs(high) * 0.1 || 1) * 0.08;
    let [least, most] = [low - air, high + air];
    if (this.limits) {
      // a limit is shown before the values come to it
      const near = (this.limits[1] - this.limits[0]) * NEAR;
      if (low < this.limits[0] + near) least = Math.min(least, this.limits[0] - air);
      if (high > this.limits[1] - near) most = Math.max(most, this.limits[1] + air);
    }
    return [least, most];
  }

  /** What lies beyond the limits: shaded, up to a dashed line. */
  bands(plot) {
    if (!this.limits) return;
    const { ctx, bbox } = plot;
    const bottom = bbox.top + bbox.height, rows = this.limits.map((value) => plot.valToPos(value, "y", true));
    const [low, high] = rows.map((row) => Math.min(bottom, Math.max(bbox.top, row)));
    ctx.save();
    ctx.fillStyle = colour("bad-soft");
    ctx.strokeStyle = colour("bad");
    ctx.setLineDash([6, 4]);
    for (const [from, to, edge] of [[bbox.top, high, rows[1]], [low, bottom, rows[0]]]) {
      if (to - from < 1) continue;
      ctx.fillRect(bbox.left, from, bbox.width, to - from);
      if (edge < bbox.top || edge > bottom) continue;
      ctx.beginPath(); ctx.moveTo(bbox.left, edge); ctx.lineTo(bbox.left + bbox.width, edge); ctx.stroke();
    }
    ctx.restore();
  }

  /** A range was selected: all views show it. Charts under one crosshair all learn of it, and the others may show another time. */
  selected(plot) {
    const { left, width } = plot.select;
    if (width < 6) return;
    const isOwn = this.isPressed;
    this.isPressed = false;
    if (!isOwn) return plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    const [from, to] = [this.timeAt(left), this.timeAt(left + width)];
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.app.zoom([from, to]);
  }

  key(event) {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!by || event.ctrlKey || event.metaKey || event.altKey) return;
    const times = this.series[0]?.points.map(([t]) => t) ?? [];
    const shown = this.app.store.cursor ?? times.at(-1) ?? 0;
    const next = by < 0 ? times.findLast((t) => t < shown - 1e-9) : times.find((t) => t > shown + 1e-9);
    if (next !== undefined) this.app.seek(next);
    event.preventDefault();
    event.stopPropagation();
  }

  /** Marks at the upper edge: filled where something was raised, hollow where it was cleared. */
  drawMarks(plot) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.fillStyle = ctx.strokeStyle = colour("bad");
    ctx.lineWidth = 1.5;
    for (const [t, isRaised] of this.marks) {
      if (t < this.range[0] || t > this.range[1]) continue;
      const column = plot.valToPos(this.folding.to(t), "x", true), row = bbox.top, size = 5 * devicePixelRatio;
      ctx.beginPath(); ctx.moveTo(column - size, row); ctx.lineTo(column + size, row); ctx.lineTo(column, row + 1.6 * size); ctx.closePath();
      if (isRaised) ctx.fill(); else ctx.stroke();
    }
    ctx.restore();
  }

  /** The time that all views show. */
  cursor(plot) {
    const t = this.app.store.cursor;
    if (t === null || t < this.range[0] || t > this.range[1]) return;
    const { ctx, bbox } = plot;
    const column = Math.round(plot.valToPos(this.folding.to(t), "x", true)) + 0.5;
    ctx.save();
    ctx.strokeStyle = colour("note");
    ctx.lineWidth = 2;
    ctx.beginPath(); ctx.moveTo(column, bbox.top); ctx.lineTo(column, bbox.top + bbox.height); ctx.stroke();
    ctx.restore();
  }

  /** Values at the pointer, at the shown time, or the newest ones. */
  head() {
    const left = this.plot?.cursor.left ?? -10;
    const t = left >= 0 ? this.timeAt(left) : this.app.store.cursor;
    const words = this.series.map((it) => {
      const found = t === null ? it.points.at(-1) : at(it, t);
      const value = found?.[1] ?? null;
      const shown = value === null ? "–" : this.options.names?.[value] ?? String(Number(value.toPrecision(5)));
      return this.series.length > 1 ? `${it.name} ${shown}` : shown;
    });
    text(this.now, words.join("  ") + (left >= 0 && t !== null ? `  at ${t.toFixed(2)} s` : ""));
  }
}

/** The point of a series at a time: the newest one up to then if a value holds until the next one, otherwise the nearest one. @param {Series} series @param {number} t */
function at({ points, stepped }, t) {
  const index = points.findLastIndex(([time]) => time <= t + 1e-9);
  const next = points[index + 1];
  return !stepped && next && (index < 0 || next[0] - t < t - points[index][0]) ? next : points[index];
}

/** The points in a range, with the ones next to it, so that a line leaves it. */
function within(series, begin, end) {
  const { points } = series;
  let from = points.findIndex(([t]) => t >= begin);
  if (from < 0) from = points.length;
  let to = points.findLastIndex(([t]) => t <= end);
  from = Math.max(0, from - 1);
  to = Math.min(points.length - 1, to + 1);
  const [times, values] = [[], []];
  for (let index = from; index <= to; index++) {
    const [t, value] = points[index];
    const before = times.length ? times[times.length - 1] : t;
    // a gap is shown as a gap
    if (!series.stepped && t - before > GAP) { times.push((before + t) / 2); values.push(null); }
    times.push(t);
    values.push(value);
  }
  return [times, values];
}

function aligned(tables) {
  if (tables.length === 0) return [[]];
  return tables.length === 1 ? tables[0] : uPlot.join(tables);
}
