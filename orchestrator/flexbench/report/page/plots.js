// Plots with a common time axis: drag to zoom, shift and drag to move, double-click for all.

const view = { ...wholeTime, cursor: null, now: null };
const panels = [];
const hiddenRuns = new Set(contents.runs.flatMap((run, i) => (run.shown ? [] : [i])));
const HEIGHT = 190;
let waiting = false;

/** Draw all panels in the next frame of the browser. */
function redraw() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => {
    waiting = false;
    for (const panel of panels) panel.draw();
    const drawn = panels.flatMap((panel) => panel.visible());
    const whole = drawn.length > 0 && drawn.every((line) => line.complete(view.from, view.to));
    document.getElementById("rate").textContent = !drawn.length ? "" : whole ? ", every recorded row" : ", extremes of intervals";
  });
}

/** Show a part of the time, limited to a few samples at least and the whole record at most. */
function look(from, to) {
  const whole = wholeTime.to - wholeTime.from;
  const span = Math.min(whole, Math.max(to - from, whole * 1e-6));
  view.from = Math.min(Math.max(from, wholeTime.from), wholeTime.to - span);
  view.to = view.from + span;
  document.getElementById("shown").textContent = `${formatNumber(view.from, 6)} to ${formatNumber(view.to, 6)} s`;
  redraw();
}

/** Narrow or widen the time shown about one time. */
function zoom(factor, about = 0.5 * (view.from + view.to)) {
  look(about - (about - view.from) * factor, about + (view.to - about) * factor);
}

/** Make buttons that hide and show lines, from [key, text, colour]; a double click shows one line only. */
function chips(entries, hidden) {
  const buttons = entries.map(([key, text, colour]) => {
    const swatch = make("i");
    if (colour) swatch.style.background = colour; else swatch.hidden = true;
    const button = make("button", { type: "button", title: "click to hide or show; double-click to show only this one" }, swatch, text);
    button.onclick = () => {
      if (hidden.has(key)) hidden.delete(key); else hidden.add(key);
      update();
    };
    button.ondblclick = () => {
      for (const [other] of entries) hidden.add(other);
      hidden.delete(key);
      update();
    };
    return button;
  });
  const update = () => {
    buttons.forEach((button, i) => {
      button.className = hidden.has(entries[i][0]) ? "chip off" : "chip";
      button.ariaPressed = String(!hidden.has(entries[i][0]));
    });
    redraw();
  };
  update();
  return buttons;
}

class Panel {
  constructor(group) {
    this.groups = [group];
    this.hidden = new Set(); // elements
    this.logarithmic = group.lines.some((l) => l.logarithmic);
    this.canvas = make("canvas", { tabIndex: 0, role: "img", className: "plot" });
    this.legend = make("div", { className: "legend" });
    this.title = make("h3");
    const log = make("input", { type: "checkbox", checked: this.logarithmic });
    log.onchange = () => { this.logarithmic = log.checked; redraw(); };
    this.overlay = make("select", { title: "show another signal of the same unit in this plot", ariaLabel: "overlay" });
    this.overlay.onchange = () => {
      const chosen = groups.get(this.overlay.value);
      if (chosen) this.groups.push(chosen);
      this.arrange();
    };
    const close = make("button", { type: "button", title: "remove this plot", ariaLabel: "remove this plot" }, "×");
    close.onclick = () => removePanel(this);
    this.element = make(
      "section", { className: "panel" },
      make("header", {}, this.title, make("span", { className: "tools" }, this.overlay, make("label", {}, log, "log"), close)),
      this.canvas, this.legend,
    );
    // only the first elements: 33 wheels of several runs in one plot are unreadable
    const elements = this.elements();
    if (contents.runs.length > 1) for (const name of elements.slice(3)) this.hidden.add(name);
    this.listen();
    this.arrange();
  }

  lines() { return this.groups.flatMap((group) => group.lines); }

  elements() { return [...new Set(this.lines().map((line) => line.element).filter((name) => name !== ""))]; }

  visible() {
    return this.lines().filter((l) => !hiddenRuns.has(l.run) && !this.hidden.has(l.element));
  }

  /** Update title, choices and legend after the shown signals have changed. */
  arrange() {
    const [{ unit }] = this.groups;
    this.title.replaceChildren(this.groups.map((g) => g.name).join(" and "), make("small", {}, ` [${unit || "1"}]`));
    this.title.title = this.groups.map((g) => g.description).join("; ");
    this.canvas.setAttribute("aria-label", `${this.title.textContent} over time`);
    const others = [...groups.values()].filter((g) => g.unit === unit && !this.groups.includes(g));
    this.overlay.replaceChildren(
      make("option", { value: "" }, "overlay…"), ...others.map((g) => make("option", { value: g.name }, g.name)),
    );
    this.overlay.hidden = others.length === 0;
    const elements = this.elements();
    const colour = (i) => (contents.runs.length > 1 ? null : colourOf(i, elements.length));
    this.legend.replaceChildren(...chips(elements.map((name, i) => [name, name, colour(i)]), this.hidden));
    this.readout = make("span", { className: "readout" });
    this.legend.append(this.readout);
    redraw();
  }

  listen() {
    const { canvas } = this;
    const timeAt = (event) => {
      const box = canvas.getBoundingClientRect();
      const share = (event.clientX - box.left - MARGIN.left) / (box.width - MARGIN.left - MARGIN.right);
      return view.from + Math.min(1, Math.max(0, share)) * (view.to - view.from);
    };
    let drag = null;
    canvas.onpointerdown = (event) => {
      if (event.button !== 0) return;
      canvas.setPointerCapture(event.pointerId);
      drag = { x: event.clientX, time: timeAt(event), from: view.from, to: view.to, move: event.shiftKey };
    };
    canvas.onpointermove = (event) => {
      view.cursor = timeAt(event);
      this.selection = null;
      if (drag && drag.move) {
        const width = canvas.getBoundingClientRect().width - MARGIN.left - MARGIN.right;
        const shift = ((drag.x - event.clientX) / width) * (drag.to - drag.from);
        look(drag.from + shift, drag.to + shift);
      } else if (drag && Math.abs(event.clientX - drag.x) > 4) this.selection = [drag.time, view.cursor];
      redraw();
    };
    canvas.onpointerup = (event) => {
      const chosen = this.selection, was = drag;
      this.selection = drag = null;
      if (chosen) look(Math.min(...chosen), Math.max(...chosen));
      else if (was && !was.move) document.dispatchEvent(new CustomEvent("seek", { detail: timeAt(event) }));
    };
    canvas.onpointercancel = () => { this.selection = drag = null; redraw(); };
    canvas.onpointerleave = () => { view.cursor = null; redraw(); };
    canvas.ondblclick = () => look(wholeTime.from, wholeTime.to);
    canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.metaKey) return; // the page scrolls
      event.preventDefault();
      zoom(event.deltaY > 0 ? 1.25 : 0.8, timeAt(event));
    }, { passive: false });
    canvas.onkeydown = (event) => {
      const span = view.to - view.from;
      const act = {
        "+": () => zoom(0.5), "-": () => zoom(2), 0: () => look(wholeTime.from, wholeTime.to),
        ArrowLeft: () => look(view.from - 0.2 * span, view.to - 0.2 * span),
        ArrowRight: () => look(view.from + 0.2 * span, view.to + 0.2 * span),
      }[event.key];
      if (act) { event.preventDefault(); act(); }
    };
  }

  draw() {
    if (!this.canvas.clientWidth) return;
    const { pen, width } = penOf(this.canvas, HEIGHT);
    const frame = { left: MARGIN.left, top: MARGIN.top, width: width - MARGIN.left - MARGIN.right, height: HEIGHT - MARGIN.top - MARGIN.bottom };
    const lines = this.visible();
    const parts = lines.map((line) => line.part(view.from, view.to, 1.6 * frame.width));
    const axis = valueAxis(lines, parts, this.logarithmic);
    const x = (time) => frame.left + ((time - view.from) / (view.to - view.from)) * frame.width;
    const y = (value) => frame.top + frame.height * (1 - axis.share(value));
    drawAxes(pen, frame, axis, x, y);
    pen.save();
    pen.beginPath();
    pen.rect(frame.left, frame.top - 1, frame.width, frame.height + 2);
    pen.clip();
    let points = 0;
    pen.globalAlpha = lines.length > 1 ? 0.85 : 1; // so that lines behind remain visible
    const several = contents.runs.length > 1, elements = this.elements();
    lines.forEach((line, k) => {
      pen.strokeStyle = several ? lookOf(line.run).colour
        : line.element === "" ? colours().series[this.groups.findIndex((g) => g.lines.includes(line))]
        : colourOf(elements.indexOf(line.element), elements.length);
      const overlaid = !this.groups[0].lines.includes(line);
      pen.setLineDash(overlaid ? [5, 3] : several ? lookOf(line.run).dashes : []);
      pen.lineWidth = lines.length > 8 ? 0.8 : 1.2;
      points += drawLine(pen, parts[k], x, y);
    });
    pen.setLineDash([]);
    pen.globalAlpha = 1;
    const marks = contents.runs.flatMap((run, i) => (hiddenRuns.has(i) ? [] : run.marks));
    const different = new Map(marks.map((mark) => [`${mark.time} ${mark.text}`, mark]));
    for (const mark of different.values()) drawMark(pen, frame, x(mark.time), mark);
    if (this.selection) {
      pen.fillStyle = "rgba(0, 114, 178, 0.15)";
      pen.fillRect(x(this.selection[0]), frame.top, x(this.selection[1]) - x(this.selection[0]), frame.height);
    }
    for (const [time, colour] of [[view.cursor, colours().cursor], [view.now, colours().selected]]) {
      if (time === null) continue;
      pen.strokeStyle = colour;
      pen.lineWidth = 1;
      pen.beginPath();
      pen.moveTo(x(time), frame.top);
      pen.lineTo(x(time), frame.top + frame.height);
      pen.stroke();
    }
    pen.restore();
    this.canvas.dataset.points = points;
    this.canvas.dataset.most = axis.most;
    this.read(lines);
  }

  /** Show the values at the cursor. */
  read(lines) {
    const time = view.cursor;
    if (time === null) { this.readout.textContent = ""; return; }
    const texts = lines.slice(0, 6).map((line) => {
      const value = line.valueAt(time);
      if (!value) return "";
      const [low, high] = value;
      const name = [contents.runs.length > 1 ? contents.runs[line.run].name : "", line.element].filter(Boolean).join(" ");
      return `${name ? `${name}: ` : ""}${low === high ? formatNumber(low) : `${formatNumber(low)} … ${formatNumber(high)}`}`;
    });
    this.readout.textContent = `t = ${formatNumber(time, 6)} s   ${texts.filter(Boolean).join("   ")}${lines.length > 6 ? "   …" : ""}`;
  }
}

/** Add a plot of a group, or remove it if it is there. */
function togglePanel(name, wanted) {
  const there = panels.find((panel) => panel.groups[0].name === name);
  if (wanted && !there) {
    const panel = new Panel(groups.get(name));
    panels.push(panel);
    document.getElementById("panels").append(panel.element);
    redraw();
  } else if (!wanted && there) removePanel(there);
}

function removePanel(panel) {
  panels.splice(panels.indexOf(panel), 1);
  panel.element.remove();
  const box = document.querySelector(`#signals input[value="${CSS.escape(panel.groups[0].name)}"]`);
  if (box) box.checked = false;
}

/** Make a button for each part of the time in which every recorded row is kept; what several runs share is one. */
function showWindows() {
  const found = [];
  for (const { name, begin, end } of contents.runs.flatMap((run) => run.windows ?? [])) {
    const same = found.find((one) => one.name === name && Math.max(one.begin, begin) < Math.min(one.end, end));
    if (!same) found.push({ name, begin, end });
    else Object.assign(same, { begin: Math.max(same.begin, begin), end: Math.min(same.end, end) });
  }
  const box = document.getElementById("windows");
  box.hidden = found.length === 0;
  for (const { name, begin, end } of found.sort((a, b) => a.begin - b.begin)) {
    const button = make("button", { type: "button" }, `${name}, ${formatNumber(begin, 4)} to ${formatNumber(end, 4)} s`);
    button.onclick = () => look(begin, end);
    box.append(button);
  }
}

function startPlots() {
  if (!groups.size) return;
  const list = document.getElementById("signals");
  for (const group of groups.values()) {
    const box = make("input", { type: "checkbox", value: group.name });
    box.onchange = () => togglePanel(group.name, box.checked);
    const count = new Set(group.lines.map((l) => l.element)).size;
    const label = make("label", { title: group.description }, box, group.name, make("small", {}, ` ${count > 1 ? `${count} × ` : ""}[${group.unit || "1"}]`));
    label.dataset.text = `${group.name} ${group.description}`.toLowerCase();
    list.append(label);
    if (contents.panels.includes(group.name)) { box.checked = true; togglePanel(group.name, true); }
  }
  if (contents.runs.length > 1) {
    const entries = contents.runs.map((run, i) => [i, run.name, lookOf(i).colour]);
    document.getElementById("runs").replaceChildren(...chips(entries, hiddenRuns));
  }
  const filter = document.getElementById("filter");
  filter.oninput = () => {
    for (const label of list.children) label.hidden = !label.dataset.text.includes(filter.value.toLowerCase());
  };
  const act = { in: () => zoom(0.5), out: () => zoom(2), all: () => look(wholeTime.from, wholeTime.to),
    left: () => look(view.from - 0.25 * (view.to - view.from), view.to - 0.25 * (view.to - view.from)),
    right: () => look(view.from + 0.25 * (view.to - view.from), view.to + 0.25 * (view.to - view.from)) };
  for (const button of document.querySelectorAll("[data-act]")) button.onclick = act[button.dataset.act];
  showWindows();
  window.addEventListener("resize", redraw);
  look(wholeTime.from, wholeTime.to);
}
