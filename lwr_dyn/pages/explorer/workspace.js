// The card and the drawing of the workspace's section; it is computed when its switch is first on, in small pieces.

const workspaceSections = new WeakMap(); // of the page's arms, by their records

class WorkspaceSection {
  constructor(explorer) {
    Object.assign(this, { explorer, arm: explorer.arm, robot: explorer.robot, card: null, drawn: false });
    this.reach = new SectionReach(this.robot, this.arm);
    const [x, y, z] = this.arm.gravity, m = this.arm.joints[0].origin;
    this.up = m[8] * x + m[9] * y + m[10] * z > 1e-6 ? -1 : 1; // an axis that points down: the picture stands upright all the same
    this.path = explorer.run.chain[0].concat("section");
    this.box = explorer.addSwitch("section", "workspace section");
    this.box.addEventListener("change", () => this.#switch());
    explorerState.listen(({ q }) => this.#write(q));
  }

  #switch() {
    if (this.box.checked && !this.card) this.#build();
    if (!this.card) return;
    this.card.hidden = !this.box.checked;
    if (this.drawn) this.explorer.stage.viewer.set_property(this.path, "visible", this.box.checked);
    this.#write(explorerState.q);
  }

  #build() {
    this.card = this.explorer.addCard("Workspace section", "through the axis of the first joint; m", '<svg role="img" aria-label="Where the flange gets"><path class="area" fill-rule="evenodd"/><path class="axis"/><path class="dots"/><circle class="flange"/></svg><table class="pose"><tbody></tbody></table><p class="note" role="status">computing</p>', { kind: "section" });
    [this.note, this.svg] = ["note", "svg"].map((name) => this.card.querySelector(name === "svg" ? name : `.${name}`));
    const known = workspaceSections.get(this.arm);
    if (known) this.#take(known);
    else this.#compute(sectionBoundary(this.robot, this.arm));
  }

  // In pieces of 12 ms, so that the page answers meanwhile.
  #compute(work) {
    if (this.explorer.signal.aborted && this.explorer.arm !== this.arm) return;
    const until = performance.now() + 12;
    let piece = work.next();
    while (!piece.done && performance.now() < until) piece = work.next();
    if (!piece.done) setTimeout(() => this.explorer.arm === this.arm && this.#compute(work));
    else {
      workspaceSections.set(this.arm, piece.value);
      this.#take(piece.value);
    }
  }

  #take(found) {
    const { loops, samples, tolerance } = found, points = loops.length > 0 ? loops.flat() : samples, { up } = this;
    const ends = (of) => [Math.min(...of), Math.max(...of)], [low, high] = ends(points.map(({ z }) => up * z)), far = Math.max(...points.map(({ s }) => Math.abs(s)));
    const edge = 0.04 * Math.max(2 * far, high - low, 1e-3), path = (selector, d) => this.card.querySelector(selector).setAttribute("d", d);
    this.found = found;
    this.svg.setAttribute("viewBox", [-far - edge, -high - edge, 2 * (far + edge), high - low + 2 * edge].map((x) => x.toFixed(5)).join(" "));
    this.card.querySelector(".flange").setAttribute("r", 0.4 * edge);
    const at = ({ s, z }) => `${s.toFixed(5)} ${(-up * z).toFixed(5)}`;
    path(".area", loops.map((loop) => `M${loop.map(at).join("L")}z`).join(""));
    path(".axis", `M0 ${-high - edge}V${-low + edge}`);
    path(".dots", loops.length > 0 ? "" : samples.slice(0, 800).map((place) => `M${at(place)}h0M${at({ ...place, s: -place.s })}h0`).join(""));
    const rows = [["farthest from the axis", plain(far, 3)], ["heights from the first joint's frame", `${plain(low, 3)} to ${plain(high, 3)}`]];
    if (loops.length > 0) rows.push(["area, one side of the axis", `${plain(Math.abs(area(loops)) / 2, 3)} m²`]);
    this.card.querySelector("tbody").innerHTML = rows.map(([name, text]) => `<tr><th scope="row">${name}</th><td>${text}</td></tr>`).join("");
    const all = "Distances of the flange from the first joint's axis and heights along it, with all joints inside their ranges";
    this.note.textContent = loops.length > 0 ? `${all}, at whatever angle of the first joint. The curve is found to ${plain(1000 * tolerance, 1)} mm between places that are reached and places that are not; details below ${plain(1000 * found.h, 0)} mm can be missed.` : `${all}: here they fill no area.`;
    this.#draw(found);
    this.#switch();
  }

  #draw({ loops, faces, samples }) {
    const group = new THREE.Group(), positions = (points) => new THREE.Float32BufferAttribute(points.flatMap(({ s, z }) => [s, 0, z]), 3);
    const shape = (points) => { const geometry = new THREE.BufferGeometry(); geometry.setAttribute("position", positions(points)); return geometry; };
    loops.forEach((loop) => group.add(painted(new THREE.LineLoop(shape(loop), new THREE.LineBasicMaterial()), "focus")));
    if (loops.length === 0) group.add(painted(new THREE.Points(shape(samples), new THREE.PointsMaterial({ size: 2, sizeAttenuation: false })), "focus"));
    else group.add(painted(new THREE.Mesh(shape(faces.flat()), new THREE.MeshBasicMaterial({ side: THREE.DoubleSide, transparent: true, opacity: 0.14, depthWrite: false })), "focus"));
    group.traverse((part) => { part.userData.added = true; });
    this.explorer.addObject(this.path, group);
    this.drawn = true;
  }

  // In the plane in which the flange is now, and the flange in the picture.
  #write(q) {
    if (!this.found || !this.box.checked) return;
    const { x, y, rho, z } = this.reach.place(q), dot = this.card.querySelector(".flange");
    dot.setAttribute("cx", rho.toFixed(5));
    dot.setAttribute("cy", (-this.up * z).toFixed(5));
    const plane = new THREE.Matrix4().fromArray(this.arm.joints[0].origin).multiply(new THREE.Matrix4().makeRotationZ(Math.atan2(y, x)));
    this.explorer.stage.viewer.set_transform(this.path, plane.elements);
  }
}

// Of closed curves, with their holes.
function area(loops) {
  return loops.reduce((sum, loop) => sum + loop.reduce((part, { s, z }, m) => {
    const next = loop[(m + 1) % loop.length];
    return part + (s * next.z - next.s * z) / 2;
  }, 0), 0);
}

explorerPanels.add("section", (explorer) => (explorer.arm.joints[0].kind === "revolute" && explorer.robot.flange_pose ? new WorkspaceSection(explorer) : null));
