// @ts-check
// Keys, and what can be set for this tab alone.

import { el } from "./dom.js";

const KEYS = [
  ["1 … 6", "view"], ["Space", "pause the view; play or pause a recording"], ["[ ]", "previous, next step"], ["{ }", "previous, next change of a control state"],
  ["Esc", "back to live; ends a tool, and leaves a field"], ["/", "filter"], ["G", "draw a goal, then confirm (Overview)"], ["M", "measure (Overview)"],
  ["F", "follow the robot (Overview)"], ["C", "copy the place under the pointer (Overview)"], ["← →", "previous, next step (Time) or sample (chart); 5 s of a recording"],
  ["Home End", "beginning and end of a recording"], ["?", "this list"],
];
/** Frames per second that this tab asks for; 0 for few, of which only those with a step or an entry of the log change what is shown. */
const RATES = [[20, "full rate"], [5, "5 times a second"], [1, "once a second"], [0, "with steps and entries of the log"]];

export class Help {
  /** @param {any} app */
  constructor(app) {
    this.app = app;
    const rate = el("select", { "aria-label": "How often this tab is updated", onchange: () => { this.set(Number(rate.value)); localStorage.setItem("rate", rate.value); app.redraw(); } },
      RATES.map(([hz, words]) => el("option", { value: hz }, words)));
    const saved = Number(localStorage.getItem("rate") ?? NaN);
    if (RATES.some(([hz]) => hz === saved)) { this.set(saved); rate.value = String(saved); }
    const keys = KEYS.flatMap(([key, words]) => [el("dt", {}, key.split(" ").map((it) => (it === "…" ? "… " : el("kbd", {}, it)))), el("dd", {}, words)]);
    this.dialog = el("dialog", { id: "keys", "aria-label": "Keys and settings" }, el("h2", {}, "Keys"), el("dl", {}, keys),
      el("h2", {}, "This tab"), el("p", {}, el("label", {}, "updates ", rate)),
      el("p", { class: "faint" }, "All views show the same time. A click into the log, the lanes or a chart moves it; a drag shows a range."),
      el("button", { type: "button", autofocus: true, onclick: () => this.toggle() }, "Close (Esc)"));
    document.body.append(this.dialog);
  }

  /** @param {number} hz */
  set(hz) {
    this.app.store.onChange = hz === 0;
    this.app.store.rate = hz || 5;
  }

  toggle() { if (this.dialog.open) this.dialog.close(); else this.dialog.showModal(); }

  /** Opens and closes by `?`. @returns {boolean} whether the key is done with: while it is open, keys are its own */
  key(event) {
    const isOpen = this.dialog.open;
    const toggles = event.key === "?" && (isOpen || !/^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName));
    if (toggles) { this.toggle(); event.preventDefault(); }
    return isOpen || toggles;
  }
}
