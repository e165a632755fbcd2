// Draw axes, lines and marks of one plot on a canvas.

const MARGIN = { left: 62, right: 10, top: 16, bottom: 24 }; // px

/** Return the scale of the value axis, from the smallest visible value (share 0) to the largest (1), and its ticks. */
function valueAxis(lines, parts, logarithmic) {
  let least = Infinity, most = -Infinity, smallest = Infinity;
  parts.forEach((part, k) => {
    for (let i = part.begin; i <= part.end; i++) {
      const time = part.time(i);
      if (part.end - part.begin > 4 && (time < view.from || time > view.to)) continue;
      if (part.low[i] < least) least = part.low[i];
      if (part.high[i] > most) most = part.high[i];
      if (part.high[i] > 0 && part.high[i] < smallest) smallest = part.high[i];
    }
  });
  if (!(least <= most)) [least, most] = [0, 1];
  if (logarithmic && most > 0) {
    const low = Math.log10(Math.max(Math.min(smallest, most) * 0.8, most * 1e-6)), high = Math.log10(most * 1.2);
    return { least, most, ticks: logarithmicTicks(low, high), share: (v) => (Math.log10(Math.max(v, 1e-300)) - low) / (high - low) };
  }
  const largest = most;
  const room = most > least ? 0.06 * (most - least) : Math.abs(most) * 0.1 || 1;
  least -= least === 0 && most > 0 ? 0 : room;
  most += room;
  const step = stepFor(most - least, 5);
  const size = Math.max(Math.abs(least), Math.abs(most));
  let power = Math.floor(Math.log10(size));
  if (power > -3 && power < 5) power = 0;
  const decimals = Math.max(0, Math.min(12, power - Math.floor(Math.log10(step) + 1e-9)));
  const ticks = [];
  for (let k = Math.ceil(least / step); k * step <= most; k++) ticks.push([k * step, (k * step / 10 ** power).toFixed(decimals).replace(/^-(0\.?0*)$/, "$1")]);
  return { least, most: largest, ticks, power, share: (v) => (v - least) / (most - least) };
}

function drawAxes(pen, frame, axis, x, y) {
  const bottom = frame.top + frame.height;
  pen.lineWidth = 1;
  pen.strokeStyle = colours().grid;
  pen.fillStyle = colours().ink;
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  for (const [value, text] of axis.ticks) {
    line(pen, frame.left, y(value), frame.left + frame.width, y(value));
    pen.fillText(text, frame.left - 6, y(value));
  }
  pen.textAlign = "center";
  pen.textBaseline = "top";
  const step = stepFor(view.to - view.from, frame.width / 80);
  const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  for (let k = Math.ceil(view.from / step); k * step <= view.to * (1 + 1e-12); k++) {
    line(pen, x(k * step), frame.top, x(k * step), bottom);
    if (x(k * step) < frame.left + frame.width - 62) pen.fillText((k * step).toFixed(decimals), x(k * step), bottom + 5);
  }
  pen.textAlign = "left";
  if (axis.power) {
    pen.textBaseline = "bottom";
    pen.textAlign = "right";
    pen.fillText(`×${powerOfTen(axis.power)}`, frame.left - 6, frame.top - 2);
  }
  pen.textAlign = "right";
  pen.textBaseline = "top";
  pen.fillText("time [s]", frame.left + frame.width, bottom + 5);
  pen.strokeStyle = colours().rule;
  line(pen, frame.left, frame.top, frame.left, bottom);
  line(pen, frame.left, bottom, frame.left + frame.width, bottom);
}

function line(pen, x1, y1, x2, y2) {
  pen.beginPath();
  pen.moveTo(x1, y1);
  pen.lineTo(x2, y2);
  pen.stroke();
}

/**
 * Draw one line through its samples, or the band between minimum and maximum of each interval; return the point count.
 * A band is light between its edges, so that it is not taken for a line that fills it.
 */
function drawLine(pen, part, x, y) {
  const { low, high, begin, end } = part;
  let points = 0;
  const edge = (values) => {
    for (let i = begin; i <= end; i++) pen.lineTo(x(part.time(i)), y(values[i]));
  };
  for (let i = begin; i <= end; i++) points += low[i] === high[i] ? 1 : 2;
  if (points > end - begin + 1) {
    const { globalAlpha } = pen;
    pen.beginPath();
    edge(high);
    for (let i = end; i >= begin; i--) pen.lineTo(x(part.time(i)), y(low[i]));
    pen.globalAlpha = 0.3 * globalAlpha;
    pen.fillStyle = pen.strokeStyle;
    pen.fill();
    pen.globalAlpha = globalAlpha;
    pen.beginPath();
    edge(low);
    pen.stroke();
  }
  pen.beginPath();
  edge(high);
  pen.stroke();
  return points;
}

function drawMark(pen, frame, at, mark) {
  pen.strokeStyle = pen.fillStyle = mark.kind === "fault" ? colours().limit : colours().cursor;
  pen.lineWidth = 1;
  pen.setLineDash([6, 2, 1, 2]);
  line(pen, at, frame.top, at, frame.top + frame.height);
  pen.setLineDash([]);
  pen.textAlign = "left";
  pen.textBaseline = "top";
  if (!mark.text) return;
  pen.strokeStyle = `${colours().paper}d9`; // so that lines behind do not strike through the text
  pen.lineWidth = 3;
  pen.strokeText(mark.text, at + 3, frame.top + 2);
  pen.fillText(mark.text, at + 3, frame.top + 2);
}
