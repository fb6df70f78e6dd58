// The player: one time for all runs; controls, readouts, listeners of the time, and an interface for scripts and tests.

class Player {
  // `covered` as of the stage; `keys` is the element that receives keys.
  constructor(data, { covered, keys = document } = {}) {
    this.stage = new Stage(document.getElementById("stage"), data, covered);
    this.#take();
    this.time = 0;
    this.playing = false;
    this.watchers = [];
    this.keys = keys;
    this.strip = new Strip(document.getElementById("strip"), this.runs, this.duration, (t) => this.setTime(t));
    this.#controls();
    this.#switches(data.start);
    document.getElementById("generator").textContent = this.#foot(data.made_by);
    if (data.live) this.stage.viewer.connect();
    this.setTime(0);
  }

  setTime(t) {
    this.time = Math.min(Math.max(Number(t) || 0, 0), this.duration);
    this.runs.forEach((run, i) => {
      const now = sampleAt(run, this.time);
      this.stage.setPose(run, now.q);
      this.stage.setTarget(run, now.qRef);
      run.traceTube?.until(this.time);
      this.cards[i](now);
    });
    document.getElementById("scrub").value = this.time;
    document.getElementById("clock").textContent = `${this.time.toFixed(3)} / ${this.duration.toFixed(3)} s`;
    this.strip.cursor(this.time);
    this.watchers.forEach((tell) => tell(this.time));
    this.stage.viewer.set_dirty();
  }

  // Puts another run of the same arm in the place of run i, at the same time; what is shown stays as it is.
  replace(i, record) {
    this.stage.replace(i, record);
    this.#take();
    this.runs.forEach((_, k) => this.stage.showRun(k, true));
    this.strip.replace(this.runs, this.duration);
    document.getElementById("scrub").max = this.duration;
    ["reference", "trace", "target", "frames", "beside"].forEach((id) => document.getElementById(id).dispatchEvent(new Event("change")));
    this.setTime(this.time);
  }

  // The runs of the stage, their duration, and a card for each.
  #take() {
    this.runs = this.stage.runs;
    this.duration = Math.max(0, ...this.runs.map((run) => run.t[run.t.length - 1]));
    document.getElementById("cards").replaceChildren();
    this.cards = this.runs.map((run, i) => this.#card(run, i));
  }

  // `tell(time)` is called now and whenever the time changes.
  watch(tell) {
    this.watchers.push(tell);
    tell(this.time);
  }

  showStill(index) {
    this.play(false);
    this.stage.showStill(index);
    if (index === null) this.strip.visible.forEach((visible, i) => this.stage.showRun(i, visible));
  }

  // For scripts and tests.
  hook() {
    return {
      ready: true,
      duration: this.duration,
      runs: this.runs.length,
      setTime: (t) => this.setTime(t),
      time: () => this.time,
      play: (on = true) => this.play(on),
      playing: () => this.playing,
      replace: (run, record) => this.replace(run, record),
      watch: (tell) => this.watch(tell),
      flangePose: (run = 0) => this.stage.flangePose(run),
      stage: this.stage,
    };
  }

  play(on) {
    if (on && this.time >= this.duration) this.setTime(0);
    this.playing = on;
    document.getElementById("play").textContent = on ? "\u275A\u275A" : "\u25B6";
    if (!on) return;
    let before = performance.now();
    const step = (now) => {
      if (!this.playing) return;
      const ahead = this.time + ((now - before) / 1000) * Number(document.getElementById("speed").value);
      before = now;
      const ended = ahead >= this.duration, loop = document.getElementById("loop").checked;
      this.setTime(ended && loop ? 0 : ahead);
      if (ended && !loop) this.play(false);
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  #controls() {
    const scrub = document.getElementById("scrub");
    scrub.max = this.duration;
    scrub.addEventListener("input", () => this.setTime(scrub.value));
    document.getElementById("play").addEventListener("click", () => this.play(!this.playing));
    document.getElementById("home").addEventListener("click", () => this.stage.frameView());
    this.keys.addEventListener("keydown", (event) => {
      if (/^(INPUT|SELECT|BUTTON)$/.test(event.target.tagName)) return;
      const act = {
        " ": () => this.play(!this.playing),
        ArrowLeft: () => this.setTime(this.time - 0.1),
        ArrowRight: () => this.setTime(this.time + 0.1),
      }[event.key];
      if (act === undefined) return;
      event.preventDefault();
      act();
    });
  }

  #switches(start) {
    const stage = this.stage;
    const bind = (id, checked, act) => {
      const box = document.getElementById(id);
      box.checked = checked;
      box.addEventListener("change", () => act(box.checked));
      act(checked);
    };
    bind("reference", true, (on) => stage.show("reference", on));
    bind("trace", start.trace, (on) => stage.show("trace", on));
    bind("target", true, (on) => stage.show("target", on));
    bind("frames", start.frames, (on) => stage.show("frame", on));
    bind("beside", start.beside, (on) => stage.setBeside(on));
    bind("tree", false, (on) => document.body.classList.toggle("tree", on));
    document.getElementById("beside-switch").hidden = this.runs.length < 2;
  }

  // A run's card; returns the function that writes the readouts of one moment into it.
  #card(run, i) {
    const { record } = run, card = element("article", "card"), head = element("header");
    const eye = element("input"), numbers = element("div", "numbers"), joints = element("div", "joints");
    card.style.setProperty("--accent", `var(--${runToken(record)})`);
    Object.assign(eye, { type: "checkbox", checked: true, title: "show this run", ariaLabel: `show ${record.label}` });
    eye.addEventListener("change", () => {
      card.classList.toggle("hidden", !eye.checked);
      this.stage.showRun(i, eye.checked);
      this.strip.visible[i] = eye.checked;
      this.strip.redraw();
    });
    head.append(element("span", "", record.label), eye);
    const facts = record.facts.map(([key, value]) => `${key} ${value}`).join(" \u00B7 ");
    const tip = element("b"), joint = element("b"), name = element("span");
    numbers.append(element("span", "", "tip error"), tip, name, joint);
    const bars = record.joints.map((_, k) => {
      const cell = element("div"), well = element("i"), bar = element("u");
      well.append(bar);
      cell.append(well, String(k + 1));
      joints.append(cell);
      return bar;
    });
    const about = element("details", "about");
    about.append(element("summary", "", "about this run"), element("div", "facts", facts), joints);
    about.open = window.innerWidth > 700;
    card.append(head, numbers);
    if (record.stops) card.append(element("div", "stops", record.stops));
    if (record.caveat) card.append(element("div", "caveat", record.caveat));
    card.append(about);
    document.getElementById("cards").append(card);
    const largest = Math.max(1e-12, run.q.reduce((most, q, k) => Math.max(most, Math.abs(run.qRef[k] - q)), 0));
    return (now) => {
      const errors = Array.from(now.q, (q, k) => now.qRef[k] - q);
      const worst = errors.reduce((best, e, k) => (Math.abs(e) > Math.abs(errors[best]) ? k : best), 0);
      const unit = record.joints[worst].kind === "revolute" ? "mrad" : "mm";
      tip.textContent = `${plainNumber(1000 * now.tipError)} mm`;
      name.textContent = `largest joint error, ${record.joints[worst].name}`;
      joint.textContent = `${plainNumber(1000 * errors[worst])} ${unit}`;
      errors.forEach((error, k) => {
        const half = (50 * Math.abs(error)) / largest;
        bars[k].style.height = `${half}%`;
        bars[k].style.top = error > 0 ? `${50 - half}%` : "50%";
      });
    };
  }

  #foot(madeBy) {
    const thinned = this.runs.filter((run) => run.record.samples[0] < run.record.samples[1]);
    const note = [...new Set(thinned.map(({ t, record }) => `${record.samples.join(" of ")} samples (${Math.round((t.length - 1) / t.at(-1))} Hz)`))];
    return [madeBy, ...note].join(" \u00B7 ");
  }
}
