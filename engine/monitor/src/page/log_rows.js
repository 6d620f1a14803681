// @ts-check
// The rows of the log: entries that pass a filter, with repetitions counted. A new entry costs the same however many there are.

/** Limit on the rows; the oldest ones go. */
const MOST = 100000;
/** An entry, how often it has occurred, and since when. @typedef {{ key: string, it: any, times: number, since: number }} Row */

/** Kinds of entries that repeat as long as a system works. */
const ROUTINE = new Set(["step", "call", "reply", "message"]);

export class Rows {
  /** @param {any} store @param {{ fold: boolean, passes: (it: any) => boolean }} options */
  constructor(store, options) {
    this.store = store;
    this.options = options;
    /** Rows up to the last entry that is not routine, oldest first. @type {Row[]} */ this.head = [];
    /** The newest of the routine entries after it that say the same, by what they say, in order. @type {Map<string, Row>} */ this.tail = new Map();
    /** The same as a list; null if it has to be made. @type {Row[] | null} */ this.recent = [];
    /** Number of entries that have passed, and of rows that have gone. */
    this.passed = 0; this.dropped = 0;
  }

  get count() { return this.head.length + this.tail.size; }

  /** Takes the next entry. @param {any} it */
  add(it) {
    if (!this.options.passes(it)) return;
    this.passed++;
    const row = { key: it.key, it, times: 1, since: it.t };
    const isRoutine = this.options.fold && it.level === "info" && ROUTINE.has(it.kind) && !isControl(this.store, it);
    this.recent = null;
    if (isRoutine) {
      const key = (it.same ??= `${it.kind} ${it.component} ${subject(it)}`);
      const known = this.tail.get(key);
      if (known) [row.times, row.since] = [known.times + 1, known.since];
      this.tail.delete(key);
      this.tail.set(key, row);
      return;
    }
    for (const routine of this.tail.values()) this.head.push(routine);
    this.tail.clear();
    this.head.push(row);
    if (this.head.length > MOST) this.dropped += this.head.splice(0, this.head.length - MOST + MOST / 10).length;
  }

  get last() { return (this.recent ??= [...this.tail.values()]); }

  /** The row with this number from the oldest one. @param {number} index */
  at(index) { return index < this.head.length ? this.head[index] : this.last[index - this.head.length]; }

  /** Rows by their numbers from the newest one. @param {number} first @param {number} end @returns {{ row: Row, index: number }[]} */
  newest(first, end) {
    const rows = [];
    for (let index = Math.max(0, first); index < Math.min(end, this.count); index++) rows.push({ row: this.at(this.count - 1 - index), index });
    return rows;
  }

  /** Number of a row from the newest one; -1 if it has gone. @param {Row} row */
  indexOf(row) {
    const recent = this.last.indexOf(row);
    const index = recent >= 0 ? this.head.length + recent : this.head.lastIndexOf(row);
    return index < 0 ? -1 : this.count - 1 - index;
  }

  /** The newest row up to a time. @param {number} t */
  near(t) {
    for (let index = this.count - 1; index >= 0; index--) if (this.at(index).it.t <= t + 1e-9) return this.at(index);
    return null;
  }

  /** The row with this key. @param {string} key */
  find(key) { return this.last.find((it) => it.key === key) ?? this.head.findLast((it) => it.key === key) ?? null; }
}

/** The text of an entry. */
export function entryText(it) {
  if (it.kind !== "step") return it.text;
  const changed = it.step.updates.filter((update) => update.before !== update.after);
  const words = changed.map((update) => `${update.location} := ${update.after}`).join(", ");
  return `${it.step.number}: ${words || "changed nothing"}`;
}

/** Whether a step changes a control state. */
export function isControl(store, it) {
  if (it.kind !== "step") return false;
  const location = store.specifications.find((known) => known.component === it.component)?.diagram?.location;
  return it.step.updates.some((update) => update.location === location && update.before !== update.after);
}

/** What an entry is about, without its values. */
function subject(it) {
  return it.kind === "step" ? it.step.updates.filter((update) => update.before !== update.after).map((update) => update.location).join() : it.text.split(" ")[0];
}
