// Cells of the tables: what a number was computed from, shown on hover, focus and tap; arrow keys move between cells.

class CellTips {
  constructor(tip) {
    this.tip = tip;
    this.shown = null;
    document.querySelectorAll("table.printed").forEach((table) => this.#table(table));
    document.querySelectorAll("button.tile").forEach((tile) => this.#tour(tile));
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.hide();
    });
    document.addEventListener("pointerdown", (event) => {
      if (!event.target.closest("button.cell")) this.hide();
    });
    window.addEventListener("scroll", () => this.#place(), { passive: true, capture: true });
  }

  #table(table) {
    const cells = [...table.querySelectorAll("button.cell")];
    cells.forEach((cell, i) => {
      cell.tabIndex = i === 0 ? 0 : -1;
    });
    const cellOf = (event) => event.target.closest("button.cell");
    table.addEventListener("pointerover", (event) => {
      if (event.pointerType !== "mouse") return;
      if (cellOf(event)) this.show(cellOf(event));
      else this.hide();
    });
    table.addEventListener("pointerleave", (event) => {
      if (event.pointerType === "mouse") this.hide();
    });
    table.addEventListener("focusin", (event) => {
      if (cellOf(event)) this.show(cellOf(event));
    });
    table.addEventListener("focusout", () => this.hide());
    table.addEventListener("click", (event) => {
      if (cellOf(event)) this.show(cellOf(event));
    });
    table.addEventListener("keydown", (event) => this.#walk(event, table, cellOf(event)));
  }

  // A tile of the summary leads from one cell of its verdict to the next.
  #tour(tile) {
    const cells = [...document.querySelectorAll("button.cell")].filter((cell) => cell.dataset.verdict === tile.dataset.verdict);
    tile.disabled = cells.length === 0;
    let next = 0;
    tile.addEventListener("click", () => {
      const cell = cells[next];
      next = (next + 1) % cells.length;
      cell.closest("table").querySelectorAll("button.cell").forEach((other) => { other.tabIndex = other === cell ? 0 : -1; });
      cell.scrollIntoView({ block: "center" });
      cell.focus({ preventScroll: true });
    });
  }

  #walk(event, table, cell) {
    const step = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] }[event.key];
    if (!step || !cell) return;
    const rows = [...table.tBodies[0].rows].map((row) => [...row.querySelectorAll("button.cell")]);
    const y = rows.findIndex((row) => row.includes(cell)), x = rows[y].indexOf(cell);
    const next = rows[y + step[0]]?.[x + step[1]];
    event.preventDefault();
    if (!next) return;
    cell.tabIndex = -1;
    next.tabIndex = 0;
    next.focus();
  }

  show(cell) {
    if (this.shown && this.shown !== cell) this.hide();
    this.shown = cell;
    const { place, verdict, source, formula, conversion, note } = cell.dataset;
    const rows = Object.entries({ source, formula, conversion, note }).filter(([, text]) => text);
    const list = element("dl");
    rows.forEach(([name, text]) => list.append(element("dt", "", name), element("dd", name, text)));
    this.tip.replaceChildren(element("strong", "", place), element("span", "verdict", verdict), list);
    this.tip.hidden = false;
    cell.setAttribute("aria-describedby", "tip");
    this.#place();
  }

  hide() {
    this.tip.hidden = true;
    this.shown?.removeAttribute("aria-describedby");
    this.shown = null;
  }

  // Right of the cell, where there is no room below it, else above; never beyond the window.
  #place() {
    if (!this.shown) return;
    const cell = this.shown.parentElement.getBoundingClientRect(), { tip } = this, gap = 6;
    const width = document.documentElement.clientWidth, height = window.innerHeight;
    tip.style.visibility = cell.bottom < 0 || cell.top > height ? "hidden" : "visible";
    const within = (x, least, most) => Math.max(least, Math.min(x, most));
    const beside = cell.right + gap + tip.offsetWidth <= width, fits = cell.bottom + gap + tip.offsetHeight <= height;
    const left = beside ? cell.right + gap : within(cell.left, gap, width - tip.offsetWidth - gap);
    const top = beside ? within(cell.top, gap, height - tip.offsetHeight - gap) : fits ? cell.bottom + gap : cell.top - tip.offsetHeight - gap;
    tip.style.left = `${left}px`;
    tip.style.top = `${Math.max(gap, top)}px`;
  }
}
