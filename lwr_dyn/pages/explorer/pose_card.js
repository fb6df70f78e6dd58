// The card of the pose: a slider and a field for each joint, buttons, the flange's pose, and the text for the command.

class PoseCard {
  constructor(explorer) {
    this.explorer = explorer;
    const cells = (names) => names.map((name) => document.getElementById(`pose_${name}`));
    Object.assign(this, { place: numberWriter(cells(["x", "y", "z"]), 3), angles: numberWriter(cells(["roll", "pitch", "yaw"]), 4), text: document.getElementById("q-deg") });
    this.#buttons();
    explorerState.atRest(() => this.rows?.forEach((row, i) => row(explorer.values[i], true)));
  }

  // The sliders of the arm that was chosen.
  take() {
    this.rows = this.explorer.arm.joints.map((joint, i) => this.#row(joint, i));
  }

  // The numbers of a pose, and the sliders at `explorer.values`.
  write(pose) {
    this.rows.forEach((row, i) => row(this.explorer.values[i]));
    this.place([1000 * pose[12], 1000 * pose[13], 1000 * pose[14]]);
    this.angles(armKinematics.rollPitchYaw(pose).map((angle) => (angle * 180) / Math.PI));
    this.text.value = this.command();
  }

  #inside(i, value) {
    const joint = this.explorer.arm.joints[i], [low, up] = joint.slider.map((end) => armKinematics.shown(joint, end));
    return Math.min(Math.max(Number.isNaN(value) ? this.explorer.values[i] : value, low), up);
  }

  #row(joint, i) {
    const slider = document.getElementById(`slider_${i + 1}`), field = document.getElementById(`value_${i + 1}`);
    const step = joint.kind === "revolute" ? 0.1 : 0.001, unit = joint.kind === "revolute" ? "degrees" : "metres", [low, up] = joint.slider.map((end) => armKinematics.shown(joint, end));
    const half = (up - low) / 300; // about half a pixel of the slider
    let last = NaN, drawn = NaN, wasOutside = false;
    const set = (value) => {
      last = drawn = NaN; // what stands in the slider and the field is not what was written
      this.explorer.setValues(this.explorer.values.map((old, k) => (k === i ? this.#inside(i, value) : old)));
    };
    slider.addEventListener("input", () => {
      const near = Math.round(Number(slider.value) / step) * step; // whole steps inside the limits
      set(round(near > up ? near - step : near < low ? near + step : near, 3));
    }, { signal: this.explorer.signal });
    field.addEventListener("change", () => set(numberIn(field)), { signal: this.explorer.signal });
    return (value, atRest = false) => {
      if (value === last && (value === drawn || !atRest)) return;
      const text = plain(value, 4); // the text to copy has all digits
      if (atRest || !(Math.abs(value - drawn) < half)) {
        drawn = value;
        slider.value = text;
        slider.setAttribute("aria-valuetext", `${text} ${unit}`);
      }
      if (value === last) return;
      last = value;
      field.value = text;
      const isOutside = value < low - 1e-6 || value > up + 1e-6; // only a live page can be sent there
      if (isOutside !== wasOutside) field.classList.toggle("outside", isOutside);
      wasOutside = isOutside;
    };
  }

  #buttons() {
    const { explorer } = this, on = (id, act) => document.getElementById(id).addEventListener("click", act);
    on("start", () => explorer.setPose(explorer.data.start));
    on("middle", () => explorer.setPose(explorer.arm.joints.map(({ lower, upper }) => (lower === null || upper === null ? 0 : (lower + upper) / 2))));
    on("random", () => explorer.setValues(explorer.arm.joints.map((joint) => {
      const [low, up] = joint.slider.map((end) => armKinematics.shown(joint, end));
      return round(low + Math.random() * (up - low), joint.kind === "revolute" ? 1 : 3);
    })));
    on("view", () => explorer.fit());
    on("copy", () => this.copy(this.command()));
  }

  // Positions as the command takes them.
  command() {
    return `--q-deg=${this.explorer.values.map((value) => plain(value, 9)).join(",")}`;
  }

  // A text into the clipboard; it stands in the field until the arm moves.
  async copy(text) {
    const copied = document.getElementById("copied");
    this.text.value = text;
    this.text.select();
    const done = await navigator.clipboard?.writeText(text).then(() => true, () => false);
    copied.textContent = done || document.execCommand("copy") ? "copied" : "press Ctrl-C";
    setTimeout(() => { copied.textContent = ""; }, 2500);
  }
}
