// The explorer: a list of arms with one active; positions -> kinematics -> numbers and stage; what panels are given.

const SIDE = -1; // the azimuth from which arms side by side are seen [rad]

class Explorer {
  constructor(page) {
    this.page = page;
    this.state = explorerState;
    this.stage = new Stage(document.getElementById("stage"), page.stage);
    ["reference", "target", "trace", "frame"].forEach((part) => this.stage.show(part, false));
    this.arms = page.arms.map((data) => ({ label: data.label, data, robot: armFunctions(data), run: this.stage.runs[data.run], q: Float64Array.from(data.start) }));
    this.payload = { mass: 0, at: [0, 0, 0] };
    this.on = new Map(); // switches by their id
    this.shown = []; // the arm shown of each group
    this.arms.forEach((entry) => { this.shown[entry.data.group] ??= entry; });
    this.stage.runs.forEach((run) => plainColours(this.stage, run));
    this.poseCard = new PoseCard(this);
    this.chooser = new ArmChooser(this);
    if (page.live) this.#follow();
  }

  // Another arm of the page becomes the active one: all that belongs to an arm is made anew.
  choose(index) {
    const before = this.arms[this.active], entry = this.arms[index], { data, robot, run } = entry;
    this.#leave();
    this.leaving = new AbortController();
    Object.assign(this, { active: index, signal: this.leaving.signal, data, arm: data.arm, run, robot });
    window.robot = robot;
    this.shown[data.group] = entry;
    if (before && before.data.group === data.group) entry.q = this.#taken(before.q, data);
    armPieces.show(index);
    this.#place();
    this.stage.setPose(run, entry.q);
    run.azimuth = this.#side(this.arm, entry.q);
    this.parts = new ArmParts(this);
    this.poseCard.take();
    this.setPose(entry.q);
    explorerPanels.build(this);
    this.#switches();
    this.chooser.write();
    if (!before || (before.run !== run && before.data.group === data.group)) this.fit();
  }

  // The arm that the active one is compared with: another reading, or the arm beside it; null alone.
  get compared() {
    const others = this.arms.filter((entry) => entry !== this.arms[this.active]);
    return others.includes(this.chosen) ? this.chosen : others.find(({ data }) => data.group !== this.data.group) ?? others[0] ?? null;
  }

  compare(entry) {
    this.chosen = entry;
    this.state.compute();
  }

  // A mass [kg] at a point of the flange's frame [m]: every arm of the page carries it.
  carry(mass, at) {
    this.payload = { mass, at };
    this.arms.forEach((entry) => entry.robot?.carry(mass, at));
    this.state.compute();
  }

  // q [rad or m] as the sliders have it.
  positions() {
    return this.values.map((value, i) => armKinematics.meant(this.arm.joints[i], value));
  }

  // Moves the arm, and writes the numbers; `values` in deg, m of sliding joints.
  setValues(values) {
    this.values = values;
    const q = this.positions(), pose = armKinematics.flange(this.arm, q), { dq } = explorerState;
    this.arms[this.active].q = Float64Array.from(q);
    this.stage.setPose(this.run, q);
    this.poseCard.write(pose);
    this.stage.viewer.set_dirty();
    explorerState.set(dq.length === q.length ? { q } : { q, dq: q.map(() => 0), ddq: q.map(() => 0) });
  }

  // q in rad, m of sliding joints.
  setPose(q) {
    this.setValues(Array.from(q, (x, i) => round(armKinematics.shown(this.arm.joints[i], x), 9)));
  }

  flangePose() {
    return armKinematics.rows(armKinematics.flange(this.arm, this.positions()));
  }

  drawnPose() {
    return this.stage.flangePose(this.data.run);
  }

  // A card of a panel, its name and what is beside it at its head: "left" or "right" of the picture, else below.
  addCard(name, about, html, { beside = "", where, kind } = {}) {
    const card = document.createElement("section");
    card.className = kind ? `card ${kind}` : "card";
    card.setAttribute("aria-label", name);
    card.innerHTML = `<div class="head"><h2>${name}${about === null ? "" : ` <small>${about}</small>`}</h2>${beside}</div>${html}`;
    document.getElementById(where ? `panels-${where}` : "panels").append(card);
    return card;
  }

  // A switch of a panel, below the picture; it stays on for the next arm.
  addSwitch(id, text) {
    const label = document.createElement("label");
    label.innerHTML = `<input id="${id}" type="checkbox"> ${text}`;
    document.getElementById("panel-switches").append(label);
    return label.firstChild;
  }

  // An object on the stage until another arm is chosen.
  addObject(path, object) {
    object.userData.added = true;
    this.stage.viewer.set_object(path, object);
    this.signal.addEventListener("abort", () => this.stage.viewer.delete_path(path));
  }

  // Nothing of the arm that was active stays: panels, switches, parts of the drawing, listeners.
  #leave() {
    document.querySelectorAll("#arm-switches input, #panel-switches input").forEach((box) => this.on.set(box.id, box.checked));
    this.leaving?.abort();
    this.parts?.remove();
    explorerState.forget();
    document.querySelectorAll(".panels, #panel-switches").forEach((place) => place.replaceChildren());
  }

  // Positions of an arm for another one of its group, inside the limits; its own where it has other joints.
  #taken(q, { arm, start }) {
    if (q.length !== arm.joints.length) return Float64Array.from(start);
    return q.map((x, i) => Math.min(Math.max(x, arm.joints[i].slider[0]), arm.joints[i].slider[1]));
  }

  // One arm of each group is seen; groups stand side by side along the picture's horizontal.
  #place() {
    this.stage.runs.forEach((run) => this.stage.viewer.set_property(run.root, "visible", false));
    this.stage.framed = this.shown.map((entry) => entry.run);
    this.stage.framed.forEach((run) => this.stage.viewer.set_property(run.root, "visible", true));
    if (this.shown.length < 2) return;
    const gap = 0.7 * this.shown.reduce((sum, { data }) => sum + armKinematics.reach(data.arm), 0), floor = Math.min(...this.stage.framed.map(({ record }) => record.floor));
    this.shown.forEach(({ run }, k) => {
      const off = gap * (k - (this.shown.length - 1) / 2);
      this.stage.viewer.set_transform(run.root, new THREE.Matrix4().makeTranslation(-Math.sin(SIDE) * off, Math.cos(SIDE) * off, floor - run.record.floor).elements);
    });
  }

  // All arms that are shown at their present poses.
  fit() {
    this.shown.forEach(({ run, q, data }) => {
      run.q = Float64Array.from(q);
      run.azimuth = this.#side(data.arm, q);
      run.reference = this.parts.outline(run).map((point) => point.toArray());
    });
    this.stage.frameView();
  }

  // The arm is seen from the side of the upright plane that it is nearest to.
  #side(arm, q) {
    if (this.shown.length > 1) return SIDE;
    const { 12: x, 13: y } = armKinematics.flange(arm, q), out = Math.hypot(x, y);
    return out > 0.15 * armKinematics.reach(arm) ? Math.atan2(y, x) - 1 : this.stage.azimuth;
  }

  #switches() {
    document.querySelectorAll("#arm-switches input").forEach((box) => {
      const act = () => (box.id === "see-through" ? this.parts.seeThrough(box.checked) : this.parts.show(box.id, box.checked));
      box.addEventListener("change", act, { signal: this.signal });
      box.checked = this.on.get(box.id) ?? box.checked;
      act();
    });
    document.querySelectorAll("#panel-switches input").forEach((box) => {
      if (this.on.get(box.id) && !box.checked) box.click();
    });
  }

  // A live page shows what is sent to it: the positions are read back from the stage.
  #follow() {
    const { viewer } = this.stage, [run] = this.stage.runs;
    viewer.connect();
    setInterval(() => {
      const q = this.arm.joints.map((joint, i) => {
        const pose = this.stage.node(run.chain[i + 1]).matrix, motion = new THREE.Matrix4().fromArray(joint.origin).invert().multiply(pose).elements;
        return joint.kind === "revolute" ? nearest(Math.atan2(motion[1], motion[0]), this.positions()[i]) : motion[14];
      });
      if (q.some((x, i) => Math.abs(x - this.positions()[i]) > 1e-6)) this.setPose(q);
    }, 100);
  }
}

// The angle a whole number of turns away that is nearest to another one.
function nearest(angle, other) {
  return angle + 2 * Math.PI * Math.round((other - angle) / (2 * Math.PI));
}
