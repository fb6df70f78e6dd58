// Two lists of all runs, by plant; a choice puts its run in the place of the first or the second arm.
{
  const { shared, runs, chosen } = JSON.parse(document.getElementById("replay-data").textContent).pair;
  const whole = runs.map((own) => ({ ...shared, ...own }));
  whole.forEach((record) => { record.trace = { t: record.t, ...record.trace }; });
  const plants = new Map();
  whole.forEach(({ plant }, i) => plants.set(plant, [...(plants.get(plant) ?? []), i]));
  const box = element("div");
  box.id = "pair";
  chosen.forEach((start, place) => {
    const label = element("label"), list = element("select");
    list.id = `run-${place + 1}`;
    plants.forEach((members, plant) => {
      const group = element("optgroup");
      group.label = plant;
      members.forEach((i) => {
        const option = element("option", "", whole[i].controller);
        option.value = i;
        group.append(option);
      });
      list.append(group);
    });
    list.value = start;
    list.addEventListener("change", () => lwrReplay.replace(place, { ...whole[Number(list.value)], place }));
    label.style.setProperty("--accent", `var(--run${place + 1})`);
    label.append(element("span", "", place === 0 ? "left" : "right"), list);
    box.append(label);
  });
  document.getElementById("cards").before(box);
  lwrReplay.pair = whole;
}
