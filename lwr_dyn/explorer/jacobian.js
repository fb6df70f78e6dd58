// The flange's Jacobian at the pose, and what follows from its linear part: the ellipsoids of velocity and of force.

class JacobianPanel {
  constructor(explorer) {
    const { n } = explorer.robot;
    Object.assign(this, { explorer, n, J: new Float64Array(6 * n), product: new Float64Array(9), turned: new Float64Array(9), sizes: new Float64Array(3) });
    this.#build();
    this.drawn = ["velocity", "force"].map((name) => this.#ellipsoid(name));
    explorerState.listen((state) => this.write(state.q));
  }

  // J, and of its linear part's singular values `sizes` (falling) and directions, the columns of `turned`.
  compute(q) {
    const { n, J, product } = this;
    robot.jacobian(q, J);
    for (let a = 0; a < 3; a += 1) {
      for (let b = 0; b < 3; b += 1) {
        let sum = 0;
        for (let i = 0; i < n; i += 1) sum += J[a * n + i] * J[b * n + i];
        product[3 * a + b] = sum;
      }
    }
    principalAxes(product, this.turned);
    for (let k = 0; k < 3; k += 1) this.sizes[k] = Math.sqrt(Math.max(product[4 * k], 0));
    return this;
  }

  write(q) {
    const { J, sizes, cells, said } = this.compute(q);
    cells.forEach((cell, k) => { cell.textContent = fixed(J[k], 3); });
    const falling = Array.from(sizes).sort((a, b) => b - a), [largest, , smallest] = falling;
    const lost = smallest <= 1e-9 * largest;
    said.velocity.textContent = falling.map((x) => x.toFixed(4)).join(", ");
    said.force.textContent = falling.map((x) => (x <= 1e-9 * largest ? "∞" : (1 / x).toFixed(4))).reverse().join(", ");
    said.manipulability.textContent = falling.reduce((volume, x) => volume * x, 1).toExponential(4);
    said.ratio.textContent = lost ? "singular: one direction is lost" : (largest / smallest).toFixed(2);
    this.#draw(q);
  }

  #build() {
    const card = document.createElement("section"), rows = ["x", "y", "z", "about x", "about y", "about z"];
    const facts = [["velocity", "velocity ellipsoid, semi-axes"], ["force", "force ellipsoid, semi-axes"], ["manipulability", "manipulability, product of the velocity's"], ["ratio", "condition, longest by shortest"]];
    card.className = "card";
    card.setAttribute("aria-label", "Jacobian");
    card.innerHTML = `<div class="head"><h2>Jacobian <small>of the flange in the base; m, 1</small></h2></div><div class="scroll" tabindex="0" role="region" aria-label="Jacobian of the flange"><table class="heat"><tbody>${rows.map((row) => `<tr><th scope="row">${row}</th>${"<td></td>".repeat(this.n)}</tr>`).join("")}</tbody></table></div><table class="pose"><tbody>${facts.map(([name, text]) => `<tr><th scope="row">${text}</th><td data-fact="${name}"></td></tr>`).join("")}</tbody></table><p class="note">Of the linear part, for joint speeds and torques of norm 1.</p>`;
    this.explorer.place(card);
    this.cells = [...card.querySelectorAll(".heat td")];
    this.said = Object.fromEntries([...card.querySelectorAll("[data-fact]")].map((cell) => [cell.dataset.fact, cell]));
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

  // At the flange; the longest semi-axis is 0.3 m long, so the shape counts, the numbers are in the table.
  #draw(q) {
    const shown = this.drawn?.filter(({ box }) => box.checked) ?? [];
    if (shown.length === 0) return;
    const pose = armKinematics.flange(this.explorer.data.arm, q), { turned, sizes } = this, largest = Math.max(...sizes, 1e-12);
    shown.forEach(({ name, path }) => {
      const lengths = Array.from(sizes, (x) => (name === "velocity" ? x : 1 / Math.max(x, largest / 1000))), most = Math.max(...lengths, 1e-12);
      const across = new THREE.Vector3(), column = (k) => across.set(turned[k], turned[3 + k], turned[6 + k]).clone();
      const axes = new THREE.Matrix4().makeBasis(column(0), column(1), column(2));
      if (axes.determinant() < 0) axes.makeBasis(column(0), column(1), column(2).negate());
      axes.scale(new THREE.Vector3(...lengths.map((x) => Math.max((0.3 * x) / most, 1e-4)))).setPosition(pose[12], pose[13], pose[14]);
      this.explorer.stage.viewer.set_transform(path, axes.elements);
    });
  }
}

// Jacobi's rotations: a symmetric 3 x 3 matrix becomes diagonal, the columns of `turned` its principal axes.
function principalAxes(matrix, turned) {
  turned.set([1, 0, 0, 0, 1, 0, 0, 0, 1]);
  for (let round = 0; round < 8; round += 1) {
    for (const [p, r] of [[0, 1], [0, 2], [1, 2]]) {
      const off = matrix[3 * p + r];
      if (Math.abs(off) < 1e-300) continue;
      const theta = (matrix[4 * r] - matrix[4 * p]) / (2 * off);
      const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.hypot(theta, 1)), c = 1 / Math.hypot(t, 1), s = t * c;
      for (let k = 0; k < 3; k += 1) {
        const a = matrix[3 * k + p], b = matrix[3 * k + r];
        [matrix[3 * k + p], matrix[3 * k + r]] = [c * a - s * b, s * a + c * b];
      }
      for (let k = 0; k < 3; k += 1) {
        const a = matrix[3 * p + k], b = matrix[3 * r + k], u = turned[3 * k + p], v = turned[3 * k + r];
        [matrix[3 * p + k], matrix[3 * r + k]] = [c * a - s * b, s * a + c * b];
        [turned[3 * k + p], turned[3 * k + r]] = [c * u - s * v, s * u + c * v];
      }
    }
  }
}

explorerPanels.add("jacobian", (explorer) => (explorer.robot.jacobian ? new JacobianPanel(explorer) : null));
