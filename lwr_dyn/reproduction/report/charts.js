// Figures in step with the replay: a cursor and values over time, a dot on a path; a click sets the time, a drag zooms.

const PLANE = { width: 2000, height: 1000 };

class Panel {
  constructor(box, chart) {
    this.chart = chart;
    this.plane = box.querySelector(".plane");
    this.now = box.querySelector(".now");
    this.fact = box.querySelector(".fact");
    this.lines = box.querySelector("svg.lines");
    this.xTicks = box.querySelector(".xt");
    this.whole = this.plane.dataset.x.split(" ").map(Number);
    this.y = this.plane.dataset.y.split(" ").map(Number);
    this.x = this.whole;
    this.factor = Number(this.plane.dataset.magnified ?? 1);
    this.firstTicks = this.xTicks?.innerHTML;
    this.marks = [];
  }

  // Its numbers, once they are unpacked.
  fill(record, sources) {
    this.record = record;
    this.curves = record.curves.map((curve) => ({ ...curve, ...sources(curve, this.factor) }));
  }

  share(x) {
    return (x - this.x[0]) / (this.x[1] - this.x[0]);
  }

  down(y) {
    if (this.plane.dataset.log === undefined) return 1 - (y - this.y[0]) / (this.y[1] - this.y[0]);
    const [low, high] = this.y.map(Math.log10);
    return 1 - (Math.log10(Math.max(y, this.y[0])) - low) / (high - low);
  }

  timeAt(clientX) {
    const box = this.plane.getBoundingClientRect();
    return this.x[0] + ((clientX - box.left) / box.width) * (this.x[1] - this.x[0]);
  }

  #mark(k, kind) {
    if (!this.marks[k]) {
      this.marks[k] = element("div", kind);
      this.plane.append(this.marks[k]);
    }
    return this.marks[k];
  }

  showTime(time) {
    const line = this.#mark(0, "cursor"), at = this.share(time);
    line.hidden = at < -0.001 || at > 1.001;
    line.style.left = `${100 * at}%`;
    if (!this.curves) return;
    const values = this.curves.filter((curve) => curve.style === "line").map((curve) => Number(blendAt(curve.x, curve.y, time).toPrecision(3)));
    this.now.textContent = values.map((value) => String(value).replace("-", "\u2212")).join(" | ");
    this.fact.hidden = true;
  }

  // A path is drawn over positions; the dot is where its run is now.
  showPlace(time) {
    this.curves?.forEach((curve, k) => {
      if (!curve.t || curve.dashed) return;
      const dot = this.#mark(k, "dot");
      dot.style.left = `${100 * this.share(blendAt(curve.t, curve.x, time))}%`;
      dot.style.top = `${100 * this.down(blendAt(curve.t, curve.y, time))}%`;
    });
  }

  // The lines in full, so that a zoom shows every sample that the page has.
  #redraw() {
    if (this.redrawn) return;
    this.redrawn = true;
    this.lines.querySelectorAll("path.l").forEach((path) => {
      const { x, y } = this.curves[Number(path.dataset.c)], span = this.whole[1] - this.whole[0];
      let pen = "M";
      const steps = Array.from(x, (value, k) => {
        if (!Number.isFinite(y[k])) {
          pen = "M";
          return "";
        }
        const step = `${pen}${((PLANE.width * (value - this.whole[0])) / span).toFixed(1)},${(PLANE.height * this.down(y[k])).toFixed(1)}`;
        pen = "L";
        return step;
      });
      path.setAttribute("d", steps.join(""));
    });
  }

  zoom(range) {
    this.x = range ?? this.whole;
    if (range) this.#redraw();
    const span = this.whole[1] - this.whole[0], left = (PLANE.width * (this.x[0] - this.whole[0])) / span;
    this.lines.setAttribute("viewBox", `${left} 0 ${(PLANE.width * (this.x[1] - this.x[0])) / span} ${PLANE.height}`);
    if (!range) this.xTicks.innerHTML = this.firstTicks;
    else {
      this.xTicks.replaceChildren(...roundTicks(...this.x, 3).map((tick) => {
        const mark = element("span", "", `${Number(tick.toPrecision(6))}`);
        mark.style.left = `${100 * this.share(tick)}%`;
        return mark;
      }));
    }
  }
}

function roundTicks(low, high, most) {
  const power = 10 ** Math.floor(Math.log10((high - low) / most));
  const step = [1, 2, 5, 10, 20].map((k) => k * power).find((size) => Math.floor(high / size) - Math.ceil(low / size) + 1 <= most + 1);
  const ticks = [];
  for (let k = Math.ceil(low / step); k * step <= high; k += 1) ticks.push(k * step);
  return ticks;
}

class Chart {
  // `report.numbers()` unpacks the numbers of the page when they are first needed.
  constructor(place, report) {
    Object.assign(this, { place, report, id: place.dataset.plot });
    this.overTime = place.classList.contains("times");
    this.isPath = place.classList.contains("paths");
    this.panels = [...place.querySelectorAll(".panel")].map((box) => new Panel(box, this));
    this.range = null;
    if (this.overTime) this.panels.forEach((panel) => this.#pointer(panel));
  }

  fill(record, sources) {
    this.panels.forEach((panel, p) => panel.fill(record.panels[p], sources));
    this.filled = true;
  }

  show(time) {
    if (this.overTime) {
      this.at ??= this.place.querySelector("figcaption").appendChild(element("output", "at"));
      this.at.textContent = `at ${time.toFixed(2)} s`;
      this.panels.forEach((panel) => panel.showTime(time));
    } else if (this.isPath) this.panels.forEach((panel) => panel.showPlace(time));
  }

  // All panels over time show the same stretch; null is the whole time.
  zoom(range) {
    this.range = range;
    this.panels.forEach((panel) => panel.zoom(range));
    this.show(this.report.time);
    this.#button();
  }

  #button() {
    if (!this.reset) {
      this.reset = element("button", "reset", "whole time");
      this.reset.type = "button";
      this.reset.addEventListener("click", () => this.zoom(null));
      this.place.querySelector("figcaption").append(this.reset);
    }
    this.reset.hidden = this.range === null;
  }

  // A tap or click sets the time; a mouse that drags marks the stretch to zoom to; a finger scrolls the page.
  #pointer(panel) {
    const { plane } = panel;
    let start = null, band = null;
    const end = () => {
      band?.remove();
      start = band = null;
    };
    plane.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      start = { x: event.clientX, y: event.clientY };
      if (event.pointerType === "mouse") plane.setPointerCapture(event.pointerId);
    });
    plane.addEventListener("pointermove", (event) => {
      if (start === null || event.pointerType !== "mouse" || Math.abs(event.clientX - start.x) < 4) return;
      band ??= plane.appendChild(element("div", "band"));
      const box = plane.getBoundingClientRect(), ends = [start.x, event.clientX].map((x) => Math.min(Math.max(x - box.left, 0), box.width));
      band.style.left = `${Math.min(...ends)}px`;
      band.style.width = `${Math.abs(ends[1] - ends[0])}px`;
    });
    plane.addEventListener("pointercancel", end);
    plane.addEventListener("pointerup", async (event) => {
      if (start === null) return;
      const ends = [panel.timeAt(start.x), panel.timeAt(event.clientX)].map((t) => Math.min(Math.max(t, panel.x[0]), panel.x[1]));
      const dragged = band !== null, moved = Math.hypot(event.clientX - start.x, event.clientY - start.y) > 4;
      end();
      await this.report.numbers();
      if (dragged && Math.abs(ends[1] - ends[0]) > 1e-6) this.zoom([Math.min(...ends), Math.max(...ends)]);
      else if (!moved) this.report.set(ends[1]);
    });
    plane.addEventListener("dblclick", () => this.zoom(null));
  }
}
