// The strip of arm angles: for each of the eight branches where all joints are within their limits, and the arm on it.
// Arms without an arm angle get the list of their branches.

class ArmAngleStrip {
  constructor(explorer) {
    Object.assign(this, { explorer, joints: explorer.data.arm.joints, hasAngle: Boolean(explorer.robot.inverse_kinematics_arm_angle) });
    this.n = this.joints.length;
    Object.assign(this, { pose: new Float64Array(16), all: new Float64Array(8 * this.n), ends: new Float64Array(256), counts: new Int32Array(8), angle: new Float64Array(4) });
    this.names = ["+ + +", "+ + −", "+ − +", "+ − −", "− + +", "− + −", "− − +", "− − −"];
    Object.assign(this, { branch: -1, psi: 0 });
    this.#build();
    explorerState.listen((state) => this.write(state.q), this.card);
  }

  // Intervals, branch and solutions at q; what the strip shows.
  compute(q) {
    const { robot } = this.explorer;
    robot.flange_pose(q, this.pose);
    if (this.hasAngle) {
      robot.inverse_kinematics_arm_angle(q, this.angle);
      [this.psi] = this.angle;
      robot.inverse_kinematics_intervals(this.pose, 0, this.ends, this.counts);
      this.branch = this.angle[1] * -2 + this.angle[2] * -1 + this.angle[3] * -0.5 + 3.5; // signs in the order of the names
      return;
    }
    this.#solve(this.psi);
    let nearest = Infinity;
    for (let b = 0; b < 8; b += 1) {
      let apart = 0;
      for (let i = 0; i < this.n; i += 1) apart = Math.max(apart, Math.abs(Math.sin((this.all[b * this.n + i] - q[i]) / 2)));
      if (apart < nearest) [nearest, this.branch] = [apart, b];
    }
  }

  // Goes to a branch at an arm angle; stays where that is outside the limits. Gives whether it went.
  go(b, psi) {
    this.#solve(psi);
    const q = Array.from(this.all.subarray(b * this.n, (b + 1) * this.n), (x, i) => this.#nearTurn(x, i));
    if (q.some((x) => Number.isNaN(x))) {
      this.word.textContent = `${this.names[b]}: outside the limits${this.hasAngle ? " at this arm angle" : ""}`;
      return false;
    }
    this.word.textContent = "";
    this.explorer.setPose(q);
    return true;
  }

  #solve(psi) {
    const { robot } = this.explorer;
    if (this.hasAngle) robot.inverse_kinematics(this.pose, psi, this.all);
    else robot.inverse_kinematics(this.pose, this.all);
  }

  // The whole turn that is inside the limits and nearest to where the joint is; NaN where none is.
  #nearTurn(x, i) {
    const { lower, upper } = this.joints[i], turns = [0, -1, 1].map((k) => x + 2 * Math.PI * k);
    const inside = turns.filter((y) => y >= (lower ?? -Infinity) - 1e-9 && y <= (upper ?? Infinity) + 1e-9);
    inside.sort((a, b) => Math.abs(a - explorerState.q[i]) - Math.abs(b - explorerState.q[i]));
    return inside.length ? inside[0] : NaN;
  }

  #build() {
    const rows = this.names.map((name, b) => `<div class="branch"><button type="button" data-branch="${b}" aria-label="branch ${name}">${name}</button>${this.hasAngle ? '<svg viewBox="-1800 0 3600 10" preserveAspectRatio="none" aria-hidden="true"><path class="free" d=""/><path class="here" d=""/></svg>' : "<span></span>"}</div>`);
    const ends = this.hasAngle ? '<div class="branch"><label for="arm-angle">deg</label><input id="arm-angle" type="range" min="-180" max="180" step="0.1" aria-label="arm angle, deg"></div>' : "";
    const card = this.explorer.addCard(this.hasAngle ? "Arm angle" : "Branches", "shoulder, elbow, wrist", `${rows.join("")}${ends}<p class="note" id="arm-angle-word" role="status"></p>`, { beside: '<b id="arm-angle-value"></b>', where: "left" });
    Object.assign(this, { card, word: card.querySelector("#arm-angle-word"), value: card.querySelector("#arm-angle-value"), slider: card.querySelector("#arm-angle") });
    this.rows = [...card.querySelectorAll(".branch button")].map((button) => ({ button, pressed: attributeWriter(button, "aria-pressed"), free: this.hasAngle && attributeWriter(button.parentElement.querySelector(".free"), "d"), here: this.hasAngle && attributeWriter(button.parentElement.querySelector(".here"), "d"), text: button.parentElement.querySelector("span") }));
    this.rows.forEach(({ button }, b) => button.addEventListener("click", () => this.go(b, this.psi)));
    this.slider?.addEventListener("input", () => this.go(this.branch, (Number(this.slider.value) * Math.PI) / 180));
    card.addEventListener("keydown", (event) => this.#key(event));
    card.querySelectorAll("svg").forEach((svg, b) => {
      const to = ({ clientX }) => {
        const { left, width } = svg.getBoundingClientRect();
        this.go(b, (Math.min(Math.max((clientX - left) / width, 0), 1) * 2 - 1) * Math.PI);
      };
      svg.addEventListener("pointerdown", (event) => { svg.setPointerCapture(event.pointerId); to(event); });
      svg.addEventListener("pointermove", (event) => { if (event.buttons) to(event); });
    });
  }

  warm() {
    for (let k = 0; k < 300; k += 1) this.compute(explorerState.q);
  }

  write(q) {
    this.compute(q);
    this.rows.forEach(({ pressed, free, here, text }, b) => {
      const is = b === this.branch;
      pressed(String(is));
      if (this.hasAngle) {
        free(this.#bars(b));
        here(is ? `M${Math.round((this.psi * 1800) / Math.PI)} 0v10` : "");
      } else put(text, this.#list(b));
    });
    if (!this.hasAngle) return;
    const degrees = (this.psi * 180) / Math.PI;
    put(this.value, `${degrees.toFixed(1)}°`);
    if (document.activeElement !== this.slider || Math.abs(Number(this.slider.value) - degrees) > 0.2) this.slider.value = degrees;
  }

  // The intervals of a branch as bars; one that wraps is two.
  #bars(b) {
    let d = "";
    for (let k = 0; k < this.counts[b]; k += 1) {
      const from = Math.round((this.ends[32 * b + 2 * k] * 1800) / Math.PI), to = Math.round((this.ends[32 * b + 2 * k + 1] * 1800) / Math.PI);
      if (from < 1800) d += `M${from} 2H${Math.min(to, 1800)}V8H${from}z`;
      if (to > 1800) d += `M-1800 2H${to - 3600}V8H-1800z`;
    }
    return d;
  }

  // Left and right: a degree of arm angle, with Shift a tenth; over a gap to its other side. Up and down: another branch.
  #key(event) {
    const along = { ArrowLeft: -1, ArrowRight: 1 }[event.key], across = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (event.ctrlKey || event.metaKey || event.altKey || !(across || (along && this.hasAngle))) return;
    event.preventDefault();
    if (along) this.step(along, (event.shiftKey ? 0.1 : 1) * (Math.PI / 180));
    else this.#other(across);
  }

  // The next arm angle of this branch in a direction; gives whether the arm went.
  step(direction, size) {
    if (this.go(this.branch, this.psi + direction * size)) return true;
    const NEAR = 1e-6, ends = Array.from(this.ends.subarray(32 * this.branch, 32 * this.branch + 2 * this.counts[this.branch]), (end, k) => {
      const at = end + (k % 2 === 0 ? NEAR : -NEAR), turn = 2 * Math.PI, ahead = direction * (at - this.psi);
      return [ahead - turn * Math.floor(ahead / turn), at];
    }).filter(([ahead]) => ahead > 10 * NEAR);
    return ends.sort(([a], [b]) => a - b).some(([, at]) => this.go(this.branch, at));
  }

  // The next branch in which the arm can stand at this arm angle.
  #other(direction) {
    for (let k = 1; k < 8; k += 1) {
      const b = (this.branch + direction * k + 8) % 8;
      if (!this.go(b, this.psi)) continue;
      this.rows[b].button.focus();
      return;
    }
  }

  #list(b) {
    const q = Array.from(this.all.subarray(b * this.n, (b + 1) * this.n), (x, i) => this.#nearTurn(x, i));
    if (Number.isNaN(this.all[b * this.n])) return "beyond reach";
    return q.some((x) => Number.isNaN(x)) ? "outside the limits" : q.map((x) => fixed((x * 180) / Math.PI, 1)).join(", ");
  }
}

explorerPanels.add("strip", (explorer) => (explorer.robot.inverse_kinematics ? new ArmAngleStrip(explorer) : null));
