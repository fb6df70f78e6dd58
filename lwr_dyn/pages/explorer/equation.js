// The equation of an entry of B, C or g that was chosen: general form, each link's share at the pose, closed form where it is short.

class EquationPanel {
  constructor(explorer) {
    const { robot, data } = explorer, { n } = robot;
    Object.assign(this, { explorer, robot, n, kind: "B", i: n > 1 ? 1 : 0, j: n > 1 ? 1 : 0, matrix: new Float64Array(n * n), zeros: new Float64Array(n) });
    Object.assign(this, { turns: data.arm.joints.map(({ kind }) => kind === "revolute"), closed: data.closed_forms, shares: new LinkShares(data.arm, data.bodies, robot.rotors) });
    this.#build();
    this.#tables();
    this.choose("B", this.i, this.j);
    explorerState.listen((state) => this.write(state), this.card);
  }

  // The chosen entry's matrix by the emitted code, and its shares by link: `links`, `rotor`, and their `sum`.
  compute({ q, dq }) {
    const { kind, i, j, robot, shares, matrix } = this, speeds = dq.length === this.n ? dq : this.zeros;
    if (kind === "B") robot.mass_matrix(q, matrix);
    else if (kind === "C") robot.coriolis_matrix(q, speeds, matrix);
    else robot.gravity_vector(q, matrix);
    shares.load = this.explorer.payload;
    this.links = shares.move(q, speeds).entry(kind, i, j);
    this.rotor = shares.rotor(kind, i, j);
    this.sum = this.links.reduce((sum, { linear, angular }) => sum + linear + angular, this.rotor);
    return this;
  }

  warm() {
    for (let k = 0; k < 200; k += 1) this.compute(explorerState);
  }

  // 0-based; j means nothing for g.
  choose(kind, i, j = 0) {
    Object.assign(this, { kind, i, j: kind === "g" ? 0 : j });
    this.buttons.forEach((button) => button.setAttribute("aria-pressed", button.dataset.kind === kind));
    this.#grid();
    const { said, turns } = this, rotor = kind === "B" && i === j && this.robot.rotors[i] !== 0;
    said.form.innerHTML = entryWords.form(kind, i, j, rotor);
    said.name.innerHTML = entryWords.name(kind, i, j);
    said.unit.textContent = entryWords.unit(kind, turns, i, j);
    this.heads.forEach((head, k) => { head.innerHTML = entryWords.parts[kind][k]; });
    this.#closed();
    this.write(explorerState);
  }

  write(state) {
    if (state.q.length !== this.n) return;
    const { links, rotor, sum, matrix, said, rows } = this.compute(state), own = matrix[this.kind === "g" ? this.i : this.i * this.n + this.j];
    const largest = Math.max(...links.map(({ linear, angular }) => Math.abs(linear + angular)), Math.abs(rotor), 1e-300);
    this.numbers(matrix);
    const first = this.kind === "g" ? this.i : Math.max(this.i, this.j), { mass } = this.explorer.payload;
    rows.forEach(({ row, numbers, bar }, k) => {
      const { linear, angular } = k <= this.n ? links[k] ?? { linear: 0, angular: 0 } : { linear: 0, angular: rotor };
      const hidden = k < this.n ? k < first : k === this.n ? !mass : rotor === 0;
      if (row.hidden !== hidden) row.hidden = hidden;
      if (hidden) return;
      numbers([linear, angular, linear + angular]);
      bar(`M0 .2H${((linear + angular) / largest).toFixed(3)}V.8H0z`);
    });
    put(said.value, fixed(own, 6));
    put(said.sum, fixed(sum, 6));
    put(said.apart, `The emitted code ${sum === own ? "gives the same number" : `is ${Math.abs(sum - own).toExponential(0)} apart`}.`);
  }

  #build() {
    const names = [...Array.from({ length: this.n }, (_, k) => `${k + 1}`), "payload", "rotor"];
    const kinds = [["B", "mass matrix"], ["C", "Coriolis matrix"], ["g", "gravity torque"]];
    const beside = `<div class="buttons" role="group" aria-label="Matrix">${kinds.map(([kind, words]) => `<button type="button" data-kind="${kind}" aria-label="${kind}, ${words}">${kind}</button>`).join("")}</div>`;
    const card = this.explorer.addCard("Equation of an entry", "choose one: click, or arrow keys and Enter", `
<div class="scroll"><table class="heat" role="grid"><tbody></tbody></table></div>
<h3><span data-said="name"></span> = <span class="mono" data-said="value"></span> <small data-said="unit"></small></h3><p class="note" data-said="form"></p>
<div class="scroll" tabindex="0" role="region" aria-label="Shares of the links"><table class="torques shares"><thead><tr><th scope="col">link</th><th class="num" scope="col"></th><th class="num" scope="col"></th><th class="num" scope="col">share</th><th scope="col"><span class="unseen">bar</span></th></tr></thead><tbody>${names.map((name) => `<tr><th scope="row">${name}</th>${'<td class="num tau"></td>'.repeat(3)}<td class="bar"><svg viewBox="-1 0 2 1" preserveAspectRatio="none" aria-hidden="true"><path class="zero" d="M0 0v1"/><path class="b"/></svg></td></tr>`).join("")}</tbody><tfoot><tr><th scope="row">sum</th><td></td><td></td><td class="num tau" data-said="sum"></td><td></td></tr></tfoot></table></div><p class="note" data-said="apart"></p><p class="note" data-said="closed"></p>`, { beside, kind: "equation" });
    this.card = card;
    this.buttons = [...card.querySelectorAll("[data-kind]")];
    this.buttons.forEach((button) => button.addEventListener("click", () => this.choose(button.dataset.kind, this.i, this.j)));
    this.table = card.querySelector("[role=grid]");
    this.heads = [...card.querySelectorAll(".shares thead .num")].slice(0, 2);
    this.rows = [...card.querySelectorAll(".shares tbody tr")].map((row) => ({ row, numbers: numberWriter([...row.querySelectorAll("td.num")], 6), bar: attributeWriter(row.querySelector("path.b"), "d") }));
    this.said = Object.fromEntries([...card.querySelectorAll("[data-said]")].map((part) => [part.dataset.said, part]));
  }

  // The chosen matrix; the same cells stay while it is the same.
  #grid() {
    const { kind, n, table } = this, wide = kind === "g" ? 1 : n;
    if (table.dataset.matrix !== kind) {
      table.dataset.matrix = kind;
      table.setAttribute("aria-label", { B: "Mass matrix", C: "Coriolis matrix", g: "Gravity torque" }[kind]);
      const cell = (row, column) => `<td aria-label="${kind}${row + 1}${kind === "g" ? "" : ` ${column + 1}`}" tabindex="-1"></td>`;
      const rows = kind === "g" ? [[...Array(n).keys()].map((i) => cell(i, 0))] : [...Array(n).keys()].map((i) => [...Array(wide).keys()].map((j) => cell(i, j)));
      table.tBodies[0].innerHTML = rows.map((row) => `<tr>${row.join("")}</tr>`).join("");
      this.cells = [...table.querySelectorAll("td")];
      this.numbers = numberWriter(this.cells, 3);
    }
    const place = kind === "g" ? this.i : this.i * n + this.j;
    this.cells.forEach((cell, k) => {
      cell.tabIndex = k === place ? 0 : -1;
      cell.setAttribute("aria-selected", k === place);
    });
  }

  // Every table of a matrix on the page, wherever it stands: click, or arrow keys and Enter.
  #tables() {
    const { signal } = this.explorer;
    const found = ({ target }) => {
      const cell = target.closest?.("table[data-matrix] td"), table = cell?.closest("table");
      return cell && { cell, table, all: [...table.querySelectorAll("td")] };
    };
    const take = ({ cell, table, all }) => {
      const place = all.indexOf(cell), kind = table.dataset.matrix;
      this.choose(kind, kind === "g" ? place : Math.floor(place / this.n), kind === "g" ? 0 : place % this.n);
      if (table === this.table) this.cells[place].focus();
      else this.card.scrollIntoView({ block: "nearest" });
    };
    document.querySelectorAll("table[data-matrix]").forEach((table) => { (table.querySelector("td[tabindex='0']") ?? table.querySelector("td")).tabIndex = 0; });
    document.addEventListener("click", (event) => { const at = found(event); if (at) take(at); }, { signal });
    document.addEventListener("keydown", (event) => {
      const at = found(event);
      if (!at) return;
      const row = at.table.dataset.matrix === "g" ? 1 : this.n, step = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: row, ArrowUp: -row }[event.key];
      if (event.key === "Enter" || event.key === " ") take(at);
      else if (step === undefined) return;
      else this.#go(at, step);
      event.preventDefault();
    }, { signal });
  }

  // The focus goes to the neighbour, and with it the one cell that Tab reaches.
  #go({ cell, all }, step) {
    const next = all[all.indexOf(cell) + step];
    if (!next) return;
    cell.tabIndex = -1;
    next.tabIndex = 0;
    next.focus();
  }

  #closed() {
    const { kind, i, j, closed, said } = this, [low, up] = [Math.min(i, j), Math.max(i, j)], entry = kind === "g" ? `g_${i + 1}` : kind === "B" ? `B_${low + 1}${up + 1}` : `C_${i + 1}${j + 1}`;
    const text = closed.texts[entry];
    said.closed.replaceChildren();
    const code = (words) => Object.assign(document.createElement("code"), { textContent: words });
    if (text === undefined) {
      const [before, after] = closed.command ? ["Closed form: longer than fits here; ", " prints it."] : ["Closed form: only for an arm without mount, tool and locked joints.", ""];
      said.closed.append(before, code(closed.command.replace("ENTRY", entry)), after);
      return;
    }
    const values = Object.entries(closed.values).filter(([letter]) => new RegExp(`\\b${letter}\\b`).test(text)).map(([letter, x]) => `${letter} = ${x}`);
    said.closed.append("Closed form: ", code(`${entry} = ${text}`), values.length ? ` (${values.join(", ")}; of a link in its DH frame, moments about its centre, without payload)` : "");
  }
}

explorerPanels.add("equation", (explorer) => {
  const { robot, data } = explorer, known = data.bodies.every(({ mass }) => mass !== null);
  return known && robot.mass_matrix && robot.coriolis_matrix && robot.gravity_vector ? new EquationPanel(explorer) : null;
});
