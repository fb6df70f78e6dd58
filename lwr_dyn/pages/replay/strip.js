// The strip below the stage: tip error of every run over time, its events, and a cursor that can be dragged.

const FAR_APART = 30;

class Strip {
  constructor(canvas, runs, duration, onPick) {
    this.canvas = canvas;
    this.#load(runs, duration);
    const pick = (event) => {
      if (event.buttons & 1) onPick(this.timeAt(event.offsetX));
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      pick(event);
    });
    canvas.addEventListener("pointermove", pick);
    window.addEventListener("resize", () => this.redraw());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.redraw());
    document.fonts.ready.then(() => this.redraw());
    this.redraw();
  }

  // Shows other runs.
  replace(runs, duration) {
    this.#load(runs, duration);
    this.redraw();
  }

  #load(runs, duration) {
    Object.assign(this, { runs, duration, visible: runs.map(() => true) });
    const peaks = runs.map((run) => run.tipError.reduce((a, b) => Math.max(a, b), 0)), largest = Math.max(1e-9, ...peaks);
    // Runs whose peaks are far apart share a logarithmic axis, of at most six decades.
    this.logarithmic = Math.min(...peaks) > 0 && largest > FAR_APART * Math.min(...peaks);
    const decade = Math.floor(Math.log10(Math.min(...peaks))) - 1;
    this.low = this.logarithmic ? Math.max(10 ** decade, 10 ** (Math.ceil(Math.log10(largest)) - 6)) : 0;
    this.high = this.logarithmic ? 10 ** Math.ceil(Math.log10(largest)) : largest;
  }

  // Names stand at the ends of the lines where there is room.
  get margin() {
    const named = this.runs.length > 1 && this.canvas.clientWidth > 700;
    return { left: 58, right: named ? 190 : 12, top: 19, bottom: 4 };
  }

  timeAt(x) {
    const { left, right } = this.margin;
    return (this.duration * (x - left)) / (this.canvas.clientWidth - left - right);
  }

  x(t) {
    const { left, right } = this.margin;
    return left + ((this.canvas.clientWidth - left - right) * t) / Math.max(this.duration, 1e-9);
  }

  y(error) {
    const { top, bottom } = this.margin, height = this.canvas.clientHeight - top - bottom;
    const share = this.logarithmic
      ? Math.log(Math.max(error, this.low) / this.low) / Math.log(this.high / this.low)
      : error / this.high;
    return top + height * (1 - share);
  }

  // Curves are drawn once; the cursor is drawn over a copy of them.
  redraw() {
    const scale = window.devicePixelRatio || 1, { canvas } = this;
    canvas.width = Math.round(canvas.clientWidth * scale);
    canvas.height = Math.round(canvas.clientHeight * scale);
    this.still = document.createElement("canvas");
    this.still.width = canvas.width;
    this.still.height = canvas.height;
    const pen = this.still.getContext("2d");
    pen.scale(scale, scale);
    this.axes(pen);
    const shown = this.runs.filter((_, i) => this.visible[i]);
    const widest = (run) => run.tipError.reduce((a, b) => a + b, 0);
    shown.toSorted((a, b) => widest(b) - widest(a)).forEach((run) => this.curve(pen, run)); // the widest first, below the others
    if (this.margin.right > 100) this.names(pen, shown);
    this.cursor(this.time || 0);
  }

  font(size, weight = 400) {
    return `${weight} ${size}px ${getComputedStyle(this.canvas).fontFamily}`;
  }

  ticks() {
    if (!this.logarithmic) return roundTicks(0, 1000 * this.high, 3).map((tick) => tick / 1000);
    const decades = Math.round(Math.log10(this.high / this.low)), every = Math.ceil(decades / 3), ticks = [];
    for (let k = 0; k <= decades; k += every) ticks.push(this.low * 10 ** k);
    return ticks;
  }

  axes(pen) {
    const left = this.margin.left, end = this.canvas.clientWidth - this.margin.right;
    pen.font = this.font(12);
    pen.fillStyle = ink("soft");
    pen.strokeStyle = ink("line");
    pen.textBaseline = "middle";
    const models = new Set(this.runs.map((run) => run.record.tip_model));
    const words = ["tip error, mm", ...(this.logarithmic ? ["logarithmic"] : []), ...models];
    pen.fillText(words.join(", "), left, 7);
    pen.textAlign = "right";
    this.ticks().forEach((tick) => {
      const y = this.y(tick);
      pen.beginPath();
      pen.moveTo(left, y);
      pen.lineTo(end, y);
      pen.stroke();
      pen.fillText(String(Number((1000 * tick).toPrecision(3))), left - 7, Math.min(y, this.canvas.clientHeight - 6));
    });
    pen.textAlign = "left";
  }

  // The names of the runs at the right, each at the height of its last samples, moved apart where they would touch.
  names(pen, shown) {
    const room = this.margin.right - 12, x = this.canvas.clientWidth - room, height = this.canvas.clientHeight;
    const ends = shown.map((run) => ({ run, y: this.y(run.tipError[run.tipError.length - 1]) })).sort((a, b) => a.y - b.y);
    ends.forEach((end, i) => { end.y = Math.max(end.y, i > 0 ? ends[i - 1].y + 14 : 7); });
    const below = Math.max(0, (ends.at(-1)?.y ?? 0) - (height - 7));
    pen.font = this.font(12, 600);
    ends.forEach(({ run, y }) => {
      let name = run.record.label;
      while (pen.measureText(name).width > room && name.length > 1) name = `${name.replace(/\u2026$/, "").slice(0, -1)}\u2026`;
      pen.fillStyle = ink(run.record.place < 4 ? runToken(run.record) : "soft");
      pen.fillText(name, x, y - below);
    });
  }

  // Of all samples that fall on one column of pixels the smallest and largest are drawn, so no peak is lost.
  curve(pen, run) {
    const columns = new Map();
    run.t.forEach((t, k) => {
      const column = Math.round(this.x(t)), error = run.tipError[k], seen = columns.get(column);
      if (seen === undefined) columns.set(column, [error, error]);
      else columns.set(column, [Math.min(seen[0], error), Math.max(seen[1], error)]);
    });
    pen.strokeStyle = ink(runToken(run.record));
    pen.lineWidth = 1.4;
    pen.lineJoin = "round";
    pen.beginPath();
    columns.forEach(([low, high], column) => {
      pen.lineTo(column, this.y(low));
      pen.lineTo(column, this.y(high));
    });
    pen.stroke();
    pen.fillStyle = ink(runToken(run.record));
    run.record.events.forEach(([t]) => pen.fillRect(this.x(t) - 1, this.margin.top - 4, 2, 4));
  }

  cursor(time) {
    this.time = time;
    if (this.still.width === 0) return; // hidden
    const { canvas } = this, scale = window.devicePixelRatio || 1, pen = canvas.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.drawImage(this.still, 0, 0);
    pen.scale(scale, scale);
    pen.fillStyle = ink("ink");
    pen.fillRect(this.x(time) - 0.75, this.margin.top - 4, 1.5, canvas.clientHeight - this.margin.top + 4);
  }
}
