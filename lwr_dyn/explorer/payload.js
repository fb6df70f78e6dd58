// A payload: a mass at a point of the flange's frame, which every arm of the page carries.

class PayloadFields {
  constructor(explorer) {
    const card = document.createElement("section"), names = ["kg", "x m", "y m", "z m"], { mass, at } = explorer.payload;
    card.className = "card";
    card.setAttribute("aria-label", "Payload");
    card.innerHTML = `<div class="head"><h2>Payload <small>at a point of the flange's frame</small></h2></div><div class="scroll" tabindex="0" role="region" aria-label="Payload, fields"><table class="torques payload"><tbody><tr>${names.map((name) => `<td><label>${name} <input class="rate" type="text" inputmode="decimal" aria-label="payload, ${name}"></label></td>`).join("")}</tr></tbody></table></div><p class="note" role="status"></p>`;
    explorer.place(card);
    const inputs = [...card.querySelectorAll("input")];
    this.word = card.querySelector("p.note");
    [mass, ...at].forEach((value, k) => { inputs[k].value = plain(value, 6); });
    inputs.forEach((input) => input.addEventListener("change", () => {
      const [kg, ...place] = inputs.map((field) => Number(field.value.trim().replace(",", ".") || NaN));
      const right = [kg, ...place].every(Number.isFinite) && kg >= 0;
      this.word.textContent = right ? "" : "four numbers, the mass not below 0";
      if (right) explorer.carry(kg, place);
    }));
  }
}

explorerPanels.add("payloadFields", (explorer) => (explorer.robot.inverse_dynamics ? new PayloadFields(explorer) : null));
