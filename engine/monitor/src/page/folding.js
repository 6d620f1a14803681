// @ts-check
// The axis of time with idle time folded: long stretches in which nothing happened take little room.

/** Share of the range from which a stretch without events is folded, and the share that stays unfolded next to an event. */
const [LONG, MARGIN] = [0.1, 0.01];
/** Share of the axis that a folded stretch takes. */
const FOLDED = 0.04;

/** Maps times to positions from 0 to `length`, in seconds of shown time. */
export class Folding {
  /** @param {number} begin @param {number} end */
  constructor(begin, end) {
    this.begin = begin;
    this.end = Math.max(end, begin + 1e-6);
    /** Folded stretches, oldest first. @type {{ from: number, to: number }[]} */ this.folds = [];
    /** Shown seconds of a folded stretch. */ this.room = 0;
  }

  /** Folds the stretches between these times in which nothing happened. @param {number[]} times when something happened, oldest first
   * @returns {Folding} */
  fold(times) {
    const { begin, end } = this, range = end - begin;
    let last = begin;
    for (const t of times) {
      if (t > end) break;
      if (t - last > range * LONG) this.folds.push({ from: last === begin ? begin : last + range * MARGIN, to: t - range * MARGIN });
      last = Math.max(last, t);
    }
    const unfolded = this.folds.reduce((rest, { from, to }) => rest - (to - from), range);
    this.room = FOLDED * unfolded / (1 - FOLDED * this.folds.length);
    return this;
  }

  /** Shown seconds in all. */
  get length() { return this.to(this.end); }

  /** The position of a time. @param {number} t */
  to(t) {
    let position = t - this.begin;
    for (const { from, to } of this.folds) {
      if (t <= from) break;
      position -= Math.min(t, to) - from;
      position += (Math.min(t, to) - from) / (to - from) * this.room;
    }
    return position;
  }

  /** The time at a position. @param {number} position */
  from(position) {
    let t = this.begin + position;
    for (const { from, to } of this.folds) {
      if (t <= from) break;
      const inside = t - from;
      t = inside < this.room ? from + inside / this.room * (to - from) : t + (to - from) - this.room;
    }
    return t;
  }

  /** Whether a time lies in a folded stretch. @param {number} t */
  hides(t) { return this.folds.some(({ from, to }) => t > from && t < to); }
}
