// @ts-check
// What is wrong with a system, in words.

/** @typedef {{ level: string, text: string, component?: string }} Finding */

/** Number of messages that wait from which this is a finding. */
const MANY = 10;

/** What is wrong at the shown time, the worst first. @param {import("./store.js").Store} store @returns {Finding[]} */
export function findings(store) {
  const all = [...links(store), ...store.warnings.map((text) => ({ level: "bad", text })), ...components(store), ...silent(store), ...unpublished(store)];
  if (store.lost) all.push({ level: "note", text: `${store.lost} events were not observed: the machine is overloaded` });
  const order = ["bad", "note", "hint"];
  return all.sort((one, other) => order.indexOf(one.level) - order.indexOf(other.level));
}

/** Connections to brokers over which nothing is sent. @param {import("./store.js").Store} store @returns {Finding[]} */
function links(store) {
  return store.links.map((it) => ({ level: "bad", text: broken(it) }));
}

/** A connection over which nothing is sent, in words. @param {any} link */
export function broken(link) {
  const since = `for ${link.for_s.toFixed(0)} s: ${link.reason}`;
  return link.state === "blocked" ? `The broker ${link.name} has accepted nothing ${since}` : `No connection to the broker ${link.name} ${since}`;
}

/** @param {import("./store.js").Store} store @returns {Finding[]} */
function components(store) {
  const all = [];
  for (const it of store.components) {
    const add = (level, text) => all.push({ level, text, component: it.name });
    // a recording does not say in which state a component is before its first event
    if (it.state && it.state !== "Running") add("bad", `${it.name} is not running: ${it.state}`);
    if (it.late) add("note", `${it.name}: ${counted(it.late, "cycle")} exceeded the deadline`);
    if (it.overruns) add("note", `${it.name} has missed ${counted(it.overruns, "period")}`);
    for (const input of it.inputs) {
      if (input.waiting >= MANY) add("note", `${counted(input.waiting, "message")} wait at ${it.name}.${input.name}: it reads them too slowly, or not at all`);
      if (input.lost) add("note", `${it.name}.${input.name} has lost ${counted(input.lost, "message")}`);
    }
    if (it.waiting >= MANY) add("note", `${counted(it.waiting, "event")} wait in ${it.name} for a later step`);
    if (it.misfits) add("note", `${it.name} has ignored ${counted(it.misfits, "message")} with unsuitable content`);
    const inspection = new Map(it.inspection);
    const unheard = inspection.get("silent") ?? [];
    if (unheard.length) add("hint", `${it.name} has not received anything for ${unheard.join(", ")}`);
    for (const [property, steps] of Object.entries(inspection.get("violated") ?? {})) {
      add("bad", `${it.name} has violated ${property} in ${counted(steps, "step")}`);
    }
  }
  for (const [t, component, text] of store.recording?.violations ?? []) {
    if (t <= store.cursor + 1e-9) all.push({ level: "bad", text: `${component} at ${t.toFixed(2)} s: ${text}`, component });
  }
  return all;
}

/** Outputs that wrote regularly and have fallen silent, with those who wait for them.
 * @param {import("./store.js").Store} store @returns {Finding[]} */
function silent(store) {
  return store.outputs.filter((it) => it.stale).map((it) => {
    const readers = readersOf(store, it.name);
    const to = readers.length ? `; read by ${readers.join(", ")}` : "";
    const text = `${it.name} has been silent for ${((store.age(it.name) ?? 0) / 1000).toFixed(1)} s, usual rate ${it.hz?.toFixed(1)} Hz${to}`;
    return { level: "bad", text, component: it.name.slice(0, it.name.lastIndexOf(".")) };
  });
}

/** Inputs to which nothing leads, and to which nothing has come from outside either.
 * @param {import("./store.js").Store} store @returns {Finding[]} */
function unpublished(store) {
  return orphans(store).map(({ topic, input }) => (
    { level: "hint", text: `no component publishes on ${topic}, which ${input} reads, and nothing has come from outside`, component: input.slice(0, input.lastIndexOf(".")) }));
}

/** Inputs of topics without a publisher, to which nothing has come from outside.
 * @param {import("./store.js").Store} store @returns {{ topic: string, input: string }[]} */
export function orphans(store) {
  const topics = (store.presence?.topics ?? []).filter((it) => !it.publishers.length);
  const missing = topics.flatMap((topic) => topic.subscribers.map((input) => ({ topic: topic.name, input })));
  const joined = new Set((store.presence?.joined ?? []).map((it) => it.to));
  return missing.filter(({ topic, input }) => !joined.has(input) && !store.output.get(input)?.n && !store.output.get(`outside.${topic}`)?.n);
}

/** The inputs that an output leads to. @param {import("./store.js").Store} store @param {string} output @returns {string[]} */
export function readersOf(store, output) {
  const joined = (store.presence?.joined ?? []).filter((it) => it.from === output).map((it) => it.to);
  const topics = (store.presence?.topics ?? []).filter((it) => it.publishers.includes(output)).flatMap((it) => it.subscribers);
  return [...new Set([...joined, ...topics])];
}

/** The outputs that lead to an input. @param {import("./store.js").Store} store @param {string} input @returns {string[]} */
export function writersOf(store, input) {
  const joined = (store.presence?.joined ?? []).filter((it) => it.to === input).map((it) => it.from);
  const topics = (store.presence?.topics ?? []).filter((it) => it.subscribers.includes(input)).flatMap((it) => [...it.publishers, `outside.${it.name}`]);
  return [...new Set([...joined, ...topics])].filter((it) => !it.startsWith("outside.") || store.output.has(it));
}

/** @param {number} count @param {string} noun */
function counted(count, noun) { return `${count} ${noun}${count === 1 ? "" : "s"}`; }
