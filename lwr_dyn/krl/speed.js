// The strip of a program's page, in the place of the tip error: the speed of the flange, and where each motion begins.
{
  const { speed, motions, events } = JSON.parse(document.getElementById("replay-data").textContent).program;
  const times = unpack(speed.t), values = unpack(speed.values), largest = Math.max(1e-9, values.reduce((a, b) => Math.max(a, b), 0));
  const duration = Math.max(lwrReplay.duration, 1e-9), high = 10 ** Math.floor(Math.log10(largest));
  const top = Math.ceil(largest / high) * high, box = element("div");
  const draw = (tag, attributes) => {
    const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
    Object.entries(attributes).forEach(([name, value]) => node.setAttribute(name, value));
    return node;
  };
  const x = (t) => ((1000 * t) / duration).toFixed(2), y = (v) => (100 * (1 - v / top)).toFixed(2);
  const picture = draw("svg", { viewBox: "0 0 1000 100", preserveAspectRatio: "none", role: "img", "aria-label": "speed of the flange over time" });
  const line = Array.from(times, (t, i) => `${i === 0 ? "M" : "L"}${x(t)} ${y(values[i])}`).join("");
  const begins = motions.map(([, , begin]) => `M${x(begin)} 0V100`).join("");
  const happened = events.map(([, , time]) => `M${x(time)} 0V14`).join("");
  const cursor = draw("path", { class: "cursor" });
  picture.append(draw("path", { class: "begins", d: begins }), draw("path", { class: "happened", d: happened }), draw("path", { class: "curve", d: line }), cursor);
  const pick = (event) => {
    if (event.buttons & 1) lwrReplay.setTime((duration * event.offsetX) / picture.clientWidth);
  };
  picture.addEventListener("pointerdown", (event) => { picture.setPointerCapture(event.pointerId); pick(event); });
  picture.addEventListener("pointermove", pick);
  box.id = "speed-strip";
  box.append(element("span", "", `speed of the flange, up to ${Number(top.toPrecision(3))} m/s; motions begin at the lines${events.length > 0 ? ", marks at the top: outputs and the like" : ""}`), picture);
  document.getElementById("strip").after(box);
  lwrReplay.watch((time) => cursor.setAttribute("d", `M${x(time)} 0V100`));
}
