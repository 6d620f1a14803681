// @ts-check
// Logs: everything that happened, with filters.

import { el, panel } from "./dom.js";
import { LogList } from "./log_list.js";

export class Logs {
  constructor(app) {
    this.log = new LogList(app, { limit: 500, filtered: true, levels: true });
    this.root = el("div", { class: "grid" }, panel("Log", "log-panel", this.log.tools, this.log.root));
  }

  streams() { return []; }

  draw(now, texts) { if (texts) this.log.draw(); }
}
