// Scatter matrix of one system: points below the diagonal, histograms on it, rank correlations above; a rectangle selects.

const FIRST_METRICS = 3, FIRST_INPUTS = 3, MOST_VARIABLES = 8;
const matrix = { chosen: new Set(), cells: [], brush: null, ranks: new Map(), waiting: false };

/** Return the system whose runs the matrix shows. */
function shownSystem() {
  return contents.systems[selection.system];
}

/** Return the columns that the matrix shows. */
function shownColumns() {
  return shownSystem().columns.filter((column) => matrix.chosen.has(`${column.kind}.${column.name}`));
}

/** Return where a value of a column lies in a cell, 0 to 1; the axis is logarithmic over more than two decades. */
function shareOf(column, value) {
  if (column.high === column.low) return 0.5;
  if (column.positive && column.high / column.low > 100) return Math.log(value / column.low) / Math.log(column.high / column.low);
  return (value - column.low) / (column.high - column.low);
}

/** Return ranks of the values of a column; NaN where there is none. */
function ranksOf(column) {
  if (!matrix.ranks.has(column)) {
    const values = valuesOf(column);
    const order = Array.from(values.keys()).filter((i) => !Number.isNaN(values[i])).sort((a, b) => values[a] - values[b]);
    const ranks = new Float64Array(values.length).fill(NaN);
    for (let k = 0; k < order.length;) {
      let end = k;
      while (end + 1 < order.length && values[order[end + 1]] === values[order[k]]) end++;
      for (let j = k; j <= end; j++) ranks[order[j]] = 0.5 * (k + end);
      k = end + 1;
    }
    matrix.ranks.set(column, ranks);
  }
  return matrix.ranks.get(column);
}

/** Return Spearman's rank correlation of two columns, NaN if one does not vary or has categories. */
function correlation(a, b) {
  if (a.categories || b.categories) return NaN;
  const x = ranksOf(a), y = ranksOf(b);
  let n = 0, sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
  for (let i = 0; i < x.length; i++) {
    if (Number.isNaN(x[i]) || Number.isNaN(y[i])) continue;
    n += 1; sx += x[i]; sy += y[i]; sxx += x[i] * x[i]; syy += y[i] * y[i]; sxy += x[i] * y[i];
  }
  return (n * sxy - sx * sy) / Math.sqrt((n * sxx - sx * sx) * (n * syy - sy * sy));
}

/** One cell below the diagonal, or on it. */
class Cell {
  constructor(row, column) {
    this.row = row;
    this.column = column;
    this.diagonal = row === column;
    const name = this.diagonal ? `histogram of ${row.name}` : `${row.name} over ${column.name}`;
    this.canvas = make("canvas", { className: this.diagonal ? "diagonal" : "", role: "img" });
    this.canvas.setAttribute("aria-label", name);
    this.canvas.dataset.cell = this.diagonal ? row.name : `${row.name}/${column.name}`;
    if (this.diagonal) return;
    this.canvas.tabIndex = 0;
    this.canvas.onpointerdown = (event) => this.begin(event);
    this.canvas.onpointermove = (event) => this.move(event);
    this.canvas.onpointerup = this.canvas.onpointercancel = () => { this.from = null; };
    this.canvas.onkeydown = (event) => this.key(event);
  }

  /** Draw all points once; they do not change with the selection. */
  drawBase() {
    const { pen, width, height } = penOf(this.canvas);
    const palette = colours();
    if (this.diagonal) {
      this.drawHistogram(pen, width, height, palette);
    } else {
      pen.fillStyle = palette.systems[selection.system % 4];
      pen.globalAlpha = Math.max(0.15, Math.min(0.8, 300 / shownSystem().runs));
      this.points(width, height, null, (px, py) => pen.fillRect(px - 1, py - 1, 2, 2));
    }
    this.base = document.createElement("canvas");
    this.base.width = this.canvas.width;
    this.base.height = this.canvas.height;
    this.base.getContext("2d").drawImage(this.canvas, 0, 0);
    this.drawSelection();
  }

  drawHistogram(pen, width, height, palette) {
    const categories = this.row.categories, count = categories ? categories.length : 24;
    const bins = new Uint32Array(count);
    for (const v of valuesOf(this.row)) if (!Number.isNaN(v)) bins[Math.min(count - 1, Math.floor(shareOf(this.row, v) * count))] += 1;
    const most = Math.max(1, ...bins), room = height - 34, gap = categories ? 4 : 0.5;
    pen.fillStyle = palette.systems[selection.system % 4];
    bins.forEach((n, k) => pen.fillRect(k * width / count, height - room * n / most, width / count - gap, room * n / most));
    pen.fillStyle = palette.ink;
    pen.textAlign = "center";
    pen.font = "bold 12px system-ui, sans-serif";
    pen.fillText(this.row.name, width / 2, 13, width - 4);
    pen.font = "11px system-ui, sans-serif";
    if (categories) {
      pen.fillText(`${count} texts`, width / 2, 27, width - 4);
      if (count > 8) return;
      categories.forEach((text, k) => pen.fillText(text, (k + 0.5) * width / count, height - 4, width / count - 2));
      return;
    }
    pen.fillText(`${formatNumber(this.row.low, 3)} to ${formatNumber(this.row.high, 3)} ${this.row.unit === "1" ? "" : this.row.unit}`, width / 2, 27, width - 4);
  }

  /** Call a function with the position of each point, or of those with a flag. */
  points(width, height, flags, draw) {
    const x = valuesOf(this.column), y = valuesOf(this.row);
    for (let i = 0; i < x.length; i++) {
      if (Number.isNaN(x[i]) || Number.isNaN(y[i]) || (flags && !flags[i])) continue;
      draw(3 + shareOf(this.column, x[i]) * (width - 6), height - 3 - shareOf(this.row, y[i]) * (height - 6));
    }
  }

  /** Draw the selected points over the others, and the rectangle if it is in this cell. */
  drawSelection() {
    const pen = this.canvas.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.globalAlpha = 1;
    pen.drawImage(this.base, 0, 0);
    const ratio = window.devicePixelRatio || 1, width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    let drawn = 0;
    if (selection.runs && !this.diagonal) {
      pen.fillStyle = colours().selected;
      this.points(width, height, selection.runs, (px, py) => { pen.fillRect(px - 1.5, py - 1.5, 3, 3); drawn += 1; });
    }
    this.canvas.dataset.selected = drawn;
    if (matrix.brush?.cell === this) {
      const { left, right, bottom, top } = matrix.brush;
      pen.strokeStyle = colours().ink;
      pen.strokeRect(3 + left * (width - 6), height - 3 - top * (height - 6), (right - left) * (width - 6), (top - bottom) * (height - 6));
    }
  }

  /** Return the position of a pointer in the plot, 0 to 1 from the lower left. */
  at(event) {
    const box = this.canvas.getBoundingClientRect();
    const inside = (v) => Math.min(1, Math.max(0, v));
    return [inside((event.clientX - box.left - 3) / (box.width - 6)), inside((box.bottom - 3 - event.clientY) / (box.height - 6))];
  }

  begin(event) {
    this.from = this.at(event);
    this.canvas.setPointerCapture(event.pointerId);
    this.canvas.focus({ preventScroll: true });
    brushTo(null);
  }

  move(event) {
    if (!this.from) return;
    const [x, y] = this.at(event), [a, b] = this.from;
    if (Math.abs(x - a) < 0.01 && Math.abs(y - b) < 0.01) return;
    brushTo({ cell: this, left: Math.min(a, x), right: Math.max(a, x), bottom: Math.min(b, y), top: Math.max(b, y) });
  }

  key(event) {
    const own = matrix.brush?.cell === this ? { ...matrix.brush } : null;
    const step = { ArrowLeft: [-0.05, 0], ArrowRight: [0.05, 0], ArrowUp: [0, 0.05], ArrowDown: [0, -0.05] }[event.key];
    if (event.key === "Escape") brushTo(null);
    else if (event.key === "Enter") brushTo({ cell: this, left: 0.35, right: 0.65, bottom: 0.35, top: 0.65 });
    else if (step && own) {
      const [dx, dy] = step;
      if (event.shiftKey) {
        own.right = Math.min(1, Math.max(own.left + 0.02, own.right + dx));
        own.top = Math.min(1, Math.max(own.bottom + 0.02, own.top + dy));
      } else {
        const mx = Math.min(1 - own.right, Math.max(-own.left, dx)), my = Math.min(1 - own.top, Math.max(-own.bottom, dy));
        Object.assign(own, { left: own.left + mx, right: own.right + mx, bottom: own.bottom + my, top: own.top + my });
      }
      brushTo(own);
    } else return;
    event.preventDefault();
  }
}

/** Select the runs in a rectangle of a cell, or none. */
function brushTo(brush) {
  matrix.brush = brush;
  if (matrix.waiting) return;
  matrix.waiting = true;
  requestAnimationFrame(() => {
    matrix.waiting = false;
    const now = matrix.brush;
    if (!now) { select(selection.system, null); return; }
    const x = valuesOf(now.cell.column), y = valuesOf(now.cell.row);
    const flags = new Uint8Array(x.length);
    for (let i = 0; i < x.length; i++) {
      if (Number.isNaN(x[i]) || Number.isNaN(y[i])) continue;
      const a = shareOf(now.cell.column, x[i]), b = shareOf(now.cell.row, y[i]);
      flags[i] = a >= now.left && a <= now.right && b >= now.bottom && b <= now.top ? 1 : 0;
    }
    select(selection.system, flags);
  });
}

/** Lay the cells out again, for another system or other columns. */
function layMatrix() {
  const place = document.getElementById("cells"), columns = shownColumns();
  matrix.cells = [];
  matrix.brush = null;
  place.replaceChildren();
  place.style.gridTemplateColumns = `repeat(${Math.max(1, columns.length)}, minmax(92px, 1fr))`;
  place.style.maxWidth = `${columns.length * 230}px`;
  columns.forEach((row, r) => columns.forEach((column, c) => {
    if (c > r) {
      const value = correlation(row, column);
      place.append(make("div", { className: "pair", title: `rank correlation of ${row.name} and ${column.name}` }, Number.isNaN(value) ? "–" : value.toFixed(2)));
      return;
    }
    const cell = new Cell(row, column);
    matrix.cells.push(cell);
    place.append(cell.canvas);
  }));
  for (const cell of matrix.cells) cell.drawBase();
  select(selection.system, null);
}

/** List inputs and metrics to choose from. */
function listVariables() {
  const columns = shownSystem().columns;
  const boxes = columns.map((column) => {
    const key = `${column.kind}.${column.name}`;
    const box = make("input", { type: "checkbox", value: key, checked: matrix.chosen.has(key) });
    box.onchange = () => {
      if (box.checked) matrix.chosen.add(key); else matrix.chosen.delete(key);
      layMatrix();
      for (const other of boxes) other.firstChild.disabled = !other.firstChild.checked && matrix.chosen.size >= MOST_VARIABLES;
    };
    return make("label", {}, box, column.name, " ", make("small", { textContent: `${column.kind}${column.unit && column.unit !== "1" ? `, ${column.unit}` : ""}` }));
  });
  document.getElementById("variables").replaceChildren(...boxes);
}

/** Make the matrix of the first system. */
function startMatrix() {
  const columns = contents.systems[0].columns.filter((column) => column.high > column.low);
  const first = (kind, most) => columns.filter((column) => column.kind === kind).slice(0, most);
  for (const column of [...first("metric", FIRST_METRICS), ...first("input", FIRST_INPUTS)]) matrix.chosen.add(`${column.kind}.${column.name}`);
  const system = document.getElementById("system");
  system.append(...contents.systems.map((one, i) => make("option", { value: String(i), textContent: one.name })));
  document.getElementById("system-label").hidden = contents.systems.length === 1;
  system.onchange = () => { select(Number(system.value), null); listVariables(); layMatrix(); };
  document.getElementById("clear").onclick = () => brushTo(null);
  selection.listeners.push(() => matrix.cells.forEach((cell) => cell.base && cell.drawSelection()));
  listVariables();
  layMatrix();
}
