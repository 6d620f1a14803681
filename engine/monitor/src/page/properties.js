// @ts-check
// The properties of a specification: what this run says about each of them.

import { el, text, className, list } from "./dom.js";

export class Properties {
  /** @param {any} app @param {(place: string) => void} reveal */
  constructor(app, reveal) {
    Object.assign(this, { app, reveal });
    this.list = el("div", { class: "findings", id: "properties" });
    this.note = el("p", { class: "empty" });
    this.root = el("section", { class: "part", "aria-label": "Properties" }, el("h3", {}, "properties"), this.list, this.note);
  }

  /** @param {any} specification */
  draw(specification) {
    const { store } = this.app;
    const { component, properties, files } = specification;
    const known = store.components.find((it) => it.name === component);
    const inspection = new Map(known?.inspection ?? []);
    const violated = Object.entries(inspection.get("violated") ?? {});
    const unwatched = Object.entries(inspection.get("unwatched") ?? {});
    const recorded = (store.recording?.violations ?? []).filter(([t, name]) => name === component && t <= store.cursor + 1e-9);
    const file = files[0]?.name ?? "";
    const rows = properties.map((property) => {
      const is = ([stated]) => spaced(property.text).includes(spaced(stated));
      const broken = recorded.filter(([, , words]) => words.includes(`(${file}:${property.line})`));
      return { ...property, place: `${file}:${property.line}`, steps: violated.find(is)?.[1] ?? broken.length, first: broken[0]?.[0] ?? null, reason: unwatched.find(is)?.[1] ?? null };
    });
    // what the composite states is not in the text
    const own = (stated) => properties.some((it) => spaced(it.text).includes(spaced(stated)));
    for (const [stated, steps] of violated) if (!own(stated)) rows.push({ text: stated, line: 0, place: "", steps, first: null, reason: null });
    list(this.list, rows, (it) => `${it.line} ${it.text}`, () => el("p", { class: "pick" }, el("span", { class: "said" }), " ", el("code")), (row, it) => {
      const isWatched = !!known?.inspection.length;
      const words = it.first !== null ? `violated, first at ${it.first.toFixed(2)} s` : it.steps ? `violated in ${it.steps} ${it.steps === 1 ? "step" : "steps"}` : it.reason ? "not watched" : store.recording ? "no violation recorded so far" : isWatched ? "not violated so far" : "";
      className(row, `pick ${it.steps ? "bad" : it.reason || !words ? "hint" : "fine"}`);
      text(row.firstChild, words);
      text(row.lastChild, it.text);
      row.title = it.reason ?? (it.first === null ? "Click: the place in the source" : "Click: the step that violates it");
      row.onclick = () => { if (it.place) this.reveal(it.place); if (it.first !== null) this.app.seek(it.first); };
    });
    text(this.note, rows.length ? "" : "The specification has no invariants and properties.");
    this.note.hidden = rows.length > 0;
  }
}

function spaced(words) { return words.replace(/\s+/g, ""); }
