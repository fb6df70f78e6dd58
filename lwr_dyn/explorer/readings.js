// What a slip of the paper changes, and what a payload does: torques of the same motion by other inverse dynamics.

class OtherTorques {
  constructor(explorer) {
    const { n } = robot, names = Object.keys(otherReadings);
    Object.assign(this, { explorer, n, names, chosen: names[0] ?? "", tau: new Float64Array(n), other: new Float64Array(n), loaded: new Float64Array(n), payload: new Float64Array(10) });
    this.#build();
    explorerState.listen((state) => this.write(state));
  }

  // tau of this reading, `other` of the chosen one, `loaded` of this one with the payload.
  compute({ q, dq, ddq }) {
    robot.inverse_dynamics(q, dq, ddq, this.tau);
    if (this.chosen) otherReadings[this.chosen].inverse_dynamics(q, dq, ddq, this.other);
    if (loadedRobot) loadedRobot.inverse_dynamics(q, dq, ddq, this.payload, this.loaded);
    return this;
  }

  // A mass [kg] at a point of the flange's frame [m].
  carry(mass, [x, y, z]) {
    this.payload.set([mass, mass * x, mass * y, mass * z, mass * (y * y + z * z), -mass * x * y, mass * (x * x + z * z), -mass * x * z, -mass * y * z, mass * (x * x + y * y)]);
    this.compute(explorerState);
  }

  write(state) {
    const { tau, other, loaded, chosen } = this.compute(state), { motors } = this.explorer.data;
    this.rows.forEach((cells, i) => {
      cells.tau.textContent = fixed(tau[i], 3);
      if (cells.other) cells.other.textContent = chosen ? `${fixed(other[i], 3)} (${other[i] - tau[i] < 0 ? "−" : "+"}${Math.abs(other[i] - tau[i]).toFixed(3)})` : "";
      if (cells.loaded) {
        cells.loaded.textContent = fixed(loaded[i], 3);
        cells.loaded.parentElement.classList.toggle("over", motors[i] !== null && Math.abs(loaded[i]) > motors[i]);
      }
    });
  }

  #build() {
    const card = document.createElement("section"), columns = ["tau", ...(this.names.length ? ["other"] : []), ...(loadedRobot ? ["loaded"] : [])];
    const heads = { tau: "this reading", other: '<select aria-label="other reading"></select> <small>(difference)</small>', loaded: "with payload" };
    const fields = ["kg", "x m", "y m", "z m"].map((name) => `<td><label>${name} <input class="rate" type="text" inputmode="decimal" value="0" aria-label="payload, ${name}"></label></td>`);
    card.className = "card";
    card.setAttribute("aria-label", "Other readings and payload");
    card.innerHTML = `<div class="head"><h2>What changes <small>torques of the same motion, N m</small></h2></div>${loadedRobot ? `<h3>Payload at a point of the flange's frame</h3><div class="scroll" tabindex="0" role="region" aria-label="Payload"><table class="torques payload"><tbody><tr>${fields.join("")}</tr></tbody></table></div><p class="note" role="status"></p>` : ""}<div class="scroll" tabindex="0" role="region" aria-label="Torques compared"><table class="torques"><thead><tr><th>joint</th>${columns.map((name) => `<th class="num">${heads[name]}</th>`).join("")}</tr></thead><tbody>${Array.from({ length: this.n }, (_, i) => `<tr><th scope="row">${i + 1}</th>${columns.map((name) => `<td class="num tau" data-of="${name}"></td>`).join("")}</tr>`).join("")}</tbody></table></div>`;
    document.getElementById("panels").append(card);
    this.rows = [...card.querySelectorAll("table:not(.payload) tbody tr")].map((row) => Object.fromEntries([...row.querySelectorAll("td")].map((cell) => [cell.dataset.of, cell])));
    const choice = card.querySelector("select");
    if (choice) choice.append(...this.names.map((name) => new Option(name, name)));
    choice?.addEventListener("change", () => {
      this.chosen = choice.value;
      this.write(explorerState);
    });
    const inputs = [...card.querySelectorAll(".payload input")];
    this.word = card.querySelector("p.note");
    inputs.forEach((input) => input.addEventListener("change", () => {
      const [mass, ...at] = inputs.map((field) => Number(field.value.trim().replace(",", ".") || NaN));
      const right = [mass, ...at].every(Number.isFinite) && mass >= 0;
      this.word.textContent = right ? "" : "four numbers, the mass not below 0";
      if (!right) return;
      this.carry(mass, at);
      this.write(explorerState);
    }));
  }
}

if (robot.inverse_dynamics) window.lwrExplorer.others = new OtherTorques(window.lwrExplorer);
