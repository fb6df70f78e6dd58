// Gains of a PD loop for the inertia at this pose or the largest one, what one degree of error takes of the motors, and what the coupling of B does to the loop.

class GainsPanel {
  constructor(explorer) {
    const { n } = explorer.robot;
    Object.assign(this, { explorer, n, omega: 50, xi: 1, rate: 1000, modes: new LoopModes(n), chosen: "pose", largest: null, searched: "" });
    Object.assign(this, { joints: explorer.data.arm.joints, motors: explorer.data.motors, torques: new Float64Array(n) });
    this.#build();
    explorerState.listen((state) => this.write(state), this.card);
  }

  // Kp, Kd, modes; `torques` [N m or N] that an error of 1 deg or 1 mm takes.
  compute({ q }) {
    const { modes, joints, torques } = this;
    this.explorer.robot.mass_matrix(q, modes.B);
    modes.compute(this.omega, this.xi, this.chosen === "largest" ? this.largest : null);
    for (let i = 0; i < this.n; i += 1) torques[i] = modes.Kp[i] * (joints[i].kind === "revolute" ? Math.PI / 180 : 0.001);
    return this;
  }

  warm() {
    for (let k = 0; k < 300; k += 1) this.compute(explorerState);
  }

  write(state) {
    this.#search();
    const { modes, torques, motors, omega, xi, rate, rows, said } = this.compute(state);
    rows.forEach(({ row, cells }, i) => {
      const share = motors[i] === null ? null : torques[i] / motors[i];
      const texts = [modes.b[i].toPrecision(4), modes.Kp[i].toPrecision(4), modes.Kd[i].toPrecision(4), torques[i].toPrecision(3), share === null ? "unknown" : `${(100 * share).toFixed(1)} %`];
      cells.forEach((cell, k) => put(cell, texts[k]));
      row.classList.toggle("over", share !== null && share > 1);
    });
    this.modal.forEach((row, k) => {
      const texts = modes.defined ? [modes.frequency(k, omega).toFixed(1), modes.damping(k, xi).toFixed(3), `${modes.led[k] + 1}`] : ["", "", ""];
      row.forEach((cell, c) => put(cell, texts[c]));
    });
    const least = modes.defined ? modes.leastRate(omega, xi) : NaN;
    put(said.range, modes.defined ? this.#words() : "B is singular here: a joint moves nothing, and the loop has no modes.");
    put(said.sampled, !modes.defined ? "" : `${least > rate ? "Unstable at rest here when sampled at" : "Sampled at"} ${plain(rate, 3)} Hz${least > rate ? "" : ", it holds at rest here"}: the least rate is ${least.toPrecision(3)} Hz (torque held, no delay).`);
    said.sampled.classList.toggle("alarm", least > rate);
  }

  #words() {
    if (this.chosen === "pose") return `Alone, each joint would have ${plain(this.omega, 3)} rad/s and ${plain(this.xi, 3)}.`;
    return this.largest ? "Gains as lwr-dyn gains makes them; alone, a joint would have ωₙ where its inertia is largest." : "The largest inertias are searched; until then, those of this pose.";
  }

  // The largest inertias with this payload, joint by joint so that the page stays awake.
  #search() {
    const { robot, payload, signal } = this.explorer, key = JSON.stringify(payload);
    if (this.chosen === "pose" || this.searched === key) return;
    Object.assign(this, { searched: key, largest: null });
    const found = new Float64Array(this.n);
    const next = (i) => setTimeout(() => {
      if (signal.aborted || this.searched !== key) return;
      found[i] = largestInertia(robot, this.joints, i);
      if (i > 0) next(i - 1);
      else {
        this.largest = found;
        this.write(explorerState);
      }
    });
    next(this.n - 1);
  }

  #build() {
    const unit = this.joints.every(({ kind }) => kind === "revolute") ? ["N m/rad", "N m s/rad", "1° takes", "N m", "kg m²"] : ["N m/rad, N/m", "N m s/rad, N s/m", "1°, 1 mm takes", "N m, N", "kg m², kg"];
    const fields = [["omega", "ω<sub>n</sub>", "rad/s", "natural frequency"], ["xi", "ξ", "", "damping ratio"], ["rate", "sampled at", "Hz", "sampling rate"]];
    const card = this.explorer.addCard("Gains", "PD with gravity compensated", `
<p class="fields">${fields.map(([name, label, u, words]) => `<label>${label} <input class="rate" data-field="${name}" type="text" inputmode="decimal" value="${this[name]}" aria-label="${words}${u ? `, ${u}` : ""}"> ${u}</label>`).join("")}<label>B<sub>ii</sub> <select aria-label="inertia that the gains are made for"><option value="pose">at this pose</option><option value="largest">largest within the limits</option></select></label></p><p class="note alarm" role="status" data-said="field"></p>
<div class="scroll" tabindex="0" role="region" aria-label="Gains of the joints"><table class="torques"><thead><tr><th scope="col">joint</th><th class="num" scope="col">B<sub>ii</sub><br><small>${unit[4]}</small></th><th class="num" scope="col">Kp<br><small>${unit[0]}</small></th><th class="num" scope="col">Kd<br><small>${unit[1]}</small></th><th class="num" scope="col">${unit[2]}<br><small>${unit[3]}</small></th><th class="num" scope="col">of<br>limit</th></tr></thead><tbody>${this.joints.map((_, i) => `<tr><th scope="row">${i + 1}</th>${'<td class="num tau"></td>'.repeat(5)}</tr>`).join("")}</tbody></table></div>
<h3>With all of B <small>the modes of the loop, slowest first</small></h3><div class="scroll" tabindex="0" role="region" aria-label="Modes of the loop"><table class="heat modes"><tbody>${["rad/s", "damping", "most in joint"].map((name) => `<tr><th scope="row">${name}</th>${"<td></td>".repeat(this.n)}</tr>`).join("")}</tbody></table></div>
<p class="note" data-said="range"></p><p class="note" data-said="sampled"></p><p class="note">Kp = ω<sub>n</sub>² B<sub>ii</sub>, Kd = 2 ξ ω<sub>n</sub> B<sub>ii</sub> (Siciliano et al., Robotics, eq. 8.22). Modes: B ẍ + Kd ẋ + Kp x = 0.</p>`, { kind: "gains" });
    this.card = card;
    this.rows = [...card.querySelectorAll(".torques tbody tr")].map((row) => ({ row, cells: [...row.querySelectorAll("td")] }));
    const modal = [...card.querySelectorAll(".modes tr")].map((row) => [...row.querySelectorAll("td")]);
    this.modal = this.joints.map((_, k) => modal.map((row) => row[k]));
    this.said = Object.fromEntries([...card.querySelectorAll("[data-said]")].map((part) => [part.dataset.said, part]));
    card.querySelector("select").addEventListener("change", ({ target }) => {
      this.chosen = target.value;
      this.write(explorerState);
    });
    card.querySelectorAll("[data-field]").forEach((field) => field.addEventListener("change", () => this.#take(field)));
  }

  // A field's number; one that is none stays out, and it is said.
  #take(field) {
    const value = numberIn(field), right = value > 0 && value <= 1e9;
    this.said.field.textContent = right ? "" : "a number above 0, at most 1e9";
    if (!right) return;
    this[field.dataset.field] = value;
    this.write(explorerState);
  }
}

explorerPanels.add("gains", (explorer) => (explorer.robot.mass_matrix ? new GainsPanel(explorer) : null));
