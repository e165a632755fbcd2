// Distribution of each metric: histogram or cumulative, systems over each other, with percentile, limits and selection.

const distributions = [];
let cumulative = false;

/** One metric of all systems. */
class Distribution {
  constructor(name) {
    this.name = name;
    this.columns = contents.systems.map((system) => system.columns.find((c) => c.kind === "metric" && c.name === name));
    this.label = labelOf(this.columns[0]);
    this.canvas = make("canvas", { className: "plot", role: "img" });
    this.legend = make("div", { className: "legend" });
    this.element = make("div", { className: "panel" }, make("header", {}, make("h3", {}, name, " ", make("small", { textContent: "share of runs" }))), this.canvas, this.legend);
    this.sorted = this.columns.map((column) => valuesOf(column).filter((v) => !Number.isNaN(v)).sort());
  }

  /** Return the range of all values, limits included where they are near. */
  range() {
    let low = Math.min(...this.columns.map((c) => c.low)), high = Math.max(...this.columns.map((c) => c.high));
    for (const column of this.columns) {
      for (const limit of column.limits.flatMap((l) => [l.most, l.least]).filter((l) => l !== null)) {
        if (limit > low - 2 * (high - low) && limit < high + 2 * (high - low)) [low, high] = [Math.min(low, limit), Math.max(high, limit)];
      }
    }
    const room = 0.02 * (high - low);
    return this.columns.every((c) => c.positive) && high / low > 100 ? [low, high] : [low - room, high + room];
  }

  draw() {
    const { pen, width, height } = penOf(this.canvas);
    const frame = { left: 52, right: width - 10, top: 10, bottom: height - 38 };
    const [low, high] = this.range();
    const x = axisOf(low, high, frame.left, frame.right, { logarithmic: this.columns.every((c) => c.positive), most: Math.max(2, width / 90) });
    const bins = Math.max(8, Math.min(60, Math.round(Math.sqrt(Math.max(...this.sorted.map((s) => s.length))))));
    const counted = this.columns.map((column, s) => (cumulative ? null : counts(this.sorted[s], x, bins, frame)));
    const most = cumulative ? 1 : Math.max(1e-9, ...counted.flatMap((c, s) => Array.from(c, (n) => n / contents.systems[s].runs)));
    const y = axisOf(0, most * (cumulative ? 1 : 1.05), frame.bottom, frame.top, { most: 4 });
    drawFrame(pen, frame, x, y, this.label);
    const palette = colours();
    this.columns.forEach((column, s) => this.drawMarks(pen, frame, x, column, palette.systems[s % 4]));
    this.columns.forEach((column, s) => {
      const runs = contents.systems[s].runs, colour = palette.systems[s % 4];
      if (cumulative) drawSteps(pen, this.sorted[s], runs, x, y, frame, colour, contents.systems[s].band);
      else drawBars(pen, counted[s], runs, y, frame, colour, contents.systems.length > 1);
    });
    const shown = selection.system, column = this.columns[shown];
    const chosen = selectedOf(shown).map((i) => valuesOf(column)[i]).filter((v) => !Number.isNaN(v)).sort((a, b) => a - b);
    if (chosen.length && cumulative) drawSteps(pen, chosen, chosen.length, x, y, frame, palette.selected, 0);
    else if (chosen.length) drawBars(pen, counts(chosen, x, bins, frame), contents.systems[shown].runs, y, frame, palette.selected, false);
    this.canvas.dataset.selected = chosen.length;
    this.canvas.dataset.runs = this.sorted.map((s) => s.length).join(",");
    this.canvas.dataset.most = this.columns.map((c) => c.high).join(",");
    this.canvas.setAttribute("aria-label", `distribution of ${this.label}: ${this.texts().join("; ")}`);
    this.legend.replaceChildren(...this.texts().map((text, s) => {
      const swatch = make("i");
      swatch.style.background = palette.systems[s % 4];
      return make("span", { className: "chip" }, swatch, text);
    }));
  }

  /** Return a line of text for each system. */
  texts() {
    return contents.systems.map((system, s) => {
      const [name, tail] = tailOf(this.columns[s]);
      const lost = system.runs - this.sorted[s].length;
      const value = tail.value === null ? `${name} lost` : `${name} ${formatNumber(tail.value)}`;
      return `${system.name}: ${value}${lost ? `, ${lost} runs without a value` : ""}`;
    });
  }

  drawMarks(pen, frame, x, column, colour) {
    const [, tail] = tailOf(column);
    const inside = (v) => v !== null && v >= x.low && v <= x.high;
    if (inside(tail.value)) {
      const [from, to] = [inside(tail.low) ? x.at(tail.low) : x.at(tail.value), inside(tail.high) ? x.at(tail.high) : frame.right];
      pen.fillStyle = colour;
      pen.globalAlpha = 0.18;
      pen.fillRect(from, frame.top, Math.max(1, to - from), frame.bottom - frame.top);
      pen.globalAlpha = 1;
      pen.strokeStyle = colour;
      pen.lineWidth = 1.5;
      stroke(pen, [[x.at(tail.value), frame.top], [x.at(tail.value), frame.bottom]]);
    }
    pen.strokeStyle = colours().limit;
    pen.setLineDash([5, 3]);
    for (const limit of column.limits.flatMap((l) => [l.most, l.least])) {
      if (inside(limit)) stroke(pen, [[x.at(limit), frame.top], [x.at(limit), frame.bottom]]);
    }
    pen.setLineDash([]);
  }
}

/** Return the percentile at the worse end of a metric, after its name. */
function tailOf(column) {
  const share = column.worse === "low" ? 0.05 : 0.95;
  return [`p${100 * share}`, column.percentiles.find((p) => p.share === share)];
}

/** Return how many values lie in each bin of an axis. */
function counts(values, x, bins, frame) {
  const found = new Uint32Array(bins);
  for (const v of values) {
    const bin = Math.floor((x.at(v) - frame.left) / (frame.right - frame.left) * bins);
    found[Math.min(bins - 1, Math.max(0, bin))] += 1;
  }
  return found;
}

function drawBars(pen, found, runs, y, frame, colour, open) {
  const wide = (frame.right - frame.left) / found.length;
  pen.fillStyle = pen.strokeStyle = colour;
  pen.globalAlpha = open ? 0.3 : 0.85;
  found.forEach((n, k) => n && pen.fillRect(frame.left + k * wide, y.at(n / runs), wide - 0.5, frame.bottom - y.at(n / runs)));
  pen.globalAlpha = 1;
  if (!open) return;
  pen.lineWidth = 1.5;
  const points = [[frame.left, frame.bottom]];
  found.forEach((n, k) => points.push([frame.left + k * wide, y.at(n / runs)], [frame.left + (k + 1) * wide, y.at(n / runs)]));
  stroke(pen, points);
}

/** Draw an empirical distribution, reduced to its steps at pixels, and the band round it. */
function drawSteps(pen, sorted, runs, x, y, frame, colour, band) {
  const points = [[frame.left, y.at(0)]];
  let k = 0;
  for (let px = Math.ceil(frame.left); px <= frame.right; px++) {
    const value = x.value(px);
    while (k < sorted.length && sorted[k] <= value) k++;
    points.push([px, k / runs]);
  }
  points[0] = [frame.left, points[1] ? points[1][1] : 0];
  pen.fillStyle = pen.strokeStyle = colour;
  if (band) {
    pen.globalAlpha = 0.18;
    pen.beginPath();
    for (const [px, share] of points) pen.lineTo(px, y.at(Math.min(1, share + band)));
    for (const [px, share] of points.slice().reverse()) pen.lineTo(px, y.at(Math.max(0, share - band)));
    pen.fill();
    pen.globalAlpha = 1;
  }
  pen.lineWidth = 1.5;
  stroke(pen, points.map(([px, share]) => [px, y.at(share)]));
}

/** Make the plots of all metrics. */
function startDistributions() {
  const place = document.getElementById("distributions");
  for (const column of contents.systems[0].columns.filter((c) => c.kind === "metric")) {
    const one = new Distribution(column.name);
    distributions.push(one);
    place.append(one.element);
  }
  for (const radio of document.querySelectorAll("input[name=kind]")) {
    radio.onchange = () => {
      cumulative = radio.value === "cumulative" && radio.checked;
      for (const one of distributions) one.draw();
    };
  }
  selection.listeners.push(() => distributions.forEach((one) => one.draw()));
}
