// The report: unpack, set up player, figures and cells, and keep one time for all of them.

// A time without a player, for pages that have figures only.
class Clock {
  constructor() {
    Object.assign(this, { time: 0, watchers: [] });
  }

  set(time) {
    this.time = Math.max(0, time);
    this.watchers.forEach((tell) => tell(this.time));
  }

  watch(tell) {
    this.watchers.push(tell);
    tell(this.time);
  }
}

function clockOf(player) {
  if (player === null) return new Clock();
  const set = (time) => {
    player.toReplay();
    player.setTime(time);
  };
  return { set, watch: (tell) => player.watch(tell) };
}

// The numbers of a curve, from the page's pool or from a run of the player.
function curveSources(data) {
  const pool = data.numbers.map((numbers) => {
    if (Array.isArray(numbers)) return numbers.map((x) => x ?? NaN);
    const values = unpack(numbers);
    numbers.gaps.forEach((i) => { values[i] = NaN; });
    return values;
  });
  const runs = (data.runs ?? []).map((record) => new RunSeries(record));
  return (curve, plot) => {
    const at = (source) => (source === null ? null : typeof source === "number" ? pool[source] : runs[source.run].of(source));
    const run = typeof curve.y === "object" ? runs[curve.y.run] : null, times = run?.t ?? null;
    return {
      x: at(curve.x) ?? times,
      y: at(curve.y),
      t: curve.x !== null && !plot.over_time ? times : null,
      runColour: run ? ink(runToken(run.record)) : undefined,
    };
  };
}

// The series of a run by their names; errors are reference minus actual.
class RunSeries {
  constructor(record) {
    Object.assign(this, { record, t: unpack(record.t), kept: new Map() });
    this.n = record.joints.length;
  }

  flat(name) {
    if (!this.kept.has(name)) this.kept.set(name, this.#flat(name));
    return this.kept.get(name);
  }

  #flat(name) {
    const { record } = this;
    if (name === "position error") {
      const q = this.flat("q");
      return this.flat("q_ref").map((desired, i) => desired - q[i]);
    }
    if (name === "tip error") return unpack(record.tip_error);
    return unpack(name === "q" || name === "q_ref" ? record[name] : record.series[name]);
  }

  of({ quantity, joint, scale }) {
    const flat = this.flat(quantity), width = joint === null ? 1 : this.n;
    return Float64Array.from(this.t, (_, k) => scale * flat[k * width + (joint ?? 0)]);
  }
}

// Buttons for what the 3D view shows: the runs, or one of the still poses with its frames.
function poseButtons(player, data) {
  const place = document.getElementById("poses"), note = document.getElementById("still-note");
  const choices = [...(data.runs.length ? [["Replay", null, ""]] : []), ...data.stills.map((still, i) => [still.label, i, still.note])];
  const choose = (chosen) => {
    const [, index, text] = choices[chosen];
    document.querySelector(".player").classList.toggle("still", index !== null);
    player.showStill(index);
    note.textContent = text;
    note.hidden = text === "";
    buttons.forEach((button, i) => button.setAttribute("aria-pressed", String(i === chosen)));
  };
  const buttons = choices.map(([label], i) => {
    const button = element("button", "", label);
    button.type = "button";
    button.addEventListener("click", () => choose(i));
    return button;
  });
  place.append(...buttons);
  place.hidden = choices.length < 2;
  choose(0);
  return () => {
    if (document.querySelector(".player.still") && data.runs.length) choose(0);
  };
}

function paintStage(player) {
  const dark = getComputedStyle(document.documentElement).getPropertyValue("--dark").trim() === "1";
  player.stage.paint(...(dark ? [[0.6, 0.64, 0.68], [0.36, 0.4, 0.44]] : [[0.97, 0.98, 0.99], [0.8, 0.84, 0.88]]));
  player.strip.redraw();
}

function notice(text) {
  document.querySelector(".theatre")?.before(element("p", "notice", text));
}

async function startPlayer(data) {
  if (!data.scene) return null;
  try {
    const player = new Player(data, { keys: document.getElementById("stage") });
    player.toReplay = poseButtons(player, data);
    document.querySelector("body > footer").append(document.createElement("br"), document.getElementById("generator"));
    window.lwrReplay = player.hook();
    return player;
  } catch (fault) {
    notice(`The 3D view could not start (${fault.message}); the figures work without it.`);
    document.querySelector(".player").remove();
    return null;
  }
}

// Figures are drawn one at a time between other work, those in sight first.
class Drawing {
  constructor(charts) {
    this.waiting = [...charts];
    this.all = charts;
  }

  async start() {
    while (this.waiting.length) {
      await new Promise((resume) => { setTimeout(resume, 0); });
      this.#next();
    }
  }

  #next() {
    const near = (chart) => Math.abs(chart.place.getBoundingClientRect().top);
    this.waiting.sort((a, b) => near(a) - near(b));
    this.waiting.shift()?.draw();
  }

  finish() {
    while (this.waiting.length) this.#next();
  }

  again(width) {
    this.all.filter((chart) => chart.drawn).forEach((chart) => chart.draw(width));
  }
}

const PRINT_TYPE = 0.85; // size of a table on paper beside that on screen

// Paper shows everything: all details open, figures as wide as the sheet in the colours of paper, the 3D view as a still.
function printing(drawing, player) {
  const sheet = 680;
  let opened = [];
  window.addEventListener("beforeprint", () => {
    opened = [...document.querySelectorAll("details:not([open]):not(.values)")];
    opened.forEach((one) => { one.open = true; });
    document.documentElement.classList.add("printing");
    document.querySelectorAll(".scroll > table").forEach((table) => {
      const wide = table.scrollWidth * PRINT_TYPE;
      table.style.setProperty("--fit", Math.min(1, (sheet - 40) / wide));
    });
    drawing.finish();
    drawing.again(sheet);
    if (player === null) return;
    paintStage(player);
    const still = document.getElementById("print-still"), { renderer } = player.stage.viewer;
    player.stage.viewer.render();
    still.width = renderer.domElement.width;
    still.height = renderer.domElement.height;
    still.getContext("2d").drawImage(renderer.domElement, 0, 0);
  });
  window.addEventListener("afterprint", () => {
    document.documentElement.classList.remove("printing");
    opened.forEach((one) => { one.open = false; });
    drawing.again();
    if (player !== null) paintStage(player);
  });
}

// Links to something that is folded away open it first. To what stands open the browser itself goes, and at once: this
// comes later, when the reader may already be elsewhere.
function unfolding() {
  const follow = () => {
    const target = location.hash ? document.getElementById(decodeURIComponent(location.hash.slice(1))) : null;
    if (!target?.matches("details:not([open])")) return;
    target.open = true;
    target.focus({ preventScroll: true });
    target.scrollIntoView();
  };
  window.addEventListener("hashchange", follow);
  follow();
  const button = document.querySelector(".open-all");
  button?.addEventListener("click", () => {
    const open = button.getAttribute("aria-pressed") === "false";
    document.querySelectorAll("details.erratum").forEach((one) => { one.open = open; });
    button.setAttribute("aria-pressed", String(open));
    button.textContent = open ? "close all" : "open all";
  });
}

// The navigation marks the part that is read.
function readingMark() {
  const links = new Map([...document.querySelectorAll("body > nav a")].map((link) => [link.hash.slice(1), link]));
  const parts = [...document.querySelectorAll(".part")];
  const mark = () => {
    const read = parts.filter((part) => part.getBoundingClientRect().top < window.innerHeight / 3).pop() ?? parts[0];
    links.forEach((link, name) => {
      if (name === read.getAttribute("aria-labelledby")) link.setAttribute("aria-current", "location");
      else link.removeAttribute("aria-current");
    });
  };
  window.addEventListener("scroll", mark, { passive: true });
  mark();
}

async function startReport() {
  await runPacked("player");
  new CellTips(document.getElementById("tip"));
  unfolding();
  readingMark();
  const data = JSON.parse(await unpackedText("numbers"));
  const player = await startPlayer(data), clock = clockOf(player), sources = curveSources(data);
  const places = new Map([...document.querySelectorAll(".plot")].map((place) => [place.dataset.plot, place]));
  await runPacked("plotly");
  const charts = data.figures.map((record) => new Chart(places.get(record.id), record, sources, data.palettes));
  const drawing = new Drawing(charts);
  charts.forEach((chart) => new Overlay(chart, clock));
  printing(drawing, player);
  const repaint = () => {
    drawing.again();
    if (player !== null) paintStage(player);
  };
  if (player !== null) paintStage(player);
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
  window.addEventListener("resize", () => drawing.again());
  await drawing.start();
  window.lwrReport = { ready: true, charts };
}

startReport().catch((fault) => {
  notice(`The replay and the figures could not start in this browser (${fault.message}); everything else is here.`);
});
