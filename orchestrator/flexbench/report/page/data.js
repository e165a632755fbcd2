// The histories of the page: decoded when first drawn, and reduced without losing a peak.

/** Start times of rows, or of intervals of rows: uniform, or one by one. */
class TimeBase {
  constructor(base) {
    this.count = base.count;
    this.start = base.start;
    this.step = base.step;
    this.end = base.end;
    this.times = base.times ? new Float64Array(bytesOf(base.times)) : null;
  }

  at(i) {
    if (i >= this.count) return this.end;
    return this.times ? this.times[i] : this.start + i * this.step;
  }

  /** Return the last index that starts at or before a time, at least 0. */
  before(time) {
    if (!this.times) {
      if (!(this.step > 0)) return 0;
      return Math.min(this.count - 1, Math.max(0, Math.floor((time - this.start) / this.step + 1e-9)));
    }
    let low = 0, high = this.count - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.times[middle] <= time) low = middle; else high = middle - 1;
    }
    return low;
  }
}

/** One line: its samples or extremes, and coarser levels of extremes, each with intervals twice as wide. */
class History {
  constructor(about, base, run) {
    Object.assign(this, { ...about, base, run, levels: null, whole: null });
  }

  load() {
    if (this.levels) return;
    const { count } = this.base;
    let low, high;
    if (this.constant !== undefined) {
      low = high = new Float32Array(count).fill(this.constant);
    } else {
      if (this.kind === "samples") low = high = new Float32Array(bytesOf(textOf(this.id)));
      else {
        const shares = new Uint16Array(bytesOf(textOf(this.id)));
        const value = (share) => !this.logarithmic ? this.least + share * this.step
          : share ? Math.exp(this.least + (share - 1) * this.step) : 0;
        low = new Float64Array(count);
        high = new Float64Array(count);
        for (let i = 0; i < count; i++) { low[i] = value(shares[2 * i]); high[i] = value(shares[2 * i + 1]); }
      }
    }
    this.levels = [{ low, high, width: 1 }];
    while (low.length > 256) {
      const size = Math.ceil(low.length / 2);
      const nextLow = new Float64Array(size), nextHigh = new Float64Array(size);
      for (let i = 0; i < size; i++) {
        let least = Infinity, most = -Infinity;
        for (let k = 2 * i; k < Math.min(low.length, 2 * i + 2); k++) {
          if (low[k] < least) least = low[k];
          if (high[k] > most) most = high[k];
        }
        nextLow[i] = least;
        nextHigh[i] = most;
      }
      low = nextLow;
      high = nextHigh;
      this.levels.push({ low, high, width: 2 * this.levels[this.levels.length - 1].width });
    }
  }

  /** Return the window with every row that holds two times, with the samples of the line; null without one. */
  fullRate(from, to) {
    if (this.full === undefined) return null;
    if (!this.whole) {
      const raw = new Float32Array(bytesOf(textOf(this.full)));
      let start = 0;
      this.whole = fullRateBases[this.run].map((base) => ({ base, values: raw.subarray(start, (start += base.count)) }));
    }
    const room = 1e-9 * Math.abs(to);
    return this.whole.find(({ base }) => from >= base.at(0) - room && to <= base.end + room) ?? null;
  }

  /** Return whether every recorded row is drawn between two times. */
  complete(from, to) {
    return this.constant !== undefined || this.kind === "samples" || this.fullRate(from, to) !== null;
  }

  /** Return the finest level with at most `most` intervals between two times, and the range of those intervals. */
  part(from, to, most) {
    const whole = this.fullRate(from, to);
    if (whole && whole.base.before(to) - whole.base.before(from) <= most) {
      const { base, values } = whole;
      const end = Math.min(values.length - 1, base.before(to) + 1);
      return { low: values, high: values, width: 1, begin: Math.max(0, base.before(from) - 1), end, time: (i) => base.at(i) };
    }
    this.load();
    const first = this.base.before(from), last = this.base.before(to);
    const level = this.levels.find((l) => (last - first) / l.width <= most) ?? this.levels[this.levels.length - 1];
    const begin = Math.max(0, Math.floor(first / level.width) - 1);
    const end = Math.min(level.low.length - 1, Math.ceil(last / level.width) + 1);
    return { ...level, begin, end, time: (i) => this.time(i, level.width) };
  }

  /** Return the middle of an interval of a level, or the time of a sample. */
  time(i, width) {
    const start = this.base.at(i * width);
    if (width === 1 && this.kind !== "extremes") return start;
    return 0.5 * (start + this.base.at((i + 1) * width));
  }

  /** Return minimum and maximum of the interval at a time, or null outside the record. */
  valueAt(time) {
    if (time < this.base.at(0) || time > this.base.end) return null;
    const whole = this.fullRate(time, time);
    if (whole) {
      const value = whole.values[whole.base.before(time)];
      return [value, value];
    }
    this.load();
    const i = this.base.before(time);
    return [this.levels[0].low[i], this.levels[0].high[i]];
  }
}

// of each run, the times of its windows with every row
const fullRateBases = contents.runs.map((run) => (run.windows ?? []).map((window) => new TimeBase(window.time)));
// the histories of all runs by group, in the order of the page
const groups = new Map();
for (const [run, about] of contents.runs.entries()) {
  for (const part of about.parts) {
    const base = new TimeBase(part.time);
    for (const history of part.histories) {
      if (!groups.has(history.group)) {
        groups.set(history.group, { name: history.group, ...contents.groups[history.group], lines: [] });
      }
      groups.get(history.group).lines.push(new History(history, base, run));
    }
  }
}
const wholeTime = { from: Infinity, to: 1e-9 };
for (const group of groups.values()) {
  for (const line of group.lines) {
    wholeTime.from = Math.min(wholeTime.from, line.base.at(0));
    wholeTime.to = Math.max(wholeTime.to, line.base.end);
  }
}
if (!(wholeTime.from < wholeTime.to)) wholeTime.from = wholeTime.to - 1;

const SERIES = LIGHT.series.length;
const RUN_DASHES = [[], [7, 3], [2, 2]];
const runOrder = contents.runs.map((run, i) => i).sort((a, b) => Number(contents.runs[b].shown) - Number(contents.runs[a].shown));

/** Return colour and dashes of a run: those shown from the start come first. */
function lookOf(run) {
  const rank = runOrder.indexOf(run);
  return { colour: colours().series[rank % SERIES], dashes: RUN_DASHES[Math.floor(rank / SERIES) % RUN_DASHES.length] };
}

/** Return the colour of one of `count` lines: from a cycle, or for many from dark blue to yellow-green. */
function colourOf(i, count) {
  if (count <= SERIES) return colours().series[i % SERIES];
  const share = i / (count - 1);
  const lightness = colours() === DARK ? 62 + 12 * share : 28 + 26 * share;
  return `hsl(${265 - 200 * share} ${60 + 15 * share}% ${lightness}%)`;
}
