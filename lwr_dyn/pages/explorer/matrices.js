// B, C or g at the pose as a table whose cells are shaded by size.

class MatrixCard {
  static chosen = "B"; // it stays for the next arm

  constructor(explorer) {
    const { n } = explorer.robot;
    Object.assign(this, { explorer, n, B: new Float64Array(n * n), C: new Float64Array(n * n), g: new Float64Array(n) });
    this.#build();
    this.choose(MatrixCard.chosen);
    explorerState.listen((state) => this.write(state), this.card);
  }

  compute({ q, dq }) {
    const { robot } = this.explorer;
    if (MatrixCard.chosen === "B") robot.mass_matrix(q, this.B);
    else if (MatrixCard.chosen === "C") robot.coriolis_matrix(q, dq, this.C);
    else robot.gravity_vector(q, this.g);
    return this[MatrixCard.chosen];
  }

  #build() {
    const beside = `<div class="buttons">${["B", "C", "g"].map((name) => `<button type="button">${name}</button>`).join("")}</div>`;
    const card = this.explorer.addCard("Matrices", "", '<div class="scroll" tabindex="0" role="region" aria-label="Matrix, shaded by size"><table class="heat" role="grid"><tbody></tbody></table></div>', { beside, where: "right" });
    Object.assign(this, { card, table: card.querySelector("table"), unit: card.querySelector("small"), buttons: [...card.querySelectorAll("button")] });
    this.buttons.forEach((button) => button.addEventListener("click", () => {
      this.choose(button.textContent);
      this.write(explorerState);
    }));
  }

  choose(name) {
    const { n, table } = this, columns = name === "g" ? 1 : n;
    MatrixCard.chosen = name;
    table.dataset.matrix = name;
    this.unit.textContent = { B: "inertia, kg m²", C: "of dq, kg m²/s", g: "holds the arm, N m" }[name];
    this.buttons.forEach((button) => button.setAttribute("aria-pressed", String(button.textContent === name)));
    table.tBodies[0].innerHTML = `<tr>${'<td tabindex="-1"></td>'.repeat(columns)}</tr>`.repeat(n);
    const cells = [...table.querySelectorAll("td")];
    cells[0].tabIndex = 0; // equation.js: arrow keys go on, Enter chooses
    Object.assign(this, { numbers: numberWriter(cells, 3), shade: shadeWriter(cells) });
  }

  write(state) {
    const values = this.compute(state);
    this.numbers(values);
    this.shade(values);
  }
}

explorerPanels.add("matrices", (explorer) => (explorer.robot.inverse_dynamics && explorer.robot.mass_matrix ? new MatrixCard(explorer) : null));
