// The columns of a campaign, and axes of its plots.

const LOST = 65535, STEPS = 65534;

/** Return the values of a column; NaN for a run without one. */
function valuesOf(column) {
  if (!column.values) {
    const codes = new Uint16Array(bytesOf(textOf(column.id)));
    const scale = (column.high - column.low) / STEPS;
    column.values = Float64Array.from(codes, (code) => (code === LOST ? NaN : column.low + code * scale));
  }
  return column.values;
}

/** Return the name of a column with its unit, if it has one. */
function labelOf(column) {
  return column.unit && column.unit !== "1" ? `${column.name} [${column.unit}]` : column.name;
}

/** Return the numbers of a system's runs. */
function numbersOf(system) {
  if (!system.numberValues) system.numberValues = new Int32Array(bytesOf(textOf(system.numbers)));
  return system.numberValues;
}

/** Return an axis between two values: positions, ticks with texts; logarithmic over more than two decades. */
function axisOf(low, high, from, to, { logarithmic = false, most = 5 } = {}) {
  if (!(high > low)) [low, high] = [low - (Math.abs(low) * 0.05 || 1), high + (Math.abs(high) * 0.05 || 1)];
  const log = logarithmic && low > 0 && high / low > 100;
  const [a, b] = log ? [Math.log10(low), Math.log10(high)] : [low, high];
  const at = (value) => from + ((log ? Math.log10(value) : value) - a) / (b - a) * (to - from);
  const value = (position) => { const v = a + (position - from) / (to - from) * (b - a); return log ? 10 ** v : v; };
  const ticks = log ? logarithmicTicks(a, b) : [];
  if (!log) {
    const step = stepFor(b - a, most);
    for (let k = Math.ceil(a / step); k * step <= b + 1e-9 * step; k++) ticks.push([k * step, formatNumber(Number((k * step).toPrecision(12)))]);
  }
  return { at, value, ticks, log, low, high };
}

/** Draw the axes of a plot: ticks, grid, and what is along x. */
function drawFrame(pen, frame, x, y, label) {
  const { ink, grid, rule } = colours();
  pen.lineWidth = 1;
  pen.fillStyle = ink;
  pen.strokeStyle = grid;
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  for (const [value, text] of y.ticks) {
    stroke(pen, [[frame.left, y.at(value)], [frame.right, y.at(value)]]);
    pen.fillText(text, frame.left - 5, y.at(value));
  }
  pen.textAlign = "center";
  pen.textBaseline = "top";
  for (const [value, text] of x.ticks) {
    stroke(pen, [[x.at(value), frame.top], [x.at(value), frame.bottom]]);
    pen.fillText(text, x.at(value), frame.bottom + 5);
  }
  pen.textAlign = "right";
  pen.fillText(label, frame.right, frame.bottom + 19);
  pen.strokeStyle = rule;
  stroke(pen, [[frame.left, frame.top], [frame.left, frame.bottom], [frame.right, frame.bottom]]);
}

/** Draw a line through points. */
function stroke(pen, points) {
  pen.beginPath();
  for (const [x, y] of points) pen.lineTo(x, y);
  pen.stroke();
}
