// The strip below the stage: tip error of every run over time, its events, and a cursor that can be dragged.

class Strip {
  constructor(canvas, runs, duration, onPick) {
    Object.assign(this, { canvas, runs, duration, visible: runs.map(() => true) });
    this.largest = Math.max(1e-9, ...runs.map((run) => run.tipError.reduce((a, b) => Math.max(a, b), 0)));
    this.margin = { left: 64, right: 8, top: 17, bottom: 4 };
    const pick = (event) => {
      if (event.buttons & 1) onPick(this.timeAt(event.offsetX));
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      pick(event);
    });
    canvas.addEventListener("pointermove", pick);
    window.addEventListener("resize", () => this.redraw());
    this.redraw();
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
    return top + height * (1 - error / this.largest);
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
    this.runs.forEach((run, i) => {
      if (this.visible[i]) this.curve(pen, run);
    });
    this.cursor(this.time || 0);
  }

  ink(name) {
    return getComputedStyle(this.canvas).getPropertyValue(name);
  }

  axes(pen) {
    const left = this.margin.left, end = this.canvas.clientWidth - this.margin.right;
    pen.font = "11px system-ui, 'DejaVu Sans', sans-serif";
    pen.fillStyle = this.ink("--soft");
    pen.strokeStyle = this.ink("--line");
    pen.textBaseline = "middle";
    const models = new Set(this.runs.map((run) => run.record.tip_model));
    pen.fillText(["tip error [mm]", ...models].join(", "), left, 6);
    pen.textAlign = "right";
    [0, 0.5, 1].forEach((part) => {
      const y = this.y(part * this.largest);
      pen.beginPath();
      pen.moveTo(left, y);
      pen.lineTo(end, y);
      pen.stroke();
      pen.fillText(plainNumber(1000 * part * this.largest), left - 7, part === 0 ? y - 3 : y);
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
    pen.strokeStyle = run.record.colour;
    pen.lineWidth = 1.4;
    pen.lineJoin = "round";
    pen.beginPath();
    columns.forEach(([low, high], column) => {
      pen.lineTo(column, this.y(low));
      pen.lineTo(column, this.y(high));
    });
    pen.stroke();
    pen.fillStyle = run.record.colour;
    run.record.events.forEach(([t]) => pen.fillRect(this.x(t) - 1, this.margin.top - 5, 2, 5));
  }

  cursor(time) {
    this.time = time;
    if (this.still.width === 0) return; // hidden
    const { canvas } = this, scale = window.devicePixelRatio || 1, pen = canvas.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.drawImage(this.still, 0, 0);
    pen.scale(scale, scale);
    pen.fillStyle = this.ink("--ink");
    pen.fillRect(this.x(time) - 0.75, this.margin.top - 6, 1.5, canvas.clientHeight - this.margin.top + 6);
  }
}
