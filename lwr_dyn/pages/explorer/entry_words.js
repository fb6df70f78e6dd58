// What is written of an entry of B, C or g: its name, unit and general form with the source.

const entryWords = (() => {
  const sub = (letter, index) => `${letter}<sub>${index}</sub>`;
  const pair = (letter, i, j) => sub(letter, i > 9 || j > 9 ? `${i},${j}` : `${i}${j}`);
  const book = (equations) => `<small>Siciliano et al., Robotics, ${equations}</small>`;

  const name = (kind, i, j) => (kind === "g" ? sub("g", i + 1) : pair(kind, i + 1, j + 1));

  // Of joints that turn: kg m^2, N m s, N m; a metre less for each that slides.
  const unit = (kind, turns, i, j) => {
    const metres = Number(turns[i]) + (kind === "g" ? 0 : Number(turns[j]));
    return { B: ["kg", "kg m", "kg m²"], C: ["N s/m", "N s", "N m s"], g: ["N", "N m"] }[kind][metres];
  };

  const mass = (i, j, rotor) => {
    const whole = `${pair("B", i, j)} = Σ m J<sub>v${i}</sub>·J<sub>v${j}</sub> + J<sub>ω${i}</sub>·I J<sub>ω${j}</sub>`;
    return `${whole}${rotor ? " + k<sub>r</sub>² I<sub>m</sub>" : ""}, over the links from ${Math.max(i, j)} on ${book("eq. 7.32; rotors on the diagonal")}`;
  };

  const speed = (i, j) => `${pair("C", i, j)} = ½ Σ<sub>l</sub> (∂${pair("B", i, j)}/∂q<sub>l</sub> + ∂B<sub>${i}l</sub>/∂q<sub>${j}</sub> − ∂B<sub>${j}l</sub>/∂q<sub>${i}</sub>) dq<sub>l</sub> ${book("eqs. 7.44, 7.45")}<br>Link by link, from ${Math.max(i, j)} on: m J<sub>v${i}</sub>·J̇<sub>v${j}</sub> + J<sub>ω${i}</sub>·(I a + (J<sub>ω${j}</sub> × I ω + ω × I J<sub>ω${j}</sub>) / 2), a = (J̇<sub>ω${j}</sub> + J<sub>ω${j}</sub> × (ω − ω<sub>${j}</sub>)) / 2`;

  const weight = (i) => `${sub("g", i)} = ∂U/∂q<sub>${i}</sub> = −Σ m g<sub>0</sub>·J<sub>v${i}</sub>, over the links from ${i} on ${book("eqs. 7.36, 7.39")}`;

  const form = (kind, i, j, rotor) => ({ B: () => mass(i + 1, j + 1, rotor), C: () => speed(i + 1, j + 1), g: () => weight(i + 1) })[kind]();

  // Heads of the two columns of shares.
  const parts = { B: ["m J<sub>v</sub>·J<sub>v</sub>", "J<sub>ω</sub>·I J<sub>ω</sub>"], C: ["m J<sub>v</sub>·J̇<sub>v</sub>", "J<sub>ω</sub>·(…)"], g: ["−m g<sub>0</sub>·J<sub>v</sub>", ""] };

  return { name, unit, form, parts };
})();
