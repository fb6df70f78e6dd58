// What moves over the figures with the time of the replay: a cursor line that can be dragged, a dot on a path, and the
// values at the cursor as text.

class Overlay {
  constructor(chart, clock) {
    Object.assign(this, { chart, clock, time: 0 });
    this.layer = element("div", "overlay");
    chart.place.append(this.layer);
    this.marks = chart.record.over_time ? chart.panels.map((_, p) => this.#cursor(p)) : this.#dots();
    if (chart.record.over_time) {
      this.values = this.#valueTable();
      this.#clicks();
    }
    chart.onDraw = () => this.#place();
    clock.watch((time) => {
      this.time = time;
      this.#place();
      this.values?.();
    });
  }

  axes(p) {
    const layout = this.chart.graph._fullLayout, axis = p === 0 ? "" : String(p + 1);
    return { x: layout[`xaxis${axis}`], y: layout[`yaxis${axis}`] };
  }

  #cursor(p) {
    const line = element("div", "cursor");
    this.layer.append(line);
    line.addEventListener("pointerdown", (event) => {
      line.setPointerCapture(event.pointerId);
      event.preventDefault();
    });
    line.addEventListener("pointermove", (event) => {
      if (line.hasPointerCapture(event.pointerId)) this.clock.set(this.timeAt(p, event.clientX));
    });
    return () => {
      const { x, y } = this.axes(p), at = x.l2p(this.time);
      line.hidden = !(at >= -0.5 && at <= x._length + 0.5);
      line.style.transform = `translate(${x._offset + at}px, ${y._offset}px)`;
      line.style.height = `${y._length}px`;
    };
  }

  // A path is drawn over positions; the dot is where its run is now.
  #dots() {
    return this.chart.panels.flatMap((panel, p) => panel.curves.filter((curve) => curve.t).map((curve) => {
      const dot = element("div", "dot");
      this.layer.append(dot);
      return () => {
        const { x, y } = this.axes(p), now = { x: blendAt(curve.t, curve.x, this.time), y: blendAt(curve.t, curve.y, this.time) };
        const left = x.l2p(now.x), top = y.l2p(now.y);
        dot.hidden = !(left >= 0 && left <= x._length && top >= 0 && top <= y._length);
        dot.style.transform = `translate(${x._offset + left}px, ${y._offset + top}px)`;
      };
    }));
  }

  #place() {
    if (this.chart.drawn) this.marks.forEach((mark) => mark());
  }

  timeAt(p, clientX) {
    const { x } = this.axes(p), box = this.chart.graph.getBoundingClientRect();
    return x.p2l(clientX - box.left - x._offset);
  }

  // A click that does not drag sets the time; a drag zooms, as plotly does.
  #clicks() {
    let start = null;
    this.chart.graph.addEventListener("pointerdown", (event) => {
      start = event.button === 0 ? [event.clientX, event.clientY] : null;
    }, true);
    window.addEventListener("pointercancel", () => { start = null; });
    window.addEventListener("pointerup", (event) => {
      if (start === null) return;
      const still = Math.hypot(event.clientX - start[0], event.clientY - start[1]) < 4, panel = this.#panelAt(event);
      start = null;
      if (still && panel >= 0) this.clock.set(this.timeAt(panel, event.clientX));
    }, true);
  }

  #panelAt(event) {
    const box = this.chart.graph.getBoundingClientRect(), px = event.clientX - box.left, py = event.clientY - box.top;
    return this.chart.panels.findIndex((_, p) => {
      const { x, y } = this.axes(p);
      return px >= x._offset && px <= x._offset + x._length && py >= y._offset && py <= y._offset + y._length;
    });
  }

  #valueTable() {
    const box = element("details", "values"), summary = element("summary"), table = element("table", "plain");
    const rows = this.chart.panels.flatMap((panel) => panel.curves.map((curve) => {
      const row = element("tr"), value = element("td", "figure");
      const name = [panel.title, curve.label].filter(Boolean).join(", ");
      const head = element("th", "", name);
      head.scope = "row";
      row.append(head, value);
      table.append(row);
      return () => {
        value.textContent = `${Number(blendAt(curve.x, curve.y, this.time).toPrecision(5))} ${raised(panel.y_unit)}`;
      };
    }));
    const write = () => {
      summary.textContent = `Values at ${this.time.toFixed(3)} s`;
      if (box.open) rows.forEach((row) => row());
    };
    box.append(summary, table);
    box.addEventListener("toggle", write);
    this.chart.place.after(box);
    return write;
  }
}

// A curve at a time: straight lines between its points, its ends beyond them.
function blendAt(times, values, time) {
  const last = times.length - 1, k = Math.min(Math.max(lastAtMost(times, time), 0), Math.max(last - 1, 0)), next = Math.min(k + 1, last);
  const span = times[next] - times[k], part = span > 0 ? Math.min(Math.max((time - times[k]) / span, 0), 1) : 0;
  return values[k] + part * (values[next] - values[k]);
}
