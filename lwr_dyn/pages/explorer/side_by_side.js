// Two arms side by side: what moves both, and a small table that compares them at their poses. A click on the other arm
// makes it the active one. Poses are each in the arm's own base.

class SideBySide {
  constructor(explorer) {
    this.explorer = explorer;
    explorer.coupling ??= "none";
    this.sides = explorer.shown.map((entry) => {
      const { robot, data: { arm, motors } } = entry, n = arm.joints.length;
      return { entry, arm, robot, motors, n, g: new Float64Array(n), J: new Float64Array(6 * n), sizes: new Float64Array(3), turned: new Float64Array(9), next: new Float64Array(n), solver: robot?.jacobian ? flangeSolver(arm, robot) : null, mass: massOf(entry.data.bodies), reach: (entry.reach ??= reachOf(arm)) };
    });
    this.active = this.sides.find(({ entry }) => entry === explorer.arms[explorer.active]);
    this.#build();
    this.#clicks();
    explorerState.listen((state) => this.write(state.q));
  }

  // What couples the arms: "none", "joints" or "pose", as far as these arms can.
  couple(how) {
    const ways = this.buttons.map(({ dataset }) => dataset.how), chosen = ways.includes(how) ? how : "none";
    this.explorer.coupling = chosen;
    this.buttons.forEach((button) => button.setAttribute("aria-pressed", String(button.dataset.how === chosen)));
    this.write(explorerState.q);
  }

  write(q) {
    this.sides.forEach((side) => { if (side !== this.active) this.#move(side, q); });
    this.sides.forEach((side, k) => {
      const values = this.compare(side);
      Object.entries(this.cells).forEach(([name, cells]) => { put(cells[k], values[name]); });
    });
  }

  // The words of one arm's column.
  compare({ entry: { q }, arm, robot, motors, n, g, J, sizes, turned, mass, reach }) {
    const pose = armKinematics.flange(arm, q), known = (x, digits, unit) => (x === null ? "unknown" : `${fixed(x, digits)} ${unit}`);
    const values = { mass: known(mass, 3, "kg"), reach: known(reach, 3, "m"), flange: [12, 13, 14].map((k) => fixed(pose[k], 3)).join(", "), torque: "unknown", share: "unknown", manipulability: "unknown" };
    if (robot?.gravity_vector) {
      robot.gravity_vector(q, g);
      const shares = Array.from(g, (x, i) => (motors[i] === null ? null : Math.abs(x) / motors[i])), largest = indexOfLargest(g.map(Math.abs));
      values.torque = `${fixed(Math.abs(g[largest]), 2)} ${arm.joints[largest].kind === "revolute" ? "N m" : "N"} (${largest + 1})`;
      if (shares.every((x) => x !== null)) values.share = `${fixed(100 * Math.max(...shares), 1)} % (${indexOfLargest(shares) + 1})`;
    }
    if (robot?.jacobian) {
      singularValues(robot.jacobian(q, J).slice(0, 3 * n), n, sizes, turned);
      values.manipulability = manipulability(sizes).toPrecision(4);
    }
    return values;
  }

  // The other arm follows; where it cannot it stays.
  #move(side, q) {
    const { arm, n, next, entry, solver } = side, { explorer, active } = this, how = explorer.coupling;
    this.word.textContent = "";
    if (how === "none") return;
    if (how === "joints") {
      arm.joints.forEach(({ slider: [low, up] }, i) => { next[i] = Math.min(Math.max(q[i], low), up); });
      if (next.some((x, i) => Math.abs(x - q[i]) > 1e-9)) this.word.textContent = `${entry.label}: a joint is at its limit`;
    } else {
      const pose = armKinematics.rows(armKinematics.flange(active.arm, q)).flat();
      if (solver.solve(pose, solver.armAngle(entry.q), entry.q, next) >= solver.OUTSIDE) {
        this.word.textContent = `${entry.label} does not get there`;
        return;
      }
    }
    entry.q = Float64Array.from(next.subarray(0, n));
    explorer.stage.setPose(entry.run, entry.q);
    explorer.stage.viewer.set_dirty();
  }

  #build() {
    const { sides, active } = this, same = sides.every(({ n }) => n === sides[0].n), both = sides.every(({ solver }) => solver);
    const ways = [["none", "each by itself", true], ["joints", "same joint positions", same], ["pose", "same flange pose", both]];
    const rows = [["mass", "mass of the moving links"], ["reach", "reach from the first axis"], ["flange", "flange x, y, z <small>m, own base</small>"], ["torque", "largest holding torque <small>(joint)</small>"], ["share", "largest share of a motor's limit <small>(joint)</small>"], ["manipulability", "manipulability <small>of the linear part</small>"]];
    const beside = `<div class="buttons" role="group" aria-label="What moves both">${ways.filter(([, , can]) => can).map(([how, text]) => `<button type="button" data-how="${how}">${text}</button>`).join("")}</div>`;
    const card = this.explorer.addCard("Side by side", null, `<div class="scroll" tabindex="0" role="region" aria-label="Both arms compared"><table class="sides"><thead><tr><td></td>${sides.map(() => '<th scope="col" class="num"></th>').join("")}</tr></thead><tbody>${rows.map(([name, text]) => `<tr data-row="${name}"><th scope="row">${text}</th>${'<td class="num"></td>'.repeat(sides.length)}</tr>`).join("")}</tbody></table></div><p class="note" role="status"></p>`, { beside });
    this.word = card.querySelector("p.note");
    this.cells = Object.fromEntries([...card.querySelectorAll("[data-row]")].map((row) => [row.dataset.row, [...row.querySelectorAll("td")]]));
    card.querySelectorAll("thead th").forEach((head, k) => { head.textContent = sides[k] === active ? `${sides[k].entry.label} (active)` : sides[k].entry.label; });
    this.buttons = [...card.querySelectorAll("button")];
    this.buttons.forEach((button) => button.addEventListener("click", () => this.couple(button.dataset.how)));
    this.couple(this.explorer.coupling);
  }

  // A click, not a drag, on the other arm.
  #clicks() {
    const { stage, signal } = this.explorer, { viewer, pane } = stage, ray = new THREE.Raycaster();
    let from = null;
    pane.addEventListener("pointerdown", ({ clientX, clientY }) => { from = [clientX, clientY]; }, { signal, capture: true });
    pane.addEventListener("pointerup", ({ clientX: x, clientY: y }) => {
      if (!from || Math.hypot(x - from[0], y - from[1]) > 4) return;
      viewer.camera.updateMatrixWorld();
      ray.setFromCamera(viewer.picturePoint(x, y), viewer.camera);
      const hits = this.sides.map(({ entry: { run } }) => ray.intersectObject(stage.node(run.chain[0]), true).filter(({ object }) => !object.userData.added)[0]?.distance ?? Infinity);
      const near = indexOfLargest(hits.map((distance) => -distance)), { entry } = this.sides[near];
      if (Number.isFinite(hits[near]) && entry !== this.active.entry) this.explorer.choose(this.explorer.arms.indexOf(entry));
    }, { signal, capture: true });
  }
}

function indexOfLargest(values) {
  return values.reduce((best, x, i) => (x > values[best] ? i : best), 0);
}

// kg; null where a link's mass is unknown.
function massOf(bodies) {
  return bodies.every(({ mass }) => mass !== null) ? bodies.reduce((sum, { mass }) => sum + mass, 0) : null;
}

// The largest distance [m] of the flange from the first joint's axis inside the sliders' ranges; null where that joint slides.
// Joint by joint to the best of its range, with finer and finer steps, from several starts.
function reachOf(arm) {
  const { joints } = arm, into = new THREE.Matrix4().fromArray(joints[0].origin).invert(), at = new THREE.Vector3();
  if (joints[0].kind !== "revolute") return null;
  const out = (q) => {
    const pose = armKinematics.flange(arm, q);
    at.set(pose[12], pose[13], pose[14]).applyMatrix4(into);
    return Math.hypot(at.x, at.y);
  };
  const climbed = (q) => {
    let best = out(q);
    for (let round = 0, share = 1; round < 14; round += 1, share *= round < 4 ? 1 : 0.45) {
      joints.forEach(({ slider: [low, up] }, i) => {
        const middle = q[i];
        for (let k = -8; k <= 8; k += 1) {
          const x = Math.min(Math.max(middle + ((up - low) * share * k) / 8, low), up), before = q[i];
          q[i] = x;
          const found = out(q);
          if (found > best) best = found;
          else q[i] = before;
        }
      });
    }
    return best;
  };
  return Math.max(...[0.5, 0.2, 0.8, 0.35, 0.65].map((share) => climbed(joints.map(({ slider: [low, up] }) => low + share * (up - low)))));
}

explorerPanels.add("sides", (explorer) => new SideBySide(explorer), { always: true });
