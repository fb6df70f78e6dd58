// The report: everything can be read without this; it adds the 3D replay when asked for, and one time for all figures.

class Report {
  constructor() {
    Object.assign(this, { time: 0, player: null, ready: true });
    this.charts = [...document.querySelectorAll(".chart")].map((place) => new Chart(place, this));
    document.getElementById("start-3d")?.addEventListener("click", () => this.start3d());
  }

  // Unpacked when first needed; raises for a browser that cannot.
  numbers() {
    this.unpacked ??= unpackedText("numbers").then((text) => {
      const data = JSON.parse(text), sources = curveSources(data);
      data.figures.forEach((record) => this.charts.find((chart) => chart.id === record.id).fill(record, sources));
      return data;
    });
    return this.unpacked;
  }

  set(time) {
    if (this.player) {
      this.player.toReplay();
      this.player.setTime(time);
    } else this.show(Math.max(0, time));
  }

  show(time) {
    this.time = time;
    this.charts.forEach((chart) => chart.show(time));
  }

  async start3d() {
    const button = document.getElementById("start-3d"), view = document.querySelector(".view"), box = document.getElementById("player");
    button.disabled = true;
    try {
      await runPacked("player");
      const data = await this.numbers();
      box.hidden = false;
      this.player = new Player(data, { keys: document.getElementById("stage") });
      view.hidden = true;
      this.player.toReplay = poseButtons(this.player, data);
      dock();
      if (data.runs.length) {
        this.player.watch((time) => this.show(time));
        if (this.time > 0) this.player.setTime(this.time);
      }
      window.lwrReplay = this.player.hook();
      document.getElementById("stage").focus({ preventScroll: true });
    } catch (fault) {
      box.remove();
      button.remove();
      notice(`The 3D view could not start (${fault.message}); the figures work without it.`);
    }
  }
}

// Buttons for what the 3D view shows: the runs, or one of the still poses with its frames.
function poseButtons(player, data) {
  const place = document.getElementById("poses"), note = document.getElementById("still-note");
  const choices = [...(data.runs.length ? [["Replay", null, ""]] : []), ...data.stills.map((still, i) => [still.label, i, still.note])];
  const choose = (chosen) => {
    const [, index, text] = choices[chosen];
    document.getElementById("player").classList.toggle("still", index !== null);
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

// Away from the 3D view its time bar stays in sight, so that figures can be read in step.
function dock() {
  const bar = document.getElementById("controls"), box = document.getElementById("bar");
  new IntersectionObserver(([seen]) => bar.classList.toggle("docked", !seen.isIntersecting)).observe(box);
}

function notice(text) {
  const place = element("p", "notice", text);
  place.setAttribute("role", "status");
  document.querySelector("main").prepend(place);
}

// Paper shows everything: all details open, the 3D view as a still.
function printing(report) {
  let opened = [];
  window.addEventListener("beforeprint", () => {
    opened = [...document.querySelectorAll("details:not([open])")];
    opened.forEach((one) => { one.open = true; });
    if (report.player === null) return;
    const still = document.getElementById("print-still"), { renderer } = report.player.stage.viewer;
    report.player.stage.viewer.render();
    still.width = renderer.domElement.width;
    still.height = renderer.domElement.height;
    still.getContext("2d").drawImage(renderer.domElement, 0, 0);
  });
  window.addEventListener("afterprint", () => {
    opened.forEach((one) => { one.open = false; });
  });
}

// A link to something that is folded away opens all that it is folded in.
function unfolding() {
  const follow = () => {
    const target = location.hash ? document.getElementById(decodeURIComponent(location.hash.slice(1))) : null;
    const folded = [];
    for (let one = target; one; one = one.parentElement) if (one.matches("details:not([open])")) folded.push(one);
    if (folded.length === 0) return;
    folded.forEach((one) => { one.open = true; });
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

// The top bar marks the part that is read.
function readingMark() {
  const links = [...document.querySelectorAll(".top nav a")], parts = [...document.querySelectorAll(".part")];
  const mark = () => {
    const read = parts.filter((part) => part.getBoundingClientRect().top < window.innerHeight / 3).pop() ?? parts[0];
    links.forEach((link) => {
      if (link.hash.slice(1) === read.id) link.setAttribute("aria-current", "true");
      else link.removeAttribute("aria-current");
    });
  };
  window.addEventListener("scroll", mark, { passive: true });
  mark();
}

{
  const report = new Report();
  window.lwrReport = report;
  printing(report);
  unfolding();
  readingMark();
}
