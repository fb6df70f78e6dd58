// What another reading of the paper changes: the numbers that differ, and the torques of the same motion.

class OtherReading {
  constructor(explorer) {
    const { n } = explorer.robot;
    Object.assign(this, { explorer, n, motors: explorer.data.motors, tau: new Float64Array(n), other: new Float64Array(n) });
    this.#build();
    explorerState.listen((state) => this.write(state), this.card);
  }

  // tau of the active arm, `other` of the compared one; both carry the payload.
  compute({ q, dq, ddq }) {
    this.explorer.robot.inverse_dynamics(q, dq, ddq, this.tau);
    this.explorer.compared?.robot?.inverse_dynamics?.(q, dq, ddq, this.other);
    return this;
  }

  write(state) {
    const { tau, other } = this.compute(state);
    this.torques[0](tau);
    this.torques[1](other);
    this.apart.forEach((cell, i) => {
      const apart = other[i] - tau[i];
      put(cell, `${apart < 0 ? "−" : "+"}${Math.abs(apart).toFixed(3)}`);
      cell.classList.toggle("soft", Math.abs(apart) < 5e-4);
    });
  }

  // The errata that one of both readings applies and the other does not: [reading that applies it, erratum].
  slips() {
    const { explorer } = this, { applied, errata } = explorer.page.differing, both = [explorer.active, explorer.arms.indexOf(explorer.compared)];
    return both.flatMap((k, i) => applied[k].filter((name) => !applied[both[1 - i]].includes(name)).map((name) => [explorer.arms[k].label, errata[name]]));
  }

  // The numbers of tables and frames that differ between the active arm and the compared one.
  numbers() {
    const { explorer } = this, here = explorer.active, there = explorer.arms.indexOf(explorer.compared);
    return Object.entries(explorer.page.differing.numbers).map(([name, texts]) => [name, texts[here], texts[there]]).filter(([, a, b]) => a !== b);
  }

  #build() {
    const { explorer } = this;
    const card = explorer.addCard("Another reading", "of the same tables", `<div class="scroll" tabindex="0" role="region" aria-label="Torques of both readings"><table class="torques"><thead><tr><th scope="col">N m</th><th scope="col" class="num">${explorer.arms[explorer.active].label}</th><th scope="col" class="num other"></th><th scope="col" class="num">difference</th></tr></thead><tbody>${Array.from({ length: this.n }, (_, i) => `<tr><th scope="row">${i + 1}</th><td class="num tau"></td><td class="num tau"></td><td class="num tau"></td></tr>`).join("")}</tbody></table></div><p class="note about"></p><div class="slips"></div><details class="numbers"><summary></summary><div class="scroll" tabindex="0" role="region" aria-label="Numbers that differ"><table><thead><tr><td></td><th scope="col" class="num">${explorer.arms[explorer.active].label}</th><th scope="col" class="num other"></th></tr></thead><tbody></tbody></table></div></details>`, { beside: '<select aria-label="reading to compare with"></select>' });
    this.card = card;
    const columns = [0, 1, 2].map((k) => [...card.querySelectorAll(".torques tbody tr")].map((row) => row.querySelectorAll("td")[k]));
    this.torques = columns.slice(0, 2).map((cells) => numberWriter(cells, 3));
    [, , this.apart] = columns;
    const choice = card.querySelector("select");
    choice.append(...explorer.arms.map(({ label }, k) => new Option(label, k)).filter((_, k) => k !== explorer.active));
    choice.value = explorer.arms.indexOf(explorer.compared);
    choice.addEventListener("change", () => {
      explorer.compare(explorer.arms[choice.value]);
      this.#list();
    });
    this.#list();
  }

  #list() {
    const numbers = this.numbers(), { card, explorer } = this, body = card.querySelector(".numbers tbody");
    const { about } = explorer.page.differing, there = explorer.arms.indexOf(explorer.compared);
    card.querySelectorAll(".other").forEach((head) => { head.textContent = explorer.compared.label; });
    card.querySelector(".about").textContent = [explorer.active, there].map((k) => `${explorer.arms[k].label}: ${about[k]}`).join(". ");
    card.querySelector(".slips").replaceChildren(...this.slips().map(([label, [where, printed, read, why]]) => {
      const slip = document.createElement("details");
      slip.append(Object.assign(document.createElement("summary"), { textContent: `${where}: put right in ${label} alone` }), ...[`printed: ${printed}`, `read as: ${read}`, `why: ${why}`].map((textContent) => Object.assign(document.createElement("p"), { className: "note", textContent })));
      return slip;
    }));
    card.querySelector(".numbers summary").textContent = `${numbers.length} number${numbers.length === 1 ? "" : "s"} of the arm differ${numbers.length === 1 ? "s" : ""}`;
    body.replaceChildren(...numbers.map(([name, ...texts]) => {
      const row = document.createElement("tr");
      row.append(Object.assign(document.createElement("th"), { scope: "row", textContent: name }), ...texts.map((text) => Object.assign(document.createElement("td"), { className: "num", textContent: text })));
      return row;
    }));
  }
}

explorerPanels.add("others", (explorer) => (explorer.page.differing && explorer.robot.inverse_dynamics && explorer.compared?.robot?.inverse_dynamics ? new OtherReading(explorer) : null));
