// @ts-check
// Control of the system: the permission of this tab, as the server knows it, and orders.

import { el } from "./dom.js";

export class Control {
  /** @param {import("./store.js").Store} store @param {import("./link.js").Link} link @param {string | null} token */
  constructor(store, link, token) {
    Object.assign(this, { store, link, token });
    this.shown = "";
    /** What happened to the last order. */
    this.outcome = { text: "", bad: false };
    link.onarmed = (problem) => {
      if (!problem) return;
      // a token of an earlier run is of no use any more
      if (problem.includes("token")) this.token = null;
      this.say(problem, true);
    };
  }

  /** Whether this tab may control the system now. */
  get armed() { return typeof this.store.permission === "object" && this.store.silence() === 0 && this.store.end === null; }

  /** Why this tab may not control the system, in words. */
  get reason() {
    if (this.armed) return "";
    if (this.store.recording) return "a recording cannot be controlled";
    if (this.store.end !== null) return "the run has ended";
    if (this.store.permission === "view") return "started without --control";
    if (!this.isKnown) return "this browser has not logged in to this run: open the printed address";
    return "arm this tab first";
  }

  /** Whether this tab may be armed: its browser has logged in, or it has the token. */
  get isKnown() { return this.store.known || !!this.token; }

  arm(take) { this.link.send(this.token ? { type: "arm", token: this.token, take } : { type: "arm", take }); }

  say(words, bad = false) { this.outcome = { text: words, bad }; this.shown = ""; }

  /** Sends an order, and shows what comes of it. @returns {Promise<boolean>} whether it has been carried out */
  async order(message, words) {
    this.say(`${words} …`);
    const problem = await this.link.order(message);
    this.say(problem ? `${words}: ${problem}` : `${words}: done`, !!problem);
    return !problem;
  }

  wish(component, wish, words) { return this.order({ type: "order", component, wish }, words); }

  publish(topic, value, words) { return this.order({ type: "publish", topic, value }, words); }

  /** Draws the state of the permission. @param {HTMLElement} place @param {boolean} off */
  draw(place, off) {
    const permission = this.store.permission;
    const left = typeof permission === "object" ? permission.armed_s : null;
    const state = JSON.stringify([off, left, permission, this.isKnown, this.outcome]);
    if (state === this.shown) return;
    this.shown = state;
    const button = (words, action, kind = "") => el("button", { type: "button", class: kind, disabled: off, onclick: action }, words);
    const parts = [];
    if (permission === "view") parts.push(el("span", { class: "chip", title: this.store.recording ? "A recording cannot be controlled" : "Started without --control" }, "view only"));
    else if (left !== null) {
      const time = `${Math.floor(left / 60)}:${String(left % 60).padStart(2, "0")}`;
      parts.push(el("span", { class: "chip armed", id: "armed" }, `CONTROL ARMED ${time}`));
      parts.push(button("Disarm", () => this.link.send({ type: "disarm" })));
    } else if (!this.isKnown) parts.push(el("span", { class: "chip", title: this.reason }, "view only (not logged in)"));
    else if (permission === "held") {
      parts.push(el("span", { class: "chip note" }, "another tab is armed"));
      parts.push(button("Take over", () => this.arm(true), "danger"));
    } else parts.push(button("Arm control", () => this.arm(false), "danger"));
    if (this.outcome.text) {
      const close = () => { this.say(""); };
      parts.push(el("span", { class: `chip ${this.outcome.bad ? "bad" : "good"}`, id: "outcome", role: "status", onclick: close, title: "Click to hide" }, this.outcome.text));
    }
    place.replaceChildren(...parts);
  }
}
