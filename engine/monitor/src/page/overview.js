// @ts-check
// Overview: where the robot is, what state the coordination is in, and what happened last.

import { el, panel, text, className, list, fixed, span } from "./dom.js";
import { findings } from "./findings.js";
import { MapView, composite } from "./map.js";
import { StateTable } from "./state_table.js";
import { LogList } from "./log_list.js";

const ON_MAP = ["nav_msgs/OccupancyGrid", "nav_msgs/Odometry", "nav_msgs/Path", "sensor_msgs/LaserScan", "nav/Obstacles"];

/** Shortest interval between drawings of the map, ms. */
const MAP = 66;

export class Overview {
  constructor(app) {
    this.app = app;
    this.seen = -1; this.drawn = 0;
    this.canvas = el("canvas", { role: "img", "aria-label": "Map; its content is in the table below it", tabindex: 0 });
    this.map = app.map = new MapView(app, this.canvas);
    this.map.onghost = () => this.confirm();
    this.buttons = {
      goal: this.tool("Goal", "Draws a goal: press, drag for the heading, then confirm (G)", () => this.take("goal")),
      follow: this.tool("Follow", "Keeps the robot in the middle (F)", () => { this.map.follow = !this.map.follow; }),
      measure: this.tool("Measure", "Measures a distance: press and drag (M)", () => this.take("measure")),
      fit: this.tool("Fit", "Shows the whole map", () => { this.map.follow = false; this.map.fit(); }),
    };
    this.stop = el("button", { type: "button", class: "danger", id: "stop", onclick: () => this.estop() }, "Software stop");
    this.cancel = el("button", { type: "button", id: "cancel", onclick: () => this.publishEmpty("cancel") }, "Cancel goal");
    this.over = el("div", { class: "over" });
    this.box = el("div", { class: "confirm", hidden: true, role: "dialog", "aria-label": "Confirm the goal" });
    this.twin = el("dl", { class: "twin" });
    const tools = [el("span", { class: "grow" }), this.buttons.goal, this.buttons.measure, this.buttons.follow, this.buttons.fit, this.cancel, this.stop];
    this.table = new StateTable(app);
    this.log = new LogList(app);
    this.mapPanel = panel("Map", "map-panel", tools, el("div", { class: "map" }, this.canvas, this.over, this.box), this.twin);
    this.findings = el("div", { class: "findings" });
    this.root = el("div", { class: "grid overview" }, this.mapPanel, this.table.root, panel("Events", "events-panel", this.log.tools, this.findings, this.log.root, this.log.detail));
  }

  tool(words, title, action) {
    return el("button", { type: "button", title, onclick: () => { action(); this.app.redraw(); } }, words);
  }

  /** Whether any output could be shown on the map; true as long as that is not known. */
  hasMap() {
    const { store } = this.app;
    const isShown = (type) => ON_MAP.includes(type) || type === "geometry_msgs/PoseStamped";
    return !store.components.length || store.components.some((it) => it.outputs.some((port) => isShown(port.type))) || store.outputs.some((it) => isShown(it.type || store.types.get(it.name)));
  }

  streams() {
    const { store } = this.app;
    const goals = store.ofType("geometry_msgs/PoseStamped").filter((name) => /goal/i.test(name));
    return [...ON_MAP.flatMap((type) => store.ofType(type)), ...goals];
  }

  recolour() { this.map.recolour(); }

  /** The topics that take a message of a type, by a part of their name. */
  topics(kind, part) {
    return this.app.store.system.topics.filter((it) => it.kind === kind && part.test(it.name) && it.subscribers.length);
  }

  take(tool) {
    const next = this.map.tool === tool ? "pan" : tool;
    this.dismiss();
    this.map.tool = next;
  }

  dismiss() {
    this.map.ghost = this.map.measured = null;
    this.map.tool = "pan";
    this.box.hidden = true;
    this.app.redraw();
  }

  /** Asks whether the drawn goal is to be sent. */
  confirm() {
    const topics = this.topics("geometry_msgs/PoseStamped", /goal/i);
    const [x, y, heading] = this.map.ghost ?? [0, 0, 0];
    const field = (name, value, label) => {
      const input = el("input", { name, value: value.toFixed(2), size: 6, inputmode: "decimal", "aria-label": label, oninput: () => this.typed() });
      return [el("label", {}, label, " ", input)];
    };
    this.topic = el("select", { "aria-label": "Topic", hidden: topics.length < 2 }, topics.map((it) => el("option", {}, it.name)));
    const degrees = heading * 180 / Math.PI;
    this.box.replaceChildren(
      el("strong", {}, "Send goal?"), ...field("x", x, "x m"), ...field("y", y, "y m"), ...field("yaw", degrees, "heading °"), this.topic,
      el("button", { type: "button", class: "primary", id: "send", onclick: () => this.send() }, "Send (Enter)"),
      el("button", { type: "button", onclick: () => this.dismiss() }, "Cancel (Esc)"));
    this.box.onkeydown = (event) => {
      if (event.key === "Enter") { event.preventDefault(); this.send(); }
      if (event.key === "Escape") { event.stopPropagation(); this.dismiss(); }
    };
    this.box.hidden = false;
    this.box.querySelector("#send")?.focus();
  }

  /** The goal follows what is typed. */
  typed() {
    const value = (name) => Number(this.box.querySelector(`[name=${name}]`).value);
    const typed = [value("x"), value("y"), value("yaw") * Math.PI / 180];
    if (typed.every(Number.isFinite)) this.map.ghost = typed;
    this.app.redraw();
  }

  async send() {
    const ghost = this.map.ghost;
    if (!ghost) return;
    const [x, y, heading] = ghost;
    const topic = this.topic.value || this.topics("geometry_msgs/PoseStamped", /goal/i)[0]?.name;
    const pose = { position: { x, y, z: 0 }, orientation: { x: 0, y: 0, z: Math.sin(heading / 2), w: Math.cos(heading / 2) } };
    const sent = this.app.control.publish(topic, { header: { frame_id: "map" }, pose }, `Goal (${x.toFixed(1)}, ${y.toFixed(1)})`);
    this.dismiss();
    await sent;
  }

  estop() {
    const [topic] = this.topics("std_msgs/Bool", /e_?stop/i);
    const data = !this.isStopped();
    this.app.control.publish(topic.name, { data }, data ? "Software stop" : "Release of the stop");
  }

  /** Whether the last message on the stop's topic, as a specification has read it, was a stop. */
  isStopped() {
    const states = Object.values(this.app.store.states);
    return states.some((state) => Object.entries(state.locations).some(([name, it]) => /^e_?stop/i.test(name) && it.value === "true"));
  }

  publishEmpty(part) {
    const [topic] = this.topics("std_msgs/Empty", new RegExp(part, "i"));
    this.app.control.publish(topic.name, {}, topic.name);
  }

  key(event) {
    const { key } = event;
    if (key === "g" || key === "G") {
      if (this.buttons.goal.disabled) return false;
      // by keyboard, the goal begins where the robot is
      const pose = this.map.robots()[0]?.pose;
      this.take("goal");
      if (this.map.tool === "goal" && document.activeElement === this.canvas && pose) { this.map.ghost = [...pose]; this.confirm(); }
    } else if (key === "f" || key === "F") this.map.follow = !this.map.follow;
    else if (key === "m" || key === "M") this.take("measure");
    else if ((key === "c" || key === "C") && this.map.hover) navigator.clipboard?.writeText(this.map.hover.map((it) => it.toFixed(3)).join(", "));
    else if (key === "Escape" && (this.map.tool !== "pan" || this.map.ghost)) this.dismiss();
    else return false;
    this.app.redraw();
    return true;
  }

  draw(now, texts) {
    if (texts) {
      const hasMap = this.hasMap();
      this.mapPanel.hidden = !hasMap;
      className(this.root, `grid overview ${hasMap ? "" : "mapless"}`);
    }
    const seen = this.app.store.changes.samples;
    // drawing the map costs more than everything else, so it is drawn when something has moved, and not at the rate of the screen
    if (!this.mapPanel.hidden && (texts || (seen !== this.seen && now - this.drawn >= MAP))) {
      this.map.draw(now);
      Object.assign(this, { seen, drawn: now });
    }
    if (!texts) return;
    const { control } = this.app;
    const goals = this.topics("geometry_msgs/PoseStamped", /goal/i);
    const state = (button, exists, title) => {
      button.hidden = !exists;
      button.disabled = !control.armed;
      button.title = control.armed ? title : `${title}: ${control.reason}`;
    };
    state(this.buttons.goal, goals.length > 0, "Draws a goal: press, drag for the heading, then confirm (G)");
    state(this.cancel, this.topics("std_msgs/Empty", /cancel/i).length > 0, "Publishes a cancellation");
    const stopped = this.isStopped();
    state(this.stop, this.topics("std_msgs/Bool", /e_?stop/i).length > 0, "Publishes a stop. This is no safety function");
    text(this.stop, stopped ? "Release stop" : "Software stop");
    this.buttons.goal.setAttribute("aria-pressed", String(this.map.tool === "goal"));
    this.buttons.measure.setAttribute("aria-pressed", String(this.map.tool === "measure"));
    this.buttons.follow.setAttribute("aria-pressed", String(this.map.follow));
    this.canvas.style.cursor = this.map.tool === "pan" ? "grab" : "crosshair";
    const send = /** @type {HTMLButtonElement | null} */ (this.box.querySelector("#send"));
    if (send) { send.disabled = !control.armed; send.title = control.reason; }
    this.describe();
    this.table.draw();
    this.log.draw();
    const problems = findings(this.app.store).filter((it) => it.level === "bad").slice(0, 3);
    list(this.findings, problems, (it) => it.text.replace(/[\d.]+/g, ""), () => el("p"), (row, it) => text(row, it.text));
  }

  /** The content of the map as a table. */
  describe() {
    const { store } = this.app;
    const rows = [];
    const goals = this.map.goals();
    const robots = this.map.robots();
    for (const robot of robots) {
      const component = robot.name.replace(/\.[^.]*$/, "");
      // with one robot, nothing has to be told apart
      const of = robots.length > 1 ? ` of ${composite(robot.name) || component}` : "";
      const pose = robot.pose;
      const stale = robot.stale && store.cursor === null;
      rows.push([`pose${of || ` of ${component}`}`, pose ? `${fixed(pose[0], 2)}, ${fixed(pose[1], 2)} m  ${fixed(pose[2] * 180 / Math.PI, 0)}°` : "unknown", stale ? `stale ${((store.age(robot.name) ?? 0) / 1000).toFixed(1)} s` : ""]);
      const twist = robot.sample?.data.twist.twist;
      if (twist && !store.isBack) rows.push([`twist${of}`, `${fixed(twist.linear.x, 2)} m/s  ${fixed(twist.angular.z, 2)} rad/s`, stale ? "stale" : ""]);
      const goal = goals.find((it) => it.name.split("/")[0] === robot.name.split("/")[0]) ?? goals[0];
      if (goal && pose) {
        rows.push([`goal${of}`, `${goal.pose[0].toFixed(2)}, ${goal.pose[1].toFixed(2)} m  ${(goal.pose[2] * 180 / Math.PI).toFixed(0)}°`, ""]);
        const direct = Math.hypot(goal.pose[0] - pose[0], goal.pose[1] - pose[1]);
        const left = store.isBack ? null : this.map.leftOf(robot.name, pose);
        const speed = Math.abs(twist?.linear.x ?? 0);
        const words = left === null ? `${direct.toFixed(2)} m, direct` : `${left.toFixed(2)} m${speed > 0.05 && !store.isBack ? `; ${span(left / speed)}` : ""}`;
        rows.push([`way left${of}`, words, ""]);
      }
    }
    for (const name of store.ofType("sensor_msgs/LaserScan")) {
      const scan = store.samples.get(name)?.data;
      const hits = scan?.ranges.filter((it) => it >= scan.range_min && it <= scan.range_max) ?? [];
      if (scan) rows.push([`nearest obstacle${robots.length > 1 ? ` of ${composite(name) || name}` : ""}`, hits.length ? `${fixed(Math.min(...hits), 2)} m` : "none in range", store.isStale(name) ? `stale ${((store.age(name) ?? 0) / 1000).toFixed(1)} s` : ""]);
    }
    if (this.map.hover) rows.push(["cursor", `${this.map.hover[0].toFixed(2)}, ${this.map.hover[1].toFixed(2)} m`, ""]);
    const make = () => el("div", {}, el("dt", { class: "label" }), el("dd", { class: "value" }));
    list(this.twin, rows, (it) => it[0], make, (row, [label, value, stale]) => {
      text(row.firstChild, stale ? `${label} — ${stale}` : label);
      className(row.firstChild, stale ? "label stale" : "label");
      text(row.lastChild, value);
    });
    this.twin.hidden = rows.length === 0;
    text(this.over, "");
  }
}
