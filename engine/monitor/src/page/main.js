// @ts-check
// The frame around the views: header, tabs, keys, the time cursor, and the drawing loop.

import { el, text, className, span, forgetColours } from "./dom.js";
import { Link } from "./link.js";
import { Store } from "./store.js";
import { Control } from "./control.js";
import { broken } from "./findings.js";
import { Overview } from "./overview.js";
import { Spec } from "./spec.js";
import { Time } from "./time.js";
import { Components } from "./components.js";
import { Joints } from "./joints.js";
import { Logs } from "./logs.js";
import { Playback } from "./playback.js";
import { Help } from "./help.js";

/** Interval between updates of texts and tables, ms: faster is not readable. */
const TEXTS = 200;
/** Interval between drawings of what moves, ms. Each frame of the browser costs something even if nothing is drawn in it, so that
 * frames are asked for at this rate, and at once for what the user does. */
const FRAME = 50;
const BASE = ["components", "outputs", "steps", "log"];
const byId = (name) => /** @type {HTMLElement} */ (document.getElementById(name));

const store = new Store();
store.wanted = Number(/@([\d.]+)$/.exec(location.hash)?.[1] ?? NaN);
const token = takeToken();
const link = new Link(store);
const control = new Control(store, link, token);
/** What views share. `range` is the shown range of time, in seconds; null if it follows the shown time. */
const app = { store, link, control, paused: false, range: /** @type {[number, number] | null} */ (null), seek, zoom, shown, redraw, show };
const help = new Help(app);
/** The time of a recording; null for a running system. @type {Playback | null} */
let playback = null;

const views = [
  { name: "overview", title: "Overview", make: () => new Overview(app) },
  { name: "spec", title: "Spec", make: () => new Spec(app) },
  { name: "components", title: "Components", make: () => new Components(app) },
  { name: "time", title: "Time", make: () => new Time(app) },
  { name: "joints", title: "Joints", make: () => new Joints(app) },
  { name: "logs", title: "Logs", make: () => new Logs(app) },
].map((it) => ({ ...it, /** @type {any} */ view: null, /** @type {any} */ tab: null }));
let current = views[0];
let lastTexts = 0, lastHappened = 0, forced = true, pausedAt = 0;

/** The token from the address, which then disappears from it. The part behind `#` is sent to no server. The token becomes a cookie,
 * which no script reads, and otherwise stays in this variable: a browser without cookies has it until the page is loaded again. */
function takeToken() {
  const found = /^#token=([0-9a-f]+)$/.exec(location.hash);
  if (found) {
    history.replaceState(null, "", "#overview");
    fetch("login", { method: "POST", headers: { Authorization: `Bearer ${found[1]}` } }).catch(() => {});
  }
  return found ? found[1] : null;
}

/** Moves the time that all views show; null is now. @param {number | null} t */
function seek(t) {
  const end = store.recording?.end;
  store.cursor = playback ? Math.min(end, Math.max(0, t ?? end)) : t === null ? null : Math.max(0, t);
  // the shown time lies in the shown range
  if (app.range && !(store.cursor !== null && store.cursor >= app.range[0] && store.cursor <= app.range[1])) app.range = null;
  playback?.ask();
  redraw();
}

/** Shows a range of time in all views that show one; null follows the shown time. @param {[number, number] | null} range */
function zoom(range) {
  app.range = range && [Math.max(0, range[0]), range[1]];
  if (app.range && (store.cursor === null || store.cursor < app.range[0] || store.cursor > app.range[1])) {
    store.cursor = app.range[1];
    playback?.ask();
  }
  redraw();
}

/** The range of time that a view with this span shows. @param {number} span @returns {[number, number]} */
function shown(span) {
  if (app.range) return app.range;
  const { cursor } = store;
  const end = cursor === null || cursor > store.t - span * 0.9 ? store.t : Math.min(store.t, cursor + span * 0.3);
  return [Math.max(end, span) - span, Math.max(end, span)];
}

function redraw() {
  forced = true;
  wake();
}

let frame = 0, timer = 0;

/** Draws in the next frame of the browser. */
function wake() {
  clearTimeout(timer);
  frame ||= requestAnimationFrame(draw);
}

/** @param {string} name */
function show(name) {
  location.hash = name;
  // before the event about it, the address may have changed again
  select();
}

function select() {
  const name = location.hash.slice(1).split("@")[0];
  current = views.find((it) => it.name === name && !it.tab.hidden) ?? views[0];
  for (const it of views) {
    it.tab.setAttribute("aria-selected", String(it === current));
    it.tab.tabIndex = it === current ? 0 : -1;
  }
  if (store.system) current.view ??= current.make();
  byId("view").replaceChildren(current.view?.root ?? el("p", { class: "empty" }, "Waiting for the system …"));
  document.title = `${store.system?.name ?? "asmotion"} · ${current.title}`;
  redraw();
}

function header(now) {
  const silence = store.silence(now);
  const ended = store.end !== null;
  text(byId("name"), store.system?.name ?? "asmotion");
  text(byId("clock"), store.system ? [store.system.profile, store.system.clock].filter(Boolean).join(" · ") : "");
  text(byId("time"), `${(store.recording ? store.cursor : store.t).toFixed(1)} s`);
  byId("time").title = `Time of the run${store.recording ? "" : `; ${new Date().toLocaleTimeString()} on this machine`}`;
  const lost = silence > 0 && !ended;
  document.body.classList.toggle("lost", lost);
  document.body.classList.toggle("paused", app.paused);
  const chip = byId("connection");
  const calm = store.recording ? "note" : "good";
  className(chip, `chip ${ended ? "note" : lost ? "bad" : calm}`);
  text(chip, ended ? "■ ended" : lost ? `▲ no connection for ${Math.floor(silence / 1000)} s` : store.recording ? "■ recording" : "● live");
  control.draw(byId("control"), lost || ended);
  banner(lost, ended, silence, now);
}

function banner(lost, ended, silence, now) {
  const place = byId("banner");
  let words = "", action = null;
  if (app.range && !lost && !ended && !(store.recording && store.recording.problem)) [words, action] = [`Showing ${app.range[0].toFixed(2)} s to ${app.range[1].toFixed(2)} s, ${span(app.range[1] - app.range[0])} in all.`, store.recording ? ["Whole", () => zoom(null)] : ["Back to live", () => seek(null)]];
  else if (store.recording && !lost) words = store.recording.problem ? `The recording is INCOMPLETE: ${store.recording.problem}.` : "";
  else if (ended) words = `The run has ended: ${store.end}. What is shown is its last state.`;
  else if (lost) words = `No connection to the system for ${span(silence / 1000)}: what is shown is outdated.`;
  else if (app.paused) [words, action] = [`The view is paused for ${span((now - pausedAt) / 1000)}; the system continues.`, ["Resume", pause]];
  else if (store.cursor !== null) [words, action] = [`Showing ${store.cursor.toFixed(2)} s, ${span(Math.max(0, store.t - store.cursor))} ago.`, ["Back to live", () => seek(null)]];
  const isBroken = !words && store.links.length > 0;
  if (isBroken) words = `${store.links.map(broken).join(". ")}. This process continues without it.`;
  place.hidden = !words;
  className(place, lost || isBroken ? "bad" : "");
  const kind = action ? String(action[0]) : "";
  if (place.dataset.kind !== kind || !place.firstChild) {
    place.dataset.kind = kind;
    place.replaceChildren(el("span"), ...(action ? [el("button", { type: "button", onclick: action[1] }, action[0])] : []));
  }
  text(place.firstChild, words);
}

function pause() {
  app.paused = !app.paused;
  pausedAt = performance.now();
  byId("pause").setAttribute("aria-pressed", String(app.paused));
  text(byId("pause"), app.paused ? "Resume view" : "Pause view");
  redraw();
}

/** Keeps the time of a recording in the address, so that the address shows the same again. */
function address() {
  const hash = `#${current.name}@${Number(store.cursor.toFixed(3))}`;
  if (location.hash !== hash && !playback?.playing) history.replaceState(null, "", hash);
}

/** Tells readers of the screen what matters, control states and the last fault, at most once a second. */
const announce = (() => {
  let last = 0, said = "";
  return (now) => {
    if (now - last < 1000 || !store.system) return;
    const states = store.specifications.filter((it) => it.diagram).map((it) => {
      const value = store.locationsAt(it.component)[it.diagram.location]?.value;
      return value ? `${it.component}: ${value}` : "";
    });
    const fault = store.log.findLast((it) => it.level === "error" && (!store.recording || it.t <= store.cursor + 1e-9));
    const words = [...states, fault && `${fault.kind} of ${fault.component} at ${fault.t.toFixed(1)} s: ${fault.text}`].filter(Boolean).join(", ");
    if (words !== said) { text(byId("announcer"), words); said = words; last = now; }
  };
})();

/** What the tab asks for. Charts show every sample, also of the time before they were opened; of all else the newest one is enough. */
function wanted() {
  // the rest of the log is asked for by the view that shows it
  if (!current.view?.log) store.filter([], "info");
  const every = store.ofType("youbot/JointStatus").slice(0, 20);
  const streams = new Set([...BASE, ...store.ofType("nav_msgs/Odometry"), ...(current.view?.streams() ?? [])]);
  for (const name of every) streams.delete(name);
  return { streams: [...streams].slice(0, 40), every, log: store.logFilter };
}

let shownSystem = null;
function draw(now) {
  frame = 0;
  timer = setTimeout(wake, Math.max(FRAME, 1000 / store.rate));
  if (store.system !== shownSystem) {
    shownSystem = store.system;
    for (const it of views) it.view = null;
    follow();
    select();
  }
  const texts = forced || now - lastTexts > TEXTS;
  if (texts) { header(now); announce(now); }
  if (texts && store.recording) address();
  const happened = store.changes.steps + store.changes.log;
  const isWanted = !app.paused && !(store.onChange && happened === lastHappened && !store.recording);
  if (store.system && (isWanted || forced)) {
    lastHappened = happened;
    current.view?.draw(now, texts);
    playback?.draw(now, texts);
    if (link.subscribe(wanted())) playback?.ask();
  }
  if (texts) { lastTexts = now; forced = false; }
  link.acknowledge();
}

function key(event) {
  const inField = /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) && event.target.type !== "range";
  if (help.key(event)) return;
  if (event.key === "Escape" && inField) return event.target.blur();
  if (inField || event.ctrlKey || event.metaKey || event.altKey) return;
  const index = Number(event.key) - 1;
  if (views[index]) show(views[index].name);
  else if (event.key === " " && event.target.tagName !== "BUTTON") { if (playback) playback.key(event); else pause(); }
  else if (event.key === "[" || event.key === "]") step(event.key === "]" ? 1 : -1);
  else if (event.key === "{" || event.key === "}") change(event.key === "}" ? 1 : -1);
  else if (event.key === "/") byId("view").querySelector("input[type=search]")?.focus();
  else if (!current.view?.key?.(event) && !playback?.key(event)) {
    if (event.key === "Escape" && playback && app.range) zoom(null);
    else if (event.key === "Escape" && (store.isBack || app.range)) seek(null); else return;
  }
  event.preventDefault();
}

/** Moves the cursor to the previous or next step. @param {number} by */
function step(by) {
  const at = store.cursor ?? Infinity;
  const found = by < 0 ? store.steps.findLast((it) => it.t < at - 1e-9) : store.steps.find((it) => it.t > at + 1e-9);
  if (found) seek(by < 0 && store.cursor === null ? store.steps.at(-1).t : found.t); else if (by > 0 && !playback) seek(null);
}

/** Moves the cursor to the previous or next change of a control state, of one component or of any. @param {number} by @param {string} [component] */
function change(by, component) {
  const at = store.cursor ?? Infinity;
  const all = store.specifications.filter((it) => it.diagram && (!component || it.component === component));
  const times = all.flatMap((it) => store.controlChanges(it.component, it.diagram.location).map(({ t }) => t)).sort((one, other) => one - other);
  const found = by < 0 ? times.findLast((t) => t < at - 1e-9) : times.find((t) => t > at + 1e-9);
  if (found !== undefined) seek(found); else if (by > 0 && !playback) seek(null);
}
Object.assign(app, { step, change });

/** Adapts the page to what is shown: a running system, or a recording, which has no present and nothing to control. */
function follow() {
  playback = store.recording ? new Playback(app) : null;
  document.body.classList.toggle("recorded", !!playback);
  const place = byId("playback");
  place.hidden = !playback;
  place.replaceChildren(...(playback ? [playback.root] : []));
  byId("pause").hidden = !!playback;
  playback?.ask();
}

function build() {
  const tabs = byId("tabs");
  views.forEach((it, index) => {
    it.tab = el("button", { role: "tab", type: "button", onclick: () => show(it.name) }, el("kbd", {}, index + 1), it.title);
    tabs.append(it.tab);
  });
  tabs.addEventListener("keydown", (event) => {
    const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!by) return;
    const next = views[(views.indexOf(current) + by + views.length) % views.length];
    show(next.name);
    next.tab.focus();
  });
  byId("pause").addEventListener("click", pause);
  byId("help").addEventListener("click", () => help.toggle());
  const recolour = () => {
    forgetColours();
    for (const it of views) it.view?.recolour?.();
    redraw();
  };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", recolour);
  const theme = () => document.documentElement.dataset.theme ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  const saved = localStorage.getItem("theme");
  if (saved) document.documentElement.dataset.theme = saved;
  byId("theme").addEventListener("click", () => {
    document.documentElement.dataset.theme = theme() === "dark" ? "light" : "dark";
    localStorage.setItem("theme", document.documentElement.dataset.theme);
    recolour();
  });
  addEventListener("hashchange", () => {
    // the address of a process that was restarted has a new token
    control.token = takeToken() ?? control.token;
    select();
  });
  addEventListener("keydown", key);
  addEventListener("resize", redraw);
}

build();
// for the tests of the page, and for the console
Object.assign(globalThis, { asmotion: app });
select();
wake();
