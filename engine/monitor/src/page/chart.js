// @ts-check
// A chart of a few series over time, with the value under the pointer and the time that all views show.

import { el, fitted, colour, text } from "./dom.js";

const [LEFT, RIGHT, TOP, BOTTOM] = [52, 10, 8, 20];

export class Chart {
  /** @param {any} app @param {string} title @param {string} unit */
  constructor(app, title, unit) {
    Object.assign(this, { app, title, unit });
    this.canvas = el("canvas", { role: "img", "aria-label": `${title} over time` });
    this.now = el("span", { class: "now" });
    this.hover = null;
    this.root = el("section", { class: "panel chart", "aria-label": title }, el("div", { class: "head" }, el("h2", {}, `${title}, ${unit}`), el("span", { class: "grow" }), this.now), el("div", { class: "plot" }, this.canvas));
    this.canvas.addEventListener("pointermove", (event) => { this.hover = event.clientX - this.canvas.getBoundingClientRect().left; app.redraw(); });
    this.canvas.addEventListener("pointerleave", () => { this.hover = null; });
    this.canvas.addEventListener("click", () => { if (this.hover !== null) app.seek(this.timeAt(this.hover)); });
  }

  timeAt(column) { return this.end - this.span + (column - LEFT) / (this.width - LEFT - RIGHT) * this.span; }

  /** @param {{ name: string, points: [number, number][], shade: string }[]} series @param {number} end @param {number} span @param {[number, number] | null} limits */
  draw(series, end, span, limits = null) {
    const { context, width, height } = fitted(this.canvas);
    if (!width || !height) return;
    Object.assign(this, { width, height, end, span });
    const shown = series.map((it) => ({ ...it, points: it.points.filter(([t]) => t >= end - span && t <= end) }));
    const values = shown.flatMap((it) => it.points.map(([, value]) => value)).filter(Number.isFinite);
    let [low, high] = [Math.min(...values), Math.max(...values)];
    if (!values.length) [low, high] = [0, 1];
    if (limits) [low, high] = [Math.min(low, limits[0]), Math.max(high, limits[1])];
    const pad = (high - low || Math.abs(high) * 0.1 || 1) * 0.08;
    [low, high] = [low - pad, high + pad];
    const x = (t) => LEFT + (t - end + span) / span * (width - LEFT - RIGHT);
    const y = (value) => height - BOTTOM - (value - low) / (high - low) * (height - TOP - BOTTOM);
    context.fillStyle = colour("panel");
    context.fillRect(0, 0, width, height);
    this.scales(context, x, y, low, high);
    context.save();
    context.beginPath(); context.rect(LEFT, 0, width - LEFT - RIGHT, height); context.clip();
    for (const it of shown) {
      context.strokeStyle = colour(it.shade);
      context.lineWidth = 1.6;
      context.beginPath();
      let last = null;
      for (const [t, value] of it.points) {
        // a gap is shown as a gap
        if (last === null || t - last > 1.5) context.moveTo(x(t), y(value)); else context.lineTo(x(t), y(value));
        last = t;
      }
      context.stroke();
    }
    const cursor = this.hover !== null ? this.timeAt(this.hover) : this.app.store.cursor;
    if (cursor !== null) {
      context.strokeStyle = colour("note");
      context.lineWidth = 1;
      context.beginPath(); context.moveTo(x(cursor), 0); context.lineTo(x(cursor), height - BOTTOM); context.stroke();
    }
    context.restore();
    const at = (points) => (cursor === null ? points.at(-1) : points.findLast(([t]) => t <= cursor));
    text(this.now, shown.map((it) => `${shown.length > 1 ? `${it.name} ` : ""}${at(it.points)?.[1].toFixed(3) ?? "–"}`).join("  "));
  }

  scales(context, x, y, low, high) {
    context.font = "11px sans-serif";
    context.fillStyle = colour("faint");
    context.strokeStyle = colour("line");
    context.lineWidth = 1;
    const step = nice((high - low) / 4);
    context.textAlign = "right"; context.textBaseline = "middle";
    for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
      const row = Math.round(y(value)) + 0.5;
      context.beginPath(); context.moveTo(LEFT, row); context.lineTo(this.width - RIGHT, row); context.stroke();
      context.fillText(String(Number(value.toPrecision(6))), LEFT - 6, row);
    }
    context.textAlign = "center"; context.textBaseline = "alphabetic";
    const every = nice(this.span / 8);
    for (let t = Math.ceil((this.end - this.span) / every) * every; t <= this.end; t += every) {
      if (t < 0) continue;
      context.fillText(`${Number(t.toFixed(1))} s`, x(t), this.height - 5);
    }
  }
}

/** The next larger 1, 2 or 5 times a power of ten. */
function nice(value) {
  const power = 10 ** Math.floor(Math.log10(value || 1));
  return [1, 2, 5, 10].map((it) => it * power).find((it) => it >= value) ?? 10 * power;
}
