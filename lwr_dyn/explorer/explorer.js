// The explorer: sliders -> positions -> kinematics -> numbers and stage; switches; an interface for scripts and tests.

class Explorer {
  constructor(data) {
    this.data = data;
    this.arm = data.arm;
    this.values = data.start.map((q, i) => round(armKinematics.shown(this.arm.joints[i], q), 9)); // deg, m
    this.stage = new Stage(document.getElementById("stage"), data.stage);
    ["reference", "target", "trace", "frame"].forEach((part) => this.stage.show(part, false));
    this.stage.runs[0].azimuth = this.#side(data.start);
    this.stage.setPose(this.stage.runs[0], data.start);
    this.parts = new ArmParts(this.stage, data);
    this.rows = this.arm.joints.map((joint, i) => this.#row(joint, i));
    this.#buttons();
    this.#switches();
    if (data.live) this.#follow();
    this.setPose(this.positions());
    this.#fit();
    window.addEventListener("resize", () => this.#fit());
  }

  // q [rad or m] as the sliders have it.
  positions() {
    return this.values.map((value, i) => armKinematics.meant(this.arm.joints[i], value));
  }

  // Moves the arm, and writes the numbers; `values` in deg, m of sliding joints.
  setValues(values) {
    this.values = values;
    const q = this.positions(), pose = armKinematics.flange(this.arm, q);
    this.rows.forEach((row, i) => row(this.values[i]));
    this.stage.setPose(this.stage.runs[0], q);
    this.#write(pose);
    this.stage.viewer.set_dirty();
    explorerState.set(explorerState.dq.length ? { q } : { q, dq: q.map(() => 0), ddq: q.map(() => 0) });
  }

  // q in rad, m of sliding joints.
  setPose(q) {
    this.setValues(Array.from(q, (x, i) => round(armKinematics.shown(this.arm.joints[i], x), 9)));
  }

  // For scripts and tests.
  hook() {
    return {
      ready: true,
      data: this.data,
      stage: this.stage,
      state: explorerState,
      parts: this.parts,
      setPose: (q) => this.setPose(q),
      positions: () => this.positions(),
      flangePose: () => armKinematics.rows(armKinematics.flange(this.arm, this.positions())),
      drawnPose: () => this.stage.flangePose(0),
    };
  }

  #inside(i, value) {
    const joint = this.arm.joints[i], [low, up] = joint.slider.map((end) => armKinematics.shown(joint, end));
    return Math.min(Math.max(Number.isFinite(value) ? value : this.values[i], low), up);
  }

  #row(joint, i) {
    const slider = document.getElementById(`slider_${i + 1}`), field = document.getElementById(`value_${i + 1}`);
    const step = joint.kind === "revolute" ? 0.1 : 0.001, [low, up] = joint.slider.map((end) => armKinematics.shown(joint, end));
    const set = (value) => this.setValues(this.values.map((old, k) => (k === i ? this.#inside(i, value) : old)));
    slider.addEventListener("input", () => {
      const near = Math.round(Number(slider.value) / step) * step; // whole steps inside the limits
      set(round(near > up ? near - step : near < low ? near + step : near, 3));
    });
    field.addEventListener("change", () => set(field.value.trim() === "" ? NaN : Number(field.value.replace(",", "."))));
    return (value) => {
      slider.value = value;
      slider.setAttribute("aria-valuetext", `${plain(value, 6)} ${joint.kind === "revolute" ? "degrees" : "metres"}`);
      field.value = plain(value, 4); // the text to copy has all digits
      field.classList.toggle("outside", value < low - 1e-6 || value > up + 1e-6); // only a live page can be sent there
    };
  }

  #buttons() {
    const on = (id, act) => document.getElementById(id).addEventListener("click", act);
    on("start", () => this.setPose(this.data.start));
    on("middle", () => this.setPose(this.arm.joints.map(({ lower, upper }) => (lower === null || upper === null ? 0 : (lower + upper) / 2))));
    on("random", () => this.setValues(this.arm.joints.map((joint) => {
      const [low, up] = joint.slider.map((end) => armKinematics.shown(joint, end));
      return round(low + Math.random() * (up - low), joint.kind === "revolute" ? 1 : 3);
    })));
    on("view", () => this.#fit());
    const copied = document.getElementById("copied"), text = document.getElementById("q-deg");
    on("copy", async () => {
      text.select();
      const done = await navigator.clipboard?.writeText(text.value).then(() => true, () => false);
      copied.textContent = done || document.execCommand("copy") ? "copied" : "press Ctrl-C";
      setTimeout(() => { copied.textContent = ""; }, 2500);
    });
  }

  // The whole arm at its present pose.
  #fit() {
    const [run] = this.stage.runs, q = this.positions();
    run.q = Float64Array.from(q);
    run.azimuth = this.#side(q);
    run.reference = this.parts.outline().map((point) => point.toArray());
    this.stage.frameView();
  }

  // The arm is seen from the side of the upright plane that it is nearest to.
  #side(q) {
    const { 12: x, 13: y } = armKinematics.flange(this.arm, q), out = Math.hypot(x, y);
    return out > 0.15 * armKinematics.reach(this.arm) ? Math.atan2(y, x) - 1 : this.stage.azimuth;
  }

  #switches() {
    document.querySelectorAll("#switches input:not(#turn)").forEach((box) => {
      const act = () => (box.id === "see-through" ? this.parts.seeThrough(box.checked) : this.parts.show(box.id, box.checked));
      box.addEventListener("change", act);
      act();
    });
  }

  #write(pose) {
    const put = (id, text) => { document.getElementById(id).textContent = text; };
    ["x", "y", "z"].forEach((axis, k) => put(`pose_${axis}`, fixed(1000 * pose[12 + k], 3)));
    const angles = armKinematics.rollPitchYaw(pose);
    ["roll", "pitch", "yaw"].forEach((angle, k) => put(`pose_${angle}`, fixed((angles[k] * 180) / Math.PI, 4)));
    document.getElementById("q-deg").value = `--q-deg=${this.values.map((value) => plain(value, 9)).join(",")}`;
  }

  // A live page shows what is sent to it: the positions are read back from the stage.
  #follow() {
    const { viewer } = this.stage, run = this.stage.runs[0];
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

function round(value, digits) {
  const out = Number(value.toFixed(digits));
  return out === 0 ? 0 : out; // no minus zero
}

// At most `digits` decimals, no exponent and no zeros at the end.
function plain(value, digits) {
  const text = value.toFixed(digits);
  return text.includes(".") ? text.replace(/\.?0+$/, "").replace(/^-0$/, "0") : text;
}

function fixed(value, digits) {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? (0).toFixed(digits) : text;
}

window.lwrExplorer = new Explorer(JSON.parse(document.getElementById("explorer-data").textContent)).hook();
