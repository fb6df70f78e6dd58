// Torques of the pose: g, C dq, B ddq beside the motors' limits, and B as a heat map; speeds and accelerations by field.

class TorquePanel {
  constructor(explorer) {
    const { n } = explorer.robot;
    Object.assign(this, { explorer, n, motors: explorer.data.motors });
    Object.assign(this, { g: new Float64Array(n), C: new Float64Array(n * n), B: new Float64Array(n * n), tau: new Float64Array(n), parts: new Float64Array(3 * n) });
    this.#build();
    explorerState.listen((state) => this.write(state));
  }

  // Joint i: g, C dq, B ddq in parts[3 i ...]; tau by inverse dynamics.
  compute({ q, dq, ddq }) {
    const { n, g, C, B, parts } = this;
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
    const joints = this.explorer.data.arm.joints, section = document.createElement("section");
    section.className = "card";
    section.setAttribute("aria-label", "Torques");
    const units = joints.map(({ kind }) => (kind === "revolute" ? "rad" : "m"));
    const rows = joints.map(({ name }, i) => `<tr><th scope="row">${i + 1}</th><td><input class="rate" data-of="dq" data-joint="${i}" type="text" inputmode="decimal" value="${plain(explorerState.dq[i], 6)}" aria-label="speed ${i + 1}, ${units[i]}/s"></td><td><input class="rate" data-of="ddq" data-joint="${i}" type="text" inputmode="decimal" value="${plain(explorerState.ddq[i], 6)}" aria-label="acceleration ${i + 1}, ${units[i]}/s²"></td><td class="bar"><svg viewBox="-1 0 2 1" preserveAspectRatio="none" aria-hidden="true"><path class="zero" d="M0 0v1"/><path class="g"/><path class="c"/><path class="b"/></svg></td><td class="num tau" title="${name.replace(/[<>&"]/g, "")}"></td></tr>`);
    section.innerHTML = `<div class="head"><h2>Torques <small>N m; <span class="key g">g</span> <span class="key c">C dq</span> <span class="key b">B ddq</span>; bar: the motor's limit, else the largest</small></h2></div><div class="scroll" tabindex="0" role="region" aria-label="Torques of the joints"><table class="torques"><thead><tr><th>joint</th><th>dq</th><th>ddq</th><th>torque</th><th class="num">sum</th></tr></thead><tbody>${rows.join("")}</tbody></table></div><h3>B <small>kg m²; shade by size</small></h3><div class="scroll" tabindex="0" role="region" aria-label="Mass matrix"><table class="heat"><tbody>${joints.map(() => `<tr>${joints.map(() => "<td></td>").join("")}</tr>`).join("")}</tbody></table></div>`;
    this.explorer.place(section, "right");
    this.section = section;
    this.rows = [...section.querySelectorAll(".torques tbody tr")].map((row) => ({ row, bars: ["g", "c", "b"].map((part) => row.querySelector(`path.${part}`)), tau: row.querySelector(".tau") }));
    this.cells = [...section.querySelectorAll(".heat td")];
    section.querySelectorAll(".rate").forEach((field) => field.addEventListener("change", () => {
      const { of: name, joint } = field.dataset, values = Array.from(explorerState[name]), value = Number(field.value.replace(",", "."));
      values[joint] = Number.isFinite(value) ? value : 0;
      field.value = plain(values[joint], 6);
      explorerState.set({ [name]: values });
    }));
  }

  write(state) {
    this.compute(state);
    const { n, parts, tau, B } = this, largest = Math.max(...tau.map(Math.abs), 1e-9);
    this.rows.forEach(({ row, bars, tau: cell }, i) => {
      const full = this.motors[i] ?? largest, ends = [0, 0];
      bars.forEach((bar, k) => {
        const share = parts[3 * i + k] / full, side = share < 0 ? 0 : 1, from = ends[side];
        ends[side] = Math.min(Math.max(from + share, -1), 1);
        bar.setAttribute("d", `M${from.toFixed(4)} .2H${ends[side].toFixed(4)}V.8H${from.toFixed(4)}z`);
      });
      cell.textContent = fixed(tau[i], 2);
      row.classList.toggle("over", this.motors[i] !== null && Math.abs(tau[i]) > this.motors[i]);
    });
    const most = Math.max(...B.map(Math.abs));
    this.cells.forEach((cell, k) => {
      cell.textContent = fixed(B[k], 3);
      cell.style.background = `color-mix(in srgb, var(--${B[k] < 0 ? "run2" : "run1"}) ${Math.round((30 * Math.abs(B[k])) / most)}%, transparent)`;
    });
  }
}

explorerPanels.add("torques", (explorer) => (explorer.robot.inverse_dynamics ? new TorquePanel(explorer) : null));
