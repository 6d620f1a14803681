// @ts-check
// Logs: everything that happened, with filters.

import { el, panel } from "./dom.js";
import { LogList } from "./log_list.js";

export class Logs {
  constructor(app) {
    this.log = new LogList(app, { levels: true });
    this.root = el("div", { class: "grid" }, panel("Log", "log-panel", this.log.tools, this.log.root, this.log.detail));
  }

  streams() { return []; }

  draw(now, texts) { if (texts) this.log.draw(); }
}
