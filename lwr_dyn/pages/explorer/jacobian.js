// The flange's Jacobian at the pose, and what follows from its linear part: the ellipsoids of velocity and of force.

const LOST_WORDS = ["", "one direction is lost", "two directions are lost", "the flange does not move"];

class JacobianPanel {
  constructor(explorer) {
    const { n } = explorer.robot;
    Object.assign(this, { explorer, n, J: new Float64Array(6 * n), linear: new Float64Array(3 * n), turned: new Float64Array(9), sizes: new Float64Array(3) });
    const reach = armKinematics.reach(explorer.data.arm);
    this.scale = { velocity: 0.25, force: 0.05 * reach * reach, longest: 0.4 * reach }; // m for 1 m/s, m for 1 N, m
    this.#build();
    this.drawn = ["velocity", "force"].map((name) => this.#ellipsoid(name));
    explorerState.listen((state) => this.write(state.q), this.card);
    explorerState.listen((state) => this.#draw(state.q)); // seen where the card is not
  }

  // J, and of its linear part the singular values `sizes` (in no order) with their directions, the columns of `turned`.
  compute(q) {
    this.explorer.robot.jacobian(q, this.J);
    this.linear.set(this.J.subarray(0, 3 * this.n));
    singularValues(this.linear, this.n, this.sizes, this.turned);
    return this;
  }

  write(q) {
    const { J, sizes, said } = this.compute(q);
    this.numbers(J);
    const falling = Array.from(sizes).sort((a, b) => b - a), [largest, , smallest] = falling;
    const lost = falling.filter((x) => x <= LOST * largest).length;
    said.velocity.textContent = falling.map((x) => x.toFixed(4)).join(", ");
    said.force.textContent = falling.map((x) => (x <= LOST * largest ? "∞" : (1 / x).toFixed(4))).reverse().join(", ");
    said.manipulability.textContent = lost ? "0" : manipulability(sizes).toPrecision(5);
    said.ratio.textContent = lost ? `singular: ${LOST_WORDS[lost]}` : (largest / smallest).toFixed(2);
  }

  #build() {
    const rows = ["x", "y", "z", "about x", "about y", "about z"];
    const facts = [["velocity", "velocity ellipsoid, semi-axes"], ["force", "force ellipsoid, semi-axes"], ["manipulability", "manipulability, product of the velocity's"], ["ratio", "condition, longest by shortest"]];
    const card = this.explorer.addCard("Jacobian", "of the flange in the base; m, 1", `<div class="scroll" tabindex="0" role="region" aria-label="Jacobian of the flange"><table class="heat"><tbody>${rows.map((row) => `<tr><th scope="row">${row}</th>${"<td></td>".repeat(this.n)}</tr>`).join("")}</tbody></table></div><table class="pose"><tbody>${facts.map(([name, text]) => `<tr><th scope="row">${text}</th><td data-fact="${name}"></td></tr>`).join("")}</tbody></table><p class="note">${this.#note()}</p>`);
    this.card = card;
    this.numbers = numberWriter([...card.querySelectorAll(".heat td")], 3);
    this.said = Object.fromEntries([...card.querySelectorAll("[data-fact]")].map((cell) => [cell.dataset.fact, cell]));
  }

  #note() {
    const { velocity, force, longest } = this.scale, slides = this.explorer.data.arm.joints.some(({ kind }) => kind !== "revolute");
    const units = slides ? " (m/s and N of sliding joints count as rad/s and N m)" : "";
    return `Of the linear part, for joint speeds of norm 1 rad/s [m/s] and joint torques of norm 1 N m [N]${units}. Drawn: 1 m/s as ${plain(velocity, 3)} m; 1 N as ${plain(force, 3)} m, at most ${plain(longest, 3)} m.`;
  }

  #ellipsoid(name) {
    const { stage, run } = this.explorer, path = run.chain[0].concat(`${name}-ellipsoid`);
    const box = this.explorer.addSwitch(`${name}-ellipsoid`, `${name} ellipsoid`);
    box.addEventListener("change", () => {
      if (box.checked && !box.dataset.drawn) {
        const material = new THREE.MeshPhongMaterial({ transparent: true, opacity: 0.35, depthWrite: false });
        const ball = painted(new THREE.Mesh(new THREE.SphereGeometry(1, 32, 20), material), name === "force" ? "run2" : "run1");
        this.explorer.addObject(path, ball);
        box.dataset.drawn = "yes";
      }
      if (box.dataset.drawn) stage.viewer.set_property(path, "visible", box.checked);
      this.#draw(explorerState.q);
    });
    return { name, box, path };
  }

  // At the flange, to scale; a force without bound is drawn as far as `longest`.
  #draw(q) {
    const shown = this.drawn?.filter(({ box }) => box.checked) ?? [];
    if (shown.length === 0) return;
    const pose = armKinematics.flange(this.explorer.data.arm, q), { turned, sizes, scale } = this.compute(q);
    const column = (k) => new THREE.Vector3(turned[k], turned[3 + k], turned[6 + k]);
    shown.forEach(({ name, path }) => {
      const lengths = Array.from(sizes, (x) => (name === "velocity" ? scale.velocity * x : Math.min(scale.force / x, scale.longest)));
      const axes = new THREE.Matrix4().makeBasis(column(0), column(1), column(2));
      if (axes.determinant() < 0) axes.makeBasis(column(0), column(1), column(2).negate());
      axes.scale(new THREE.Vector3(...lengths.map((x) => Math.max(x, 1e-4)))).setPosition(pose[12], pose[13], pose[14]);
      this.explorer.stage.viewer.set_transform(path, axes.elements);
    });
  }
}

explorerPanels.add("jacobian", (explorer) => (explorer.robot.jacobian ? new JacobianPanel(explorer) : null));
