// Animate the structure: a plate of triangles and wheels as discs, drawn from the back to the front.

const REACH = 2.2; // m: how far the largest deflection is drawn when exaggerated to fit
const TILT = 0.25; // rad: how far the largest pointing error is drawn
const DEFLECTIONS = ["#2166ac", "#67a9cf", "#d1e5f0", "#f7f7f7", "#fddbc7", "#ef8a62", "#b2182b"]; // ColorBrewer RdBu
const TORQUES = ["#542788", "#998ec3", "#d8daeb", "#f0f0f0", "#fee0b6", "#f1a340", "#b35806"]; // ColorBrewer PuOr

/** Return the colour of a diverging scale at -1 .. 1, darkened by a factor. */
function shade(scale, value, light = 1) {
  const position = (Math.min(1, Math.max(-1, value)) + 1) * 0.5 * (scale.length - 1);
  const k = Math.min(scale.length - 2, Math.floor(position)), share = position - k;
  const part = (i, n) => parseInt(scale[i].slice(1 + 2 * n, 3 + 2 * n), 16);
  const mix = [0, 1, 2].map((n) => Math.round((part(k, n) * (1 - share) + part(k + 1, n) * share) * light));
  return `rgb(${mix.join(",")})`;
}

class Scene {
  constructor(canvas, motion) {
    this.canvas = canvas;
    this.camera = { turn: -0.6, tilt: 1.0, zoom: 1 };
    this.playing = false;
    this.frame = 0;
    this.setMotion(motion);
    this.listen();
  }

  /** Show another run. */
  setMotion(motion) {
    this.motion = motion;
    const geometry = contents.geometry[motion.configuration];
    this.nodes = new Float32Array(bytesOf(geometry.nodes));
    this.triangles = new Uint16Array(bytesOf(geometry.triangles));
    this.shapes = new Float32Array(bytesOf(geometry.shapes));
    this.hole = geometry.hole;
    this.wheels = geometry.wheels;
    this.modes = motion.modes; // of these frames, the lowest
    this.stride = geometry.modes;
    this.modal = new Int16Array(bytesOf(textOf(motion.modal)));
    this.torque = motion.torque ? new Int8Array(bytesOf(textOf(motion.torque))) : new Int8Array(0);
    this.error = motion.error ? new Float32Array(bytesOf(textOf(motion.error))) : null;
    this.outline = outlineOf(this.triangles);
    this.liveliest = 0;
    this.tilting = 0;
    if (this.error) {
      let largest = 0;
      for (const value of this.error) largest = Math.max(largest, Math.abs(value));
      this.largestError = largest;
    }
    this.fit(0, motion.frames);
    this.frame = this.liveliest;
  }

  /** Set the exaggeration so that the largest deflection of some frames is drawn with length REACH. */
  fit(first, last) {
    const stride = Math.max(1, Math.floor((last - first) / 400));
    let largest = 0;
    for (let frame = Math.max(0, first); frame < Math.min(last, this.motion.frames); frame += stride) {
      for (const w of this.deflections(frame)) if (Math.abs(w) > largest) { largest = Math.abs(w); this.liveliest = frame; }
    }
    this.exaggeration = largest > 0 ? REACH / largest : 1;
  }

  /** Return the deflection of every node in a frame [m]. */
  deflections(frame) {
    const count = this.nodes.length / 2, { modes } = this;
    const result = new Float32Array(count), modal = new Float32Array(modes);
    for (let m = 0; m < modes; m++) modal[m] = this.modal[frame * modes + m] * this.motion.scale[m];
    for (let n = 0; n < count; n++) {
      let sum = 0;
      for (let m = 0; m < modes; m++) sum += this.shapes[n * this.stride + m] * modal[m];
      result[n] = sum;
    }
    return result;
  }

  time() { return this.motion.start + this.frame * this.motion.step; }

  seek(time) {
    this.frame = Math.round(Math.min(this.motion.frames - 1, Math.max(0, (time - this.motion.start) / this.motion.step)));
  }

  /** Turn a point of the body by the exaggerated pointing error. */
  tilted([x, y, z]) {
    if (!this.tilting || !this.error) return [x, y, z];
    const [a, b, c] = [0, 1, 2].map((k) => this.error[3 * this.frame + k] * this.tilting);
    return [x + b * z - c * y, y + c * x - a * z, z + a * y - b * x]; // linear in the angle: exaggerated errors stay small rotations
  }

  /** Project a point onto the canvas: x, y [px] and nearness. */
  project(point) {
    const [x, y, z] = this.tilted(point);
    const { turn, tilt } = this.camera;
    const u = x * Math.cos(turn) - y * Math.sin(turn);
    const v = x * Math.sin(turn) + y * Math.cos(turn);
    const up = v * Math.cos(tilt) + z * Math.sin(tilt);
    const near = -v * Math.sin(tilt) + z * Math.cos(tilt);
    const scale = (this.size * this.camera.zoom * 60) / (60 - near);
    return [this.middle[0] + u * scale, this.middle[1] - up * scale, near];
  }

  draw() {
    const { canvas } = this;
    if (!canvas.clientWidth) return;
    const { pen, width, height } = penOf(canvas);
    pen.lineJoin = "round";
    this.size = Math.min(width / 36, height / 27);
    this.middle = [width / 2, height / 2];
    const w = this.deflections(this.frame), reach = this.exaggeration;
    const at = (n, z) => this.project([this.nodes[2 * n], this.nodes[2 * n + 1], z]);
    pen.strokeStyle = colours().undeformed;
    pen.setLineDash([3, 3]);
    for (const [a, b] of this.outline) { const p = at(a, 0), q = at(b, 0); line(pen, p[0], p[1], q[0], q[1]); }
    pen.setLineDash([]);
    const positions = Array.from(w, (value, n) => at(n, value * reach));
    const faces = [];
    for (let t = 0; t < this.triangles.length; t += 3) {
      const corners = [this.triangles[t], this.triangles[t + 1], this.triangles[t + 2]];
      const [p, q, r] = corners.map((n) => positions[n]);
      const mean = (w[corners[0]] + w[corners[1]] + w[corners[2]]) / 3;
      const slope = slopeOf(corners, this.nodes, w, reach);
      faces.push({ p, q, r, near: p[2] + q[2] + r[2], colour: shade(DEFLECTIONS, (mean * reach) / REACH, slope) });
    }
    faces.sort((a, b) => a.near - b.near);
    pen.lineWidth = 0.5;
    for (const { p, q, r, colour } of faces) {
      pen.beginPath();
      pen.moveTo(p[0], p[1]);
      pen.lineTo(q[0], q[1]);
      pen.lineTo(r[0], r[1]);
      pen.closePath();
      pen.fillStyle = colour;
      pen.fill();
      pen.strokeStyle = "rgba(40, 50, 60, 0.35)";
      pen.stroke();
    }
    this.drawBus(pen);
    this.drawWheels(pen, w, reach);
    this.drawAxes(pen);
    this.drawScales(pen, width, height);
    let largest = 0;
    for (const value of w) largest = Math.max(largest, Math.abs(value));
    canvas.dataset.largest = largest;
    canvas.dataset.frame = this.frame;
    return largest;
  }

  drawBus(pen) {
    const ring = this.hole.map((n) => [this.nodes[2 * n], this.nodes[2 * n + 1]])
      .sort((a, b) => Math.atan2(a[1], a[0]) - Math.atan2(b[1], b[0]));
    pen.beginPath();
    for (const [x, y] of ring) { const p = this.project([x, y, 0]); pen.lineTo(p[0], p[1]); }
    pen.closePath();
    pen.fillStyle = "rgba(120, 130, 145, 0.85)";
    pen.fill();
    pen.strokeStyle = colours().ink;
    pen.lineWidth = 1;
    pen.stroke();
  }

  drawWheels(pen, w, reach) {
    const few = this.wheels.length <= 8;
    const radius = few ? 1.2 : 0.75, arm = few ? 2.6 : 1.6;
    const discs = this.wheels.map((wheel, i) => {
      const n = wheel.node;
      const base = n < 0 ? [0, 0, 0] : [this.nodes[2 * n], this.nodes[2 * n + 1], w[n] * reach];
      const centre = base.map((value, k) => value + arm * wheel.axis[k]);
      const share = this.torque.length ? this.torque[this.frame * this.motion.wheels + i] / 127 : 0;
      return { base: this.project(base), middle: this.project(centre), centre, axis: wheel.axis, share };
    }).sort((a, b) => a.middle[2] - b.middle[2]);
    for (const { base, middle, centre, axis, share } of discs) {
      pen.strokeStyle = colours().ink;
      pen.lineWidth = 1;
      line(pen, base[0], base[1], middle[0], middle[1]);
      const main = axis.findIndex((value) => Math.abs(value) > 0.5);
      pen.beginPath();
      for (let k = 0; k < 20; k++) {
        const angle = (k * Math.PI) / 10, point = [...centre];
        point[(main + 1) % 3] += radius * Math.cos(angle);
        point[(main + 2) % 3] += radius * Math.sin(angle);
        const p = this.project(point);
        pen.lineTo(p[0], p[1]);
      }
      pen.closePath();
      pen.fillStyle = shade(TORQUES, share);
      pen.fill();
      pen.stroke();
    }
  }

  drawAxes(pen) {
    pen.font = "bold 12px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.fillStyle = pen.strokeStyle = colours().ink;
    pen.lineWidth = 1.2;
    const origin = this.project([0, 0, 0]);
    ["x", "y", "z"].forEach((name, k) => {
      const far = k === 2 ? 7 : 17;
      const tip = this.project([0, 1, 2].map((i) => (i === k ? far : 0)));
      const start = k === 2 ? origin : this.project([0, 1, 2].map((i) => (i === k ? 15.2 : 0)));
      line(pen, start[0], start[1], tip[0], tip[1]);
      pen.fillText(name, tip[0] + (tip[0] - origin[0]) * 0.06, tip[1] + (tip[1] - origin[1]) * 0.06 - (k === 2 ? 8 : 0));
    });
  }

  drawScales(pen, width, height) {
    const length = Math.min(150, width / 2 - 30);
    const bars = [[12, DEFLECTIONS, "deflection [µm]", (REACH / this.exaggeration) * 1e6]];
    if (this.torque.length) bars.push([width - length - 22, TORQUES, "wheel torque [N.m]", this.motion.largest_torque]);
    pen.font = "11px system-ui, sans-serif";
    for (const [left, scale, text, limit] of bars) {
      const top = height - 30;
      for (let k = 0; k < length; k++) {
        pen.fillStyle = shade(scale, (2 * k) / (length - 1) - 1);
        pen.fillRect(left + k, top, 1.5, 9);
      }
      pen.fillStyle = colours().ink;
      pen.textBaseline = "top";
      pen.textAlign = "left";
      pen.fillText(formatNumber(-limit, 2), left, top + 12);
      pen.textAlign = "right";
      pen.fillText(formatNumber(limit, 2), left + length, top + 12);
      pen.textAlign = "center";
      pen.fillText("0", left + length / 2, top + 12);
      pen.textBaseline = "bottom";
      pen.fillText(text, left + length / 2, top - 3);
    }
  }

  /** Turn the view by two angles [rad]. */
  look(turn, tilt, from = this.camera) {
    this.camera.turn = from.turn + turn;
    this.camera.tilt = Math.min(Math.PI, Math.max(0, from.tilt + tilt));
  }

  listen() {
    let drag = null;
    const turns = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
    const zooms = { "+": 1.1, "-": 1 / 1.1 };
    this.canvas.onkeydown = (event) => {
      const turn = turns[event.key], factor = zooms[event.key];
      if (!turn && !factor) return;
      event.preventDefault();
      if (turn) this.look(turn[0], turn[1]);
      else this.camera.zoom = Math.min(6, Math.max(0.5, this.camera.zoom * factor));
      this.draw();
    };
    this.canvas.onpointerdown = (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      drag = { x: event.clientX, y: event.clientY, ...this.camera };
    };
    this.canvas.onpointermove = (event) => {
      if (!drag) return;
      this.look(-(event.clientX - drag.x) * 0.008, -(event.clientY - drag.y) * 0.008, drag);
      this.draw();
    };
    this.canvas.onpointerup = this.canvas.onpointercancel = () => { drag = null; };
    this.canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.metaKey) return;
      event.preventDefault();
      this.camera.zoom = Math.min(6, Math.max(0.5, this.camera.zoom * (event.deltaY > 0 ? 0.9 : 1.1)));
      this.draw();
    }, { passive: false });
  }
}

/** Return the edges that belong to one triangle only. */
function outlineOf(triangles) {
  const seen = new Map();
  for (let t = 0; t < triangles.length; t += 3) {
    for (let k = 0; k < 3; k++) {
      const a = triangles[t + k], b = triangles[t + ((k + 1) % 3)];
      const key = a < b ? `${a} ${b}` : `${b} ${a}`;
      seen.set(key, seen.has(key) ? null : [a, b]);
    }
  }
  return [...seen.values()].filter(Boolean);
}

/** Return the brightness of a face: the steeper, the darker. */
function slopeOf([a, b, c], nodes, w, reach) {
  const ux = nodes[2 * b] - nodes[2 * a], uy = nodes[2 * b + 1] - nodes[2 * a + 1], uz = (w[b] - w[a]) * reach;
  const vx = nodes[2 * c] - nodes[2 * a], vy = nodes[2 * c + 1] - nodes[2 * a + 1], vz = (w[c] - w[a]) * reach;
  const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
  const light = (0.35 * nx + 0.25 * ny + 0.9 * nz) / Math.hypot(nx, ny, nz);
  return 0.72 + 0.28 * Math.max(0, light);
}

function startScene() {
  const runs = contents.runs.filter((run) => run.motion);
  if (!runs.length) return;
  const part = (id) => document.getElementById(id);
  const first = Math.max(0, runs.findIndex((run) => run.shown));
  const scene = new Scene(part("scene"), runs[first].motion);
  const slider = part("frame");
  const show = () => {
    const largest = scene.draw();
    if (largest === undefined) return;
    slider.value = scene.frame;
    part("moment").textContent = `t = ${scene.time().toFixed(2)} s; largest deflection ${formatNumber(largest * 1e6, 3)} µm, drawn ${formatNumber(scene.exaggeration, 2)} times`;
    part("exaggeration").value = Math.log10(scene.exaggeration);
    view.now = scene.time();
    redraw();
  };
  const prepare = () => {
    const { band, share, step } = scene.motion;
    part("sampling").textContent = band === undefined
      ? `Every recorded row, one every ${formatNumber(1000 * step, 3)} ms.`
      : `Motion below ${formatNumber(band, 2)} Hz, ${formatNumber(1 / step, 2)} frames a second: filtered without delay, so that no fast vibration appears slow. It has ${formatNumber(100 * share, 3)} % of the RMS deformation; to see every recorded row of some seconds: flexsat report --time-range FROM TO.`;
    slider.max = scene.motion.frames - 1;
    const power = Math.log10(scene.exaggeration);
    part("exaggeration").min = power - 1;
    part("exaggeration").max = power + 4;
    part("turned").disabled = !scene.error;
    part("turned-times").textContent = scene.error && scene.largestError > 0 ? ` (${formatNumber(TILT / scene.largestError, 2)} times)` : "";
    show();
  };
  let last = null;
  const tick = (stamp) => {
    if (!scene.playing) return;
    if (last !== null) {
      const moved = (Math.min(0.2, (stamp - last) / 1000) * Number(part("speed").value)) / scene.motion.step;
      scene.exact = (scene.exact + moved) % scene.motion.frames;
      scene.frame = Math.floor(scene.exact);
      show();
    }
    last = stamp;
    requestAnimationFrame(tick);
  };
  const play = (on) => {
    scene.playing = on;
    scene.exact = scene.frame;
    last = null;
    part("play").textContent = on ? "❚❚ pause" : "► play";
    if (on) requestAnimationFrame(tick);
  };
  part("play").onclick = () => play(!scene.playing);
  slider.oninput = () => { scene.frame = scene.exact = Number(slider.value); show(); };
  part("exaggeration").oninput = (event) => { scene.exaggeration = 10 ** Number(event.target.value); show(); };
  part("fit").onclick = () => {
    const near = Math.max(2, Math.round(1 / scene.motion.step));
    scene.fit(scene.frame - near, scene.frame + near + 1);
    show();
  };
  part("turned").onchange = (event) => {
    scene.tilting = event.target.checked && scene.largestError > 0 ? TILT / scene.largestError : 0;
    show();
  };
  part("which").replaceChildren(...runs.map((run, i) => make("option", { value: i }, run.name)));
  part("which").value = first;
  part("which").parentElement.hidden = runs.length < 2;
  part("which").onchange = (event) => {
    scene.setMotion(runs[Number(event.target.value)].motion);
    part("turned").checked = false;
    prepare();
  };
  document.addEventListener("seek", (event) => { scene.seek(event.detail); scene.exact = scene.frame; show(); });
  window.addEventListener("resize", show);
  darkScreen.addEventListener("change", show);
  prepare();
}

// what is folded cannot be opened on paper
darkScreen.addEventListener("change", redraw);
for (const [event, on] of [["beforeprint", true], ["afterprint", false]]) {
  window.addEventListener(event, () => { printing = on; redraw(); });
}
window.addEventListener("beforeprint", () => { for (const part of document.querySelectorAll("details")) part.open = true; });
startPlots();
startScene();
document.documentElement.dataset.ready = "yes";
