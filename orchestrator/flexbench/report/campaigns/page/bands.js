// Bands over time of one signal: least to largest, percentiles, median, one plot for each system.

const bandPlots = [];

/** The band of one signal of one system. */
class Band {
  constructor(about) {
    this.about = about;
    this.canvas = make("canvas", { className: "plot", role: "img", tabIndex: 0 });
    this.element = make("div", { className: "panel" }, make("header", {}, make("h3", { textContent: `${about.signal}, ${about.system}` })), this.canvas);
    this.columns = Object.fromEntries(Object.entries(about.data).map(([name, id]) => [name, new Float32Array(bytesOf(textOf(id)))]));
    this.canvas.setAttribute("aria-label", `${about.signal} of ${about.runs} runs of ${about.system} over time`);
    this.canvas.onpointermove = (event) => this.read((event.clientX - this.canvas.getBoundingClientRect().left - 62) / (this.canvas.clientWidth - 72));
    this.canvas.onkeydown = (event) => {
      const step = { ArrowLeft: -0.01, ArrowRight: 0.01 }[event.key];
      if (!step) return;
      event.preventDefault();
      this.read((this.share ?? 0) + step);
    };
  }

  /** Write the values at a share of the time. */
  read(share) {
    this.share = Math.min(1, Math.max(0, share));
    const time = this.columns.time, goal = time[0] + this.share * (time[time.length - 1] - time[0]);
    let i = 0;
    while (i + 1 < time.length && time[i + 1] <= goal) i++;
    const values = this.about.levels.map((name) => `${name} ${formatNumber(this.columns[name][i])}`);
    document.getElementById("band-readout").textContent = `${formatNumber(time[i], 5)} s: ${values.join(", ")}`;
  }

  draw() {
    const { pen, width, height } = penOf(this.canvas);
    const frame = { left: 62, right: width - 10, top: 10, bottom: height - 38 };
    const { levels } = this.about, time = this.columns.time;
    let low = Infinity, high = -Infinity;
    for (const v of this.columns[levels[0]]) if (v < low) low = v;
    for (const v of this.columns[levels[levels.length - 1]]) if (v > high) high = v;
    const x = axisOf(time[0], time[time.length - 1], frame.left, frame.right, { most: Math.max(2, width / 90) });
    const y = axisOf(low, high, frame.bottom, frame.top, { most: 5 });
    drawFrame(pen, frame, x, y, "time [s]");
    pen.fillStyle = pen.strokeStyle = colours().systems[contents.systems.findIndex((s) => s.name === this.about.system) % 4] ?? colours().ink;
    for (let k = 0; k < Math.floor(levels.length / 2); k++) {
      const below = this.columns[levels[k]], above = this.columns[levels[levels.length - 1 - k]];
      pen.globalAlpha = 0.16 + 0.1 * k;
      pen.beginPath();
      for (let i = 0; i < time.length; i++) pen.lineTo(x.at(time[i]), y.at(above[i]));
      for (let i = time.length - 1; i >= 0; i--) pen.lineTo(x.at(time[i]), y.at(below[i]));
      pen.fill();
    }
    pen.globalAlpha = 1;
    pen.lineWidth = 1.3;
    if (levels.length % 2) stroke(pen, Array.from(time, (t, i) => [x.at(t), y.at(this.columns[levels[(levels.length - 1) / 2]][i])]));
    this.canvas.dataset.most = high;
    this.canvas.dataset.least = low;
  }
}

/** Make the plots of the first signal, and the choice of others. */
function startBands() {
  const choice = document.getElementById("signal");
  if (!choice) return;
  const signals = [...new Set(contents.bands.map((one) => one.signal))];
  choice.append(...signals.map((name) => make("option", { value: name, textContent: name })));
  const show = () => {
    bandPlots.splice(0, bandPlots.length, ...contents.bands.filter((one) => one.signal === choice.value).map((one) => new Band(one)));
    document.getElementById("bands-plots").replaceChildren(...bandPlots.map((one) => one.element));
    document.getElementById("band-readout").textContent = "";
    for (const one of bandPlots) one.draw();
  };
  choice.onchange = show;
  show();
}
