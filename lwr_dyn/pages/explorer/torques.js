// Torques of the pose: g, C dq, B ddq of the arm with its payload beside the motors' limits; speeds and accelerations
// by field. A thin mark is the sum by the reading that this one is compared with.

class TorquePanel {
  constructor(explorer) {
    const { n } = explorer.robot, { motors } = explorer.data, made = (size) => new Float64Array(size);
    Object.assign(this, { explorer, n, motors });
    Object.assign(this, { g: made(n), C: made(n * n), B: made(n * n), tau: made(n), parts: made(3 * n), other: made(n) });
    this.#build();
    explorerState.listen((state) => this.write(state), this.section);
  }

  // Joint i: g, C dq, B ddq in parts[3 i ...]; tau by inverse dynamics.
  compute({ q, dq, ddq }) {
    const { n, g, C, B, parts } = this, { robot } = this.explorer;
    robot.gravity_vector(q, g);
    robot.mass_matrix(q, B);
    robot.coriolis_matrix(q, dq, C);
    robot.inverse_dynamics(q, dq, ddq, this.tau);
    for (let i = 0; i < n; i += 1) {
      let ofSpeed = 0, ofAcceleration = 0;
      for (let j = 0; j < n; j += 1) {
        ofSpeed += C[i * n + j] * dq[j];
        ofAcceleration += B[i * n + j] * ddq[j];
      }
      parts[3 * i] = g[i];
      parts[3 * i + 1] = ofSpeed;
      parts[3 * i + 2] = ofAcceleration;
    }
  }

  warm() {
    for (let k = 0; k < 1000; k += 1) this.compute(explorerState);
  }

  #build() {
    const { joints } = this.explorer.data.arm;
    const field = (i, of, word, unit) => `<td><input class="rate" data-of="${of}" data-joint="${i}" type="text" inputmode="decimal" value="${plain(explorerState[of][i], 6)}" aria-label="${word} ${i + 1}, ${unit}"></td>`;
    const rows = joints.map(({ name, kind }, i) => {
      const turns = kind === "revolute", unit = turns ? "rad" : "m", limit = this.motors[i] === null ? "limit unknown" : `limit ${plain(this.motors[i], 3)} ${turns ? "N m" : "N"}`;
      return `<tr title="${name.replace(/[<>&"]/g, "")}: ${limit}"><th scope="row">${i + 1}${turns ? "" : " <small>N</small>"}</th>${field(i, "dq", "speed", `${unit}/s`)}${field(i, "ddq", "acceleration", `${unit}/s²`)}<td class="bar"><svg viewBox="-1000 0 2000 10" preserveAspectRatio="none" aria-hidden="true"><path class="g"/><path class="c"/><path class="b"/><path class="zero" d="M0 0v10"/><path class="other"/></svg></td><td class="num tau"></td></tr>`;
    });
    const section = this.explorer.addCard("Torques", `N m; <span class="key g">g</span> <span class="key c">C dq</span> <span class="key b">B ddq</span>; full bar: the motor's limit, else the largest`, `<div class="scroll" tabindex="0" role="region" aria-label="Torques of the joints"><table class="torques"><thead><tr><th scope="col">joint</th><th scope="col">dq</th><th scope="col">ddq</th><th scope="col">torque</th><th scope="col" class="num">sum</th></tr></thead><tbody>${rows.join("")}</tbody></table></div><p class="note alarm" role="status"></p>`, { where: "right" });
    this.section = section;
    const lines = [...section.querySelectorAll("tbody tr")], bars = (part) => lines.map((row) => attributeWriter(row.querySelector(`path.${part}`), "d"));
    Object.assign(this, { bars: ["g", "c", "b"].map(bars), marks: bars("other"), over: lines.map((row) => attributeWriter(row, "class")) });
    this.sums = numberWriter(lines.map((row) => row.querySelector(".tau")), 2);
    section.querySelectorAll(".rate").forEach((input) => input.addEventListener("change", () => {
      const { of: name, joint } = input.dataset, values = Array.from(explorerState[name]), value = numberIn(input), old = plain(values[joint], 6);
      put(section.querySelector("p.note"), Number.isNaN(value) ? `“${input.value}” is no number: ${old} stays.` : "");
      if (!Number.isNaN(value)) values[joint] = value;
      input.value = plain(values[joint], 6);
      explorerState.set({ [name]: values });
    }));
  }

  write(state) {
    this.compute(state);
    const { n, parts, tau, motors } = this, other = this.#compared(state);
    let largest = 1e-9;
    for (let i = 0; i < n; i += 1) largest = Math.max(largest, Math.abs(tau[i]));
    for (let i = 0; i < n; i += 1) {
      const scale = 1000 / (motors[i] ?? largest), ends = [0, 0];
      for (let k = 0; k < 3; k += 1) {
        const share = scale * parts[3 * i + k], side = share < 0 ? 0 : 1, from = ends[side];
        ends[side] = Math.round(Math.min(Math.max(from + share, -1000), 1000));
        this.bars[k][i](from === ends[side] ? "" : `M${from} 2H${ends[side]}V8H${from}z`);
      }
      this.marks[i](other ? `M${Math.round(Math.min(Math.max(scale * other[i], -1000), 1000))} 0v10` : "");
      this.over[i](motors[i] !== null && Math.abs(tau[i]) > motors[i] ? "over" : "");
    }
    this.sums(tau);
  }

  // The sums by another reading of the same arm; null alone.
  #compared({ q, dq, ddq }) {
    const { explorer, other } = this, { compared } = explorer;
    if (!explorer.page.differing || !compared?.robot?.inverse_dynamics) return null;
    compared.robot.inverse_dynamics(q, dq, ddq, other);
    return other;
  }
}

explorerPanels.add("torques", (explorer) => (explorer.robot.inverse_dynamics ? new TorquePanel(explorer) : null));
