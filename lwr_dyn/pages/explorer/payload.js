// A payload: a mass at a point of the flange's frame, in the torques' card; every arm of the page carries it.

class PayloadFields {
  constructor(explorer) {
    const names = ["kg", "x m", "y m", "z m"], { mass, at } = explorer.payload, group = document.createElement("div");
    group.className = "payload";
    group.setAttribute("role", "group");
    group.setAttribute("aria-label", "Payload at a point of the flange's frame");
    group.innerHTML = `<b>Payload</b>${names.map((name) => `<label>${name.replace(" m", "")} <input class="rate" type="text" inputmode="decimal" aria-label="payload, ${name}"></label>`).join("")}<span class="soft">m</span><p class="note" role="status"></p>`;
    explorer.torques.section.append(group);
    const inputs = [...group.querySelectorAll("input")];
    this.word = group.querySelector("p.note");
    [mass, ...at].forEach((value, k) => { inputs[k].value = plain(value, 6); });
    inputs.forEach((input) => input.addEventListener("change", () => {
      const [kg, ...place] = inputs.map(numberIn);
      const right = kg >= 0 && !place.some(Number.isNaN);
      this.word.textContent = right ? "" : "four numbers, the mass not below 0";
      if (right) explorer.carry(kg, place);
    }));
  }
}

explorerPanels.add("payloadFields", (explorer) => (explorer.torques ? new PayloadFields(explorer) : null));
