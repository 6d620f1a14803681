// @ts-check
// The map: occupancy grid, laser, planned and driven path, goal and pose of each robot, in metres of the map's frame.

import { colour, fitted } from "./dom.js";
import { yaw } from "./store.js";

const COLOURS = ["map-free", "map-wall", "map-unknown", "map-laser", "map-plan", "map-driven", "ink", "faint", "note", "panel", "accent", "bad"];
const ROVER = 0.32;

export class MapView {
  /** @param {any} app @param {HTMLCanvasElement} canvas */
  constructor(app, canvas) {
    Object.assign(this, { app, canvas });
    this.scale = 30; this.x = 0; this.y = 0;
    this.fittedTo = null; this.follow = false; this.tool = "pan";
    /** Both ends of the measured distance, m. @type {[number, number][] | null} */ this.measured = null;
    /** The goal that has been drawn and not been sent: x, y, yaw. @type {number[] | null} */ this.ghost = null;
    this.grids = new Map();
    this.pointer = null;
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", () => this.up());
    canvas.addEventListener("pointerleave", () => { this.hover = null; });
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    this.recolour();
  }

  recolour() {
    this.colours = Object.fromEntries(COLOURS.map((name) => [name, colour(name)]));
    this.grids.clear();
  }

  /** @returns {[number, number]} */
  toScreen(x, y) { return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale]; }

  toMap(event) {
    const box = this.canvas.getBoundingClientRect();
    const [column, row] = [event.clientX - box.left, event.clientY - box.top];
    return [this.x + (column - this.width / 2) / this.scale, this.y - (row - this.height / 2) / this.scale];
  }

  down(event) {
    this.canvas.setPointerCapture(event.pointerId);
    const [x, y] = this.toMap(event);
    this.pointer = { column: event.clientX, row: event.clientY, x, y };
    if (this.tool === "goal") this.ghost = [x, y, 0];
    if (this.tool === "measure") this.measured = [[x, y], [x, y]];
  }

  move(event) {
    const [x, y] = this.toMap(event);
    this.hover = [x, y];
    if (!this.pointer) return;
    if (this.tool === "goal" && this.ghost) {
      const [dx, dy] = [x - this.ghost[0], y - this.ghost[1]];
      if (Math.hypot(dx, dy) * this.scale > 8) this.ghost[2] = Math.atan2(dy, dx);
    } else if (this.tool === "measure" && this.measured) this.measured[1] = [x, y];
    else {
      this.follow = false;
      this.x -= (event.clientX - this.pointer.column) / this.scale;
      this.y += (event.clientY - this.pointer.row) / this.scale;
      this.pointer = { ...this.pointer, column: event.clientX, row: event.clientY };
    }
    this.app.redraw();
  }

  up() {
    if (this.pointer && this.tool === "goal" && this.ghost) this.onghost?.();
    this.pointer = null;
  }

  wheel(event) {
    event.preventDefault();
    const [x, y] = this.toMap(event);
    const factor = Math.exp(-event.deltaY / 500);
    const scale = Math.min(400, Math.max(2, this.scale * factor));
    this.x = x + (this.x - x) * this.scale / scale;
    this.y = y + (this.y - y) * this.scale / scale;
    this.scale = scale;
    this.app.redraw();
  }

  /** Shows the whole map, or the surroundings of the robots without one. */
  fit() {
    const grid = this.app.store.ofType("nav_msgs/OccupancyGrid").map((name) => this.app.store.samples.get(name)).find(Boolean);
    const poses = this.robots().map((it) => it.pose).filter(Boolean);
    if (grid) {
      const { width, height, resolution, origin } = grid.data.info;
      const [w, h] = [width * resolution, height * resolution];
      this.x = origin.position.x + w / 2;
      this.y = origin.position.y + h / 2;
      this.scale = Math.max(2, Math.min(this.width / w, this.height / h) * 0.96);
      return true;
    }
    if (poses.length) { [this.x, this.y] = poses[0]; this.scale = 40; }
    return false;
  }

  /** Length of the newest planned path of a robot from the point that is nearest to it, m; null without a path.
   * @param {string} robot @param {number[]} pose */
  leftOf(robot, pose) {
    const { store } = this.app;
    const paths = store.ofType("nav_msgs/Path").filter((name) => composite(name) === composite(robot) && store.output.get(name)?.topic);
    const poses = paths.map((name) => store.samples.get(name)).filter(Boolean).sort((one, other) => other.t - one.t)[0]?.data.poses ?? [];
    if (poses.length < 2) return null;
    const points = poses.map((it) => [it.pose.position.x ?? 0, it.pose.position.y ?? 0]);
    const far = points.map(([x, y]) => Math.hypot(x - pose[0], y - pose[1]));
    const nearest = far.indexOf(Math.min(...far));
    let left = far[nearest];
    for (let at = nearest + 1; at < points.length; at++) left += Math.hypot(points[at][0] - points[at - 1][0], points[at][1] - points[at - 1][1]);
    return left;
  }

  /** The robots with poses at the cursor: { name, pose: [x, y, yaw], trail, stale }. */
  robots() {
    const { store } = this.app;
    return store.ofType("nav_msgs/Odometry").map((name) => {
      const sample = store.samples.get(name), trail = store.trails.get(name) ?? [];
      const position = sample?.data.pose.pose.position;
      let pose = sample && [position.x, position.y, yaw(sample.data.pose.pose.orientation)];
      let shown = trail;
      if (store.cursor !== null) {
        shown = trail.filter((it) => it[0] <= store.cursor + 1e-9);
        if (store.isBack) pose = shown.at(-1)?.slice(1) ?? null;
      }
      return { name, pose, trail: shown, sample, stale: store.isStale(name) };
    });
  }

  draw(now) {
    const { context, width, height } = fitted(this.canvas);
    Object.assign(this, { width, height });
    if (width === 0) return;
    const { store } = this.app;
    const key = [store.ofType("nav_msgs/OccupancyGrid").some((name) => store.samples.has(name)), width, height].join();
    if (this.fittedTo !== key && !this.moved) { if (this.fit() || this.fittedTo === null) this.fittedTo = key; }
    const robots = this.robots();
    if (this.follow && robots[0]?.pose) [this.x, this.y] = robots[0].pose;
    context.fillStyle = this.colours["map-unknown"];
    context.fillRect(0, 0, width, height);
    for (const name of store.ofType("nav_msgs/OccupancyGrid")) this.grid(context, name);
    this.metres(context);
    for (const name of store.ofType("nav/Obstacles")) this.obstacles(context, name);
    for (const name of store.ofType("nav_msgs/Path")) this.path(context, name);
    for (const robot of robots) this.trail(context, robot.trail);
    for (const name of store.ofType("sensor_msgs/LaserScan")) this.laser(context, name, robots);
    for (const goal of this.goals()) this.marker(context, goal.pose, this.colours.accent, false);
    if (this.measured) this.measure(context, this.measured);
    if (this.ghost) this.marker(context, this.ghost, this.colours.note, true);
    for (const robot of robots) if (robot.pose) this.rover(context, robot, robots.length > 1);
    this.ruler(context);
  }

  /** The image of a grid, with one pixel for each cell. */
  image(name) {
    const sample = this.app.store.samples.get(name);
    if (!sample) return null;
    const known = this.grids.get(name);
    if (known?.n === sample.n) return known;
    const { info, data } = sample.data;
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [info.width, info.height];
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    const pixels = context.createImageData(info.width, info.height);
    const [free, wall, unknown] = ["map-free", "map-wall", "map-unknown"].map((it) => rgb(this.colours[it]));
    for (let cell = 0; cell < data.length; cell++) {
      // rows of a grid count upwards, those of an image downwards
      const row = info.height - 1 - Math.floor(cell / info.width);
      const at = 4 * (row * info.width + (cell % info.width));
      const value = data[cell];
      const share = Math.min(1, Math.max(0, value / 100));
      for (let part = 0; part < 3; part++) {
        pixels.data[at + part] = value < 0 ? unknown[part] : free[part] + share * (wall[part] - free[part]);
      }
      pixels.data[at + 3] = 255;
    }
    context.putImageData(pixels, 0, 0);
    const image = { n: sample.n, canvas, info };
    this.grids.set(name, image);
    return image;
  }

  grid(context, name) {
    const image = this.image(name);
    if (!image) return;
    const { width, height, resolution, origin } = image.info;
    const [column, row] = this.toScreen(origin.position.x, origin.position.y);
    context.save();
    context.translate(column, row);
    context.rotate(-yaw(origin.orientation));
    context.imageSmoothingEnabled = this.scale * resolution < 1;
    const [w, h] = [width * resolution * this.scale, height * resolution * this.scale];
    context.drawImage(image.canvas, 0, -h, w, h);
    context.restore();
  }

  metres(context) {
    const step = [1, 2, 5, 10, 20, 50].find((it) => it * this.scale > 45) ?? 100;
    context.strokeStyle = this.colours.faint;
    context.globalAlpha = 0.13;
    context.lineWidth = 1;
    context.beginPath();
    for (let x = Math.ceil((this.x - this.width / 2 / this.scale) / step) * step; this.toScreen(x, 0)[0] < this.width; x += step) {
      const column = Math.round(this.toScreen(x, 0)[0]) + 0.5;
      context.moveTo(column, 0); context.lineTo(column, this.height);
    }
    for (let y = Math.ceil((this.y - this.height / 2 / this.scale) / step) * step; this.toScreen(0, y)[1] > 0; y += step) {
      const row = Math.round(this.toScreen(0, y)[1]) + 0.5;
      context.moveTo(0, row); context.lineTo(this.width, row);
    }
    context.stroke();
    context.globalAlpha = 1;
  }

  ruler(context) {
    const step = [0.5, 1, 2, 5, 10, 20].find((it) => it * this.scale > 50) ?? 50;
    const length = step * this.scale, [x, y] = [this.width - length - 14, this.height - 12];
    context.strokeStyle = context.fillStyle = this.colours.ink;
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(x, y - 4); context.lineTo(x, y); context.lineTo(x + length, y); context.lineTo(x + length, y - 4);
    context.stroke();
    context.font = "11px sans-serif"; context.textAlign = "center";
    context.fillText(`${step} m`, x + length / 2, y - 6);
  }

  path(context, name) {
    const poses = this.app.store.samples.get(name)?.data.poses ?? [];
    if (poses.length < 2) return;
    // the coordinator's plan is what has been requested; what a component makes of it is thinner
    const isPlan = !!this.app.store.output.get(name)?.topic;
    context.strokeStyle = this.colours["map-plan"];
    context.lineWidth = isPlan ? 3 : 1.5;
    context.setLineDash(isPlan ? [8, 5] : []);
    context.globalAlpha = isPlan ? 0.9 : 0.55;
    this.line(context, poses.map((it) => [it.pose.position.x, it.pose.position.y]));
    context.setLineDash([]);
    context.globalAlpha = 1;
  }

  trail(context, trail) {
    if (trail.length < 2) return;
    context.strokeStyle = this.colours["map-driven"];
    context.lineWidth = 2;
    this.line(context, trail.map((it) => [it[1], it[2]]));
  }

  line(context, points) {
    context.beginPath();
    points.forEach(([x, y], index) => {
      const [column, row] = this.toScreen(x, y);
      if (index) context.lineTo(column, row); else context.moveTo(column, row);
    });
    context.stroke();
  }

  obstacles(context, name) {
    const points = this.app.store.samples.get(name)?.data.points ?? [];
    context.fillStyle = this.colours.bad;
    context.globalAlpha = 0.6;
    for (const { x, y } of points) { const [column, row] = this.toScreen(x, y); context.fillRect(column - 2, row - 2, 4, 4); }
    context.globalAlpha = 1;
  }

  laser(context, name, robots) {
    const { store } = this.app;
    const scan = store.samples.get(name)?.data;
    const robot = robots.find((it) => composite(it.name) === composite(name)) ?? robots[0];
    // a scan of the past does not belong to a pose of now
    if (!scan || !robot?.pose || store.isBack) return;
    const [x, y, heading] = robot.pose;
    context.fillStyle = store.isStale(name) ? this.colours.faint : this.colours["map-laser"];
    scan.ranges.forEach((range, index) => {
      if (!(range >= scan.range_min && range <= scan.range_max)) return;
      const angle = heading + scan.angle_min + index * scan.angle_increment;
      const [column, row] = this.toScreen(x + range * Math.cos(angle), y + range * Math.sin(angle));
      context.fillRect(column - 1.5, row - 1.5, 3, 3);
    });
  }

  /** The goals: the newest pose that was sent to each port named `goal`. */
  goals() {
    const { store } = this.app;
    const found = store.ofType("geometry_msgs/PoseStamped").filter((name) => /goal/i.test(name)).map((name) => ({ name, sample: store.samples.get(name) }));
    const newest = new Map();
    for (const { name, sample } of found) {
      if (!sample) continue;
      const robot = composite(name);
      if (!(newest.get(robot)?.sample.t > sample.t)) newest.set(robot, { name, sample });
    }
    return [...newest.values()].map(({ name, sample }) => {
      const { position, orientation } = sample.data.pose;
      return { name, t: sample.t, pose: [position.x ?? 0, position.y ?? 0, yaw(orientation ?? {})] };
    });
  }

  marker(context, [x, y, heading], shade, ghost) {
    const [column, row] = this.toScreen(x, y);
    context.save();
    context.translate(column, row);
    context.strokeStyle = context.fillStyle = shade;
    context.lineWidth = 2.5;
    context.setLineDash(ghost ? [4, 3] : []);
    context.beginPath(); context.arc(0, 0, 9, 0, 2 * Math.PI); context.stroke();
    context.setLineDash([]);
    context.beginPath(); context.arc(0, 0, 2.5, 0, 2 * Math.PI); context.fill();
    context.rotate(-heading);
    context.beginPath(); context.moveTo(9, 0); context.lineTo(26, 0); context.moveTo(20, -5); context.lineTo(26, 0); context.lineTo(20, 5); context.stroke();
    context.restore();
  }

  /** A measured distance. */
  measure(context, [from, to]) {
    const [[column, row], [endColumn, endRow]] = [this.toScreen(...from), this.toScreen(...to)];
    context.strokeStyle = this.colours.note;
    context.lineWidth = 2;
    context.beginPath(); context.moveTo(column, row); context.lineTo(endColumn, endRow); context.stroke();
    for (const [x, y] of [[column, row], [endColumn, endRow]]) { context.beginPath(); context.arc(x, y, 3, 0, 2 * Math.PI); context.stroke(); }
    this.label(context, `${Math.hypot(to[0] - from[0], to[1] - from[1]).toFixed(2)} m`, (column + endColumn) / 2 + 6, (row + endRow) / 2 - 6, this.colours.ink);
  }

  /** A text that can be read on any ground. */
  label(context, words, column, row, shade) {
    context.font = "600 12px sans-serif"; context.textAlign = "left";
    context.lineWidth = 4; context.strokeStyle = this.colours.panel; context.fillStyle = shade;
    context.strokeText(words, column, row); context.fillText(words, column, row);
  }

  rover(context, robot, named) {
    const [column, row] = this.toScreen(robot.pose[0], robot.pose[1]);
    const size = Math.max(11, ROVER * this.scale);
    context.save();
    context.translate(column, row);
    context.rotate(-robot.pose[2]);
    context.beginPath();
    context.moveTo(size, 0); context.lineTo(-size * 0.75, size * 0.7); context.lineTo(-size * 0.4, 0); context.lineTo(-size * 0.75, -size * 0.7);
    context.closePath();
    const stale = robot.stale && this.app.store.cursor === null;
    context.fillStyle = stale ? this.colours.panel : this.colours.ink;
    context.strokeStyle = stale ? this.colours.bad : this.colours.panel;
    context.lineWidth = 2;
    context.setLineDash(stale ? [4, 3] : []);
    context.fill(); context.stroke();
    context.restore();
    const age = this.app.store.age(robot.name);
    const label = stale ? `stale ${((age ?? 0) / 1000).toFixed(0)} s` : named ? composite(robot.name) : "";
    if (!label) return;
    this.label(context, label, column + size + 4, row - size, stale ? this.colours.bad : this.colours.ink);
  }
}

/** The nested composite of a port: `Left` of `Left/RoverDriver.odom`. */
export function composite(name) { return name.includes("/") ? name.slice(0, name.indexOf("/")) : ""; }

function rgb(hex) { return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16)); }
