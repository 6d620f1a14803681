// @ts-check
// What the tab knows of the system: the counterpart of the server's feed, with bounded histories.

/** The long list of entries is for the log alone; lanes and findings need the last ones. */
const MAX_ENTRIES = 100000;
const MAX_STEPS = 1000, MAX_LOG = 2000, MAX_TRAIL = 20000, MAX_SERIES = 6000;
/** Silence after which the connection counts as lost, ms: the server sends something every 500 ms. */
const SILENT = 2000;
const NUMBERS = { NaN: NaN, Infinity: Infinity, "-Infinity": -Infinity };

export class Store {
  constructor() {
    /** @type {any} */ this.system = null;
    /** Frames per second that this tab asks for: as many as it draws. */ this.rate = 20;
    /** Whether views change only with a step or an entry of the log. */ this.onChange = false;
    /** The time of a recording that the address asks for; NaN without one. */ this.wanted = NaN;
    this.recording = null;
    this.control = false;
    /** Whether this browser has logged in to this run. */ this.known = false;
    /** @type {string[]} */ this.warnings = [];
    this.connectedSince = null;
    this.lastFrame = performance.now();
    this.reset();
  }

  reset() {
    this.t = 0;
    this.wall = 0;
    this.lost = 0;
    /** Connections to brokers over which nothing is sent. @type {any[]} */ this.links = [];
    /** @type {any} */ this.permission = "view";
    this.end = null;
    /** @type {any[]} */ this.components = [];
    this.presence = null;
    /** @type {any[]} */ this.outputs = [];
    /** @type {Map<string, any>} */ this.output = new Map();
    /** @type {Record<string, any>} */ this.states = {};
    /** Steps by component, oldest first. @type {Map<string, any[]>} */ this.history = new Map();
    /** Time since when all steps of a component are known. @type {Map<string, number>} */ this.knownSince = new Map();
    /** @type {any[]} */ this.merged = []; this.mergedAt = -1;
    /** Log entries by time; calls can be many, and do not displace the others. @type {any[]} */ this.log = [];
    /** @type {any[]} */ this.notes = []; /** @type {any[]} */ this.calls = [];
    /** Entries of a running system in the order of their arrival, and their number since the beginning. @type {any[]} */ this.entries = []; this.entryCount = 0;
    /** Number of steps since the beginning. */ this.stepCount = 0;
    /** Grows when what was known is forgotten. */ this.epoch = (this.epoch ?? 0) + 1;
    this.missed = { steps: 0, log: 0, samples: 0 };
    /** The part of the log that was asked for: the filter, and its entries by time; null if all of the log was. @type {any} */ this.found = null;
    /** The guards of the step that was asked for last. @type {any} */ this.guards = null;
    /** @type {Map<string, any>} */ this.samples = new Map();
    /** Driven paths by output: [t, x, y, yaw]. @type {Map<string, number[][]>} */ this.trails = new Map();
    /** Samples of joints by output: { t, position, … }. @type {Map<string, any[]>} */ this.series = new Map();
    /** Numbers of changes, by which views see what is new. */
    this.changes = { components: 0, outputs: 0, steps: 0, log: 0, samples: 0 };
    /** Types of ports by name. @type {Map<string, string>} */ this.types = new Map();
    /** The time that all views show; null is now, which a recording does not have. @type {number | null} */ this.cursor = null;
    /** Times of a recording between which the known steps and entries suffice. */ this.valid = [Infinity, -Infinity];
  }

  /** Whether the views show a time before the newest samples. Those of a recording are always of the time that is shown. */
  get isBack() { return this.cursor !== null && !this.recording; }

  /** The specifications; of a recording, the versions that run at the cursor. @returns {any[]} */
  get specifications() {
    const all = this.system.specifications;
    if (!this.recording) return all;
    if (this.running?.system !== this.system || this.running.t !== this.cursor) {
      const running = new Map();
      for (const it of all) if (!running.has(it.component) || it.from <= this.cursor + 1e-9) running.set(it.component, it);
      this.running = { system: this.system, t: this.cursor, specifications: [...running.values()] };
    }
    return this.running.specifications;
  }

  connected(hello) {
    const same = JSON.stringify(this.system) === JSON.stringify(hello.system);
    const cursor = same ? this.cursor : null;
    // the run may be another one: what is known of the last one is not mixed with it
    this.reset();
    /** What only a recording has. @type {any} */ this.recording = hello.system.recording ?? null;
    if (this.recording) {
      this.t = this.recording.end;
      const wanted = Number.isFinite(this.wanted) ? Math.min(this.t, Math.max(0, this.wanted)) : null;
      // what was violated is what is looked for
      this.cursor = cursor ?? wanted ?? this.recording.violations[0]?.[0] ?? this.t;
      this.trails = new Map(Object.entries(this.recording.trails));
    }
    this.restarted = this.system !== null && !same;
    this.system = hello.system;
    this.control = hello.control;
    this.known = hello.known;
    /** What is dangerous about connections, in words. @type {string[]} */ this.warnings = hello.warnings ?? [];
    this.connectedSince = performance.now();
    this.lastFrame = performance.now();
  }

  disconnected() { this.connectedSince = null; }

  /** Milliseconds without a frame, if that is too long. */
  silence(now = performance.now()) {
    const silent = now - this.lastFrame;
    return this.connectedSince === null || silent > SILENT ? silent : 0;
  }

  frame(frame) {
    this.lastFrame = performance.now();
    this.t = frame.t;
    this.wall = frame.wall;
    this.lost = frame.lost;
    this.permission = frame.control;
    this.end = frame.end;
    this.links = frame.links ?? [];
    if (frame.states) this.states = frame.states;
    if (frame.components) this.describe(frame.components);
    if (frame.outputs) {
      this.outputs = frame.outputs;
      this.output = new Map(frame.outputs.map((it) => [it.name, it]));
      this.changes.outputs++;
    }
    if (frame.history) this.recall(frame.history);
    if (frame.steps) this.step(frame);
    if (frame.log || frame.calls) this.note(frame);
    if (frame.found) this.find(frame.found);
    this.missed.log += (frame.missed_log ?? 0) + (frame.missed_calls ?? 0);
    for (const [name, batch] of Object.entries(frame.batches ?? {})) this.batch(name, batch);
    for (const [name, sample] of Object.entries(frame.samples ?? {})) this.sample(name, sample);
  }

  /** Takes the moment of a recording that is shown: samples up to then, and the steps and entries around it if they were missing. */
  moment(moment) {
    this.lastFrame = performance.now();
    this.outputs = moment.outputs;
    this.output = new Map(moment.outputs.map((it) => [it.name, it]));
    for (const [name, sample] of Object.entries(moment.samples)) {
      if (sample === null) this.samples.delete(name);
      else if ("data" in sample) this.samples.set(name, { ...sample, data: revived(sample.data) });
    }
    if (moment.window) this.window(moment.window);
    if (moment.components) this.describe(moment.components);
    this.changes.samples++;
    this.changes.outputs++;
  }

  /** Replaces steps, states and entries. An answer to a question before the filter changed is none to the present one. @param {any} window */
  window(window) {
    if (window.filter !== (this.found?.number ?? null)) return;
    this.valid = window.valid;
    this.states = window.states;
    this.history = new Map();
    for (const entry of window.history) {
      // numbers of steps begin again after a reset
      entry.key = `s${entry.component}${entry.index}`;
      if (!this.history.has(entry.component)) this.history.set(entry.component, []);
      this.history.get(entry.component).push(entry);
    }
    this.knownSince = new Map([...this.history].map(([component, steps]) => [component, steps[0].index === 0 ? 0 : steps[0].t]));
    const log = [...window.log, ...window.calls].sort((one, other) => one.t - other.t);
    if (this.found) Object.assign(this.found, { entries: log, isKnown: true });
    else this.log = log;
    const same = new Map();
    for (const it of log) {
      const words = `l${it.t} ${it.kind} ${it.component} ${it.text}`, count = same.get(words) ?? 0;
      same.set(words, count + 1);
      it.key = count ? `${words} ${count}` : words;
    }
    this.series = new Map(Object.entries(window.series).map(([name, samples]) => [name, samples.map(revived)]));
    this.changes.steps++;
    this.changes.log++;
  }

  /** Changes of the control state of a component that are known, oldest first: { t, before, after }. */
  controlChanges(component, location) {
    const recorded = this.recording?.changes[component];
    if (recorded) return recorded.map(([t, before, after]) => ({ t, before, after }));
    return this.stepsOf(component).flatMap((it) => it.step.updates.filter((update) => update.location === location && update.before !== update.after).map((update) => ({ t: it.t, ...update })));
  }

  note(frame) {
    this.notes = append(this.notes, frame.log ?? [], MAX_LOG);
    this.calls = append(this.calls, frame.calls ?? [], MAX_LOG / 2);
    this.log = [...this.notes, ...this.calls].sort((one, other) => one.t - other.t);
    this.keep([...(frame.log ?? []), ...(frame.calls ?? [])].sort((one, other) => one.t - other.t));
    this.changes.log++;
  }

  /** Keeps entries for the log, and forgets the oldest ones in one go. @param {any[]} entries */
  keep(entries) {
    for (const it of entries) { it.key = `l${this.entryCount++}`; this.entries.push(it); }
    if (this.entries.length > MAX_ENTRIES * 1.1) this.entries.splice(0, this.entries.length - MAX_ENTRIES);
  }

  /** Number of entries that the log has received, of the part that was asked for. */
  get logCount() { return this.found ? this.found.count : this.entryCount; }

  /** Entries of the log after the first ones, which are known; -1 for all. Of a part of the log, what the server does not keep any more
   * is found among those that are here. @param {number} known @returns {any[]} */
  entriesSince(known) {
    if (this.recording) return known < 0 ? this.found?.entries ?? this.log : [];
    const { found } = this;
    const entries = found?.entries ?? this.entries;
    if (known >= 0) return entries.slice(Math.max(0, entries.length - (this.logCount - known)));
    if (!found) return entries;
    const oldest = entries[0]?.t ?? Infinity;
    return [...this.entries.filter((it) => it.t < oldest), ...entries];
  }

  /** Steps that have arrived after the first ones, which are known; -1 for all. @param {number} known @returns {any[]} */
  stepsSince(known) {
    if (this.recording) return known < 0 ? this.steps : [];
    const all = [];
    for (const steps of this.history.values()) for (let index = steps.length - 1; index >= 0 && steps[index].arrival > known; index--) all.push(steps[index]);
    return all;
  }

  /** Takes entries of the part of the log that was asked for. Those of an earlier question are not wanted any more. */
  find({ filter, entries }) {
    if (filter !== this.found?.number) return;
    const { found } = this;
    for (const it of entries.sort((one, other) => one.t - other.t)) { it.key = `f${filter} ${found.count++}`; found.entries.push(it); }
    if (found.entries.length > MAX_ENTRIES * 1.1) found.entries.splice(0, found.entries.length - MAX_ENTRIES);
    found.isKnown = true;
    this.changes.log++;
  }

  /** Takes the guards of a step, which were asked for. */
  explain(guards) {
    this.guards = guards;
    this.changes.steps++;
  }

  /** Asks for a part of the log; without words and level, for all of it. The words are those of the filter.
   * @param {string[]} words @param {string} level */
  filter(words, level) {
    const asked = words.length || level !== "info" ? JSON.stringify([words, level]) : "";
    if (asked === (this.found?.asked ?? "")) return;
    this.questions = (this.questions ?? 0) + 1;
    this.found = asked ? { asked, number: this.questions, words, level, entries: [], count: 0, isKnown: false } : null;
    // the window of a recording has another part of the log now
    this.valid = [Infinity, -Infinity];
    this.changes.log++;
  }

  /** The part of the log to ask for; null for all of it. */
  get logFilter() {
    return this.found && { number: this.found.number, level: this.found.level, words: this.found.words };
  }

  describe(presence) {
    this.presence = presence;
    this.components = presence.components;
    for (const component of presence.components) {
      for (const port of [...component.inputs, ...component.outputs]) this.types.set(`${component.name}.${port.name}`, port.type);
    }
    for (const it of presence.components) this.read(it.name, Object.fromEntries(it.inspection));
    this.changes.components++;
  }

  /** Takes the inputs that the last step of a specification has read: a step that writes nothing is not reported. */
  read(component, status) {
    const locations = this.states[component]?.locations;
    if (!locations || !status.read) return;
    for (const [location, value] of Object.entries(status.read)) {
      if ((locations[location]?.step ?? 0) <= status.step) locations[location] = { value, monitored: true, step: status.step, t: this.t };
    }
  }

  step(frame) {
    this.missed.steps += frame.missed_steps ?? 0;
    for (const entry of frame.steps) {
      this.remember(entry);
      const state = (this.states[entry.component] ??= { locations: {}, heat: {}, step: 0 });
      // the states that come with the first frame already contain the steps that come with it
      if (entry.step.number <= state.step) continue;
      state.step = entry.step.number;
      for (const [location, value] of entry.step.inputs) {
        state.locations[location] = { value, monitored: true, step: entry.step.number, t: entry.t };
      }
      for (const update of entry.step.updates) {
        state.locations[update.location] = { value: update.after, monitored: false, step: entry.step.number, t: entry.t };
        state.heat[update.place] = (state.heat[update.place] ?? 0) + 1;
      }
    }
    this.changes.steps++;
  }

  /** Takes the last steps of each specification, and notes since when all of them are known. */
  recall(history) {
    for (const entry of history) this.remember(entry);
    for (const [component, steps] of this.history) {
      const complete = (this.states[component]?.reported ?? 0) <= steps.length;
      this.knownSince.set(component, complete ? 0 : steps[0].t);
    }
  }

  remember(entry) {
    const steps = this.history.get(entry.component) ?? [];
    this.history.set(entry.component, steps);
    if (steps.length && steps.at(-1).step.number >= entry.step.number) return;
    steps.push(entry);
    entry.arrival = ++this.stepCount;
    if (steps.length > MAX_STEPS) { steps.splice(0, MAX_STEPS / 4); this.knownSince.set(entry.component, steps[0].t); }
    this.changes.steps++;
  }

  /** The steps of all components, oldest first. */
  get steps() {
    if (this.mergedAt !== this.changes.steps) {
      this.mergedAt = this.changes.steps;
      this.merged = [...this.history.values()].flat().sort((one, other) => one.t - other.t);
    }
    return this.merged;
  }

  /** Takes all samples of an output since the last frame. */
  batch(name, { n, type, missed, samples }) {
    this.missed.samples += missed;
    samples.forEach(([t, data], index) => this.sample(name, { n: n - samples.length + 1 + index, t, type, data }));
  }

  sample(name, sample) {
    sample.type ||= this.types.get(name) ?? "";
    sample.data = revived(sample.data);
    this.samples.set(name, sample);
    this.changes.samples++;
    if (sample.type === "nav_msgs/Odometry") {
      const { position, orientation } = sample.data.pose.pose;
      const trail = this.trails.get(name) ?? [];
      this.trails.set(name, trail);
      const last = trail.at(-1);
      if (!last || sample.t - last[0] > 0.2 || Math.hypot(position.x - last[1], position.y - last[2]) > 0.05) {
        trail.push([sample.t, position.x, position.y, yaw(orientation)]);
        if (trail.length > MAX_TRAIL) trail.splice(0, MAX_TRAIL / 4);
      }
    }
    if (sample.type === "youbot/JointStatus") {
      const series = this.series.get(name) ?? [];
      this.series.set(name, series);
      series.push({ t: sample.t, ...sample.data });
      if (series.length > MAX_SERIES) series.splice(0, MAX_SERIES / 4);
    }
  }

  /** Values of a location by time, oldest first, as far as its steps are known. @param {string} component @param {string} location
   * @returns {[number, string][]} */
  valuesOf(component, location) {
    const values = [];
    for (const { t, step } of this.stepsOf(component)) {
      const update = step.updates.find((it) => it.location === location);
      if (update && !values.length) values.push([this.knownSince.get(component) ?? t, update.before]);
      const value = update?.after ?? step.inputs.find((it) => it[0] === location)?.[1];
      if (value !== undefined) values.push([t, value]);
    }
    return values;
  }

  /** Names of the ports of a type that have written or been written. @param {string} type */
  ofType(type) {
    const found = this.outputs.filter((it) => (it.type || this.types.get(it.name)) === type);
    return found.map((it) => it.name);
  }

  /** Time since the newest sample of an output, ms: as the server says, and since then; null before the first one. @param {string} name */
  age(name) {
    const age = this.output.get(name)?.age_ms ?? null;
    // the age in a recording is that at the shown time
    return age === null || this.recording ? age : age + (performance.now() - this.lastFrame);
  }

  /** Whether what an output says may be outdated. @param {string} name */
  isStale(name) {
    return !!this.output.get(name)?.stale || this.silence() > 0;
  }

  /** Steps of a component that are still known, oldest first. @param {string} component */
  stepsOf(component) { return this.history.get(component) ?? []; }

  /** The step of a component at the cursor: the last one up to then; the newest one without a cursor. */
  stepAt(component, cursor = this.cursor) {
    const steps = this.stepsOf(component);
    if (cursor === null) return steps.at(-1);
    return steps.findLast((it) => it.t <= cursor + 1e-9);
  }

  /** Restores the values before a step, as far as it has changed them. */
  undo(step, locations) {
    for (const update of step.updates) locations[update.location] = { value: update.before, monitored: false, step: null, t: null };
    for (const [location] of step.inputs) delete locations[location];
  }

  /** The values of all locations at the cursor, from the present ones by undoing later steps. @param {string} component */
  locationsAt(component, cursor = this.cursor) {
    const state = this.states[component];
    if (!state) return {};
    let locations = { ...state.locations };
    if (cursor === null) return locations;
    const steps = this.stepsOf(component);
    let index = steps.length - 1;
    for (; index >= 0 && steps[index].t > cursor + 1e-9; index--) {
      // a machine began with this step: the state before it does not follow from that of the next one
      const before = steps[index].before?.locations;
      if (before) locations = { ...before };
      else this.undo(steps[index].step, locations);
    }
    let first = Math.max(0, index - 30);
    for (let begun = index; begun > first; begun--) if (steps[begun].before) first = begun;
    for (const { step, t } of steps.slice(first, index + 1)) {
      for (const [location, value] of step.inputs) locations[location] = { value, monitored: true, step: step.number, t };
      for (const update of step.updates) locations[update.location] = { value: update.after, monitored: false, step: step.number, t };
    }
    return locations;
  }
}

function append(list, entries, limit) {
  const all = list.concat(entries);
  return all.length > limit ? all.slice(all.length - limit) : all;
}

/** Undoes the compact forms of the server: runs of integers, and numbers that JSON lacks. */
function revived(value) {
  if (typeof value === "string") return value in NUMBERS ? NUMBERS[value] : value;
  if (Array.isArray(value)) return value.map(revived);
  if (value === null || typeof value !== "object") return value;
  if (Array.isArray(value.rle)) return runs(value.rle);
  return Object.fromEntries(Object.entries(value).map(([name, it]) => [name, revived(it)]));
}

function runs(rle) {
  let count = 0;
  for (let at = 1; at < rle.length; at += 2) count += rle[at];
  const all = new Int32Array(count);
  for (let at = 0, to = 0; at < rle.length; at += 2) { all.fill(rle[at], to, to + rle[at + 1]); to += rle[at + 1]; }
  return all;
}

/** The angle of a quaternion about the vertical axis, rad. */
export function yaw({ x = 0, y = 0, z = 0, w = 1 }) {
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}
