// The flange is dragged by its handle: arrows move it, rings turn it; the joints follow in the same frame.

class FlangeDrag {
  constructor(explorer) {
    Object.assign(this, { explorer, stage: explorer.stage, viewer: explorer.stage.viewer, n: explorer.data.arm.joints.length });
    this.word = document.getElementById("drag-word");
    this.solver = flangeSolver(explorer.data.arm, explorer.robot);
    this.handle = new THREE.Group();
    this.pose = new Float64Array(16);
    this.out = new Float64Array(this.n);
    explorer.addObject(explorer.run.root.concat("handle"), this.handle);
    this.#controls();
    this.#keys();
    explorerState.listen((state) => this.#follow(state.q));
  }

  #controls() {
    const controls = new lwrThree.TransformControls(this.viewer.camera, this.viewer.canvas);
    Object.assign(this, { controls, isDragging: false });
    controls.attach(this.handle);
    controls.setSpace("local");
    controls.setSize(0.7);
    this.viewer.overlay = controls.getHelper();
    controls.addEventListener("change", () => this.viewer.set_dirty());
    controls.addEventListener("dragging-changed", ({ value }) => (value ? this.begin() : this.end()));
    controls.addEventListener("objectChange", () => this.moved());
    const turn = document.getElementById("turn"), mode = () => controls.setMode(turn.checked ? "rotate" : "translate");
    turn.addEventListener("change", mode, { signal: this.explorer.signal });
    mode();
    this.stage.pane.addEventListener("pointerdown", (event) => this.#aim(event), { capture: true, signal: this.explorer.signal });
    this.explorer.signal.addEventListener("abort", () => this.#remove());
  }

  #remove() {
    this.controls.detach();
    this.controls.dispose();
    this.viewer.world.remove(this.controls.getHelper());
    this.viewer.controls.enabled = true;
  }

  // A finger does not hover: the arrow below it is chosen, and its plane turned to it, before the drag begins
  // (three.js issue 31280: the plane of the arrow before made the flange jump).
  #aim({ clientX, clientY, button }) {
    const { x, y } = this.viewer.picturePoint(clientX, clientY);
    this.controls.pointerHover({ x, y, button });
    this.controls.getHelper().updateMatrixWorld(true);
  }

  begin() {
    this.isDragging = true;
    this.from = new Float64Array(16);
    this.start = Float64Array.from(explorerState.q);
    this.explorer.robot.flange_pose(this.start, this.from);
    this.viewer.controls.enabled = false;
    this.psi = this.solver.armAngle(explorerState.q);
  }

  end() {
    this.isDragging = false;
    this.viewer.controls.enabled = true;
    this.#follow(explorerState.q);
  }

  // The joints for the handle as it stands; beyond a wall the arm goes as far as it is reached on the way from the start.
  moved() {
    this.handle.updateMatrix();
    this.pose.set(armKinematics.rows(this.handle.matrix.elements).flat());
    return this.go(this.pose, this.psi, this.from, this.start);
  }

  go(pose, psi, from, start) {
    const { OTHER_ANGLE, OUTSIDE, TOO_FAR, NEAREST } = this.solver, before = explorerState.q;
    const found = this.solver.solve(pose, psi, before, this.out, this.controls.mode === "rotate");
    const words = { [OTHER_ANGLE]: "at another arm angle: the limits", [OUTSIDE]: "a joint is at its limit", [TOO_FAR]: this.solver.isClosed ? "out of reach" : "out of reach, or a joint is at its limit", [NEAREST]: "as near as the arm gets" };
    const isThere = found < OUTSIDE || found === NEAREST;
    if (!isThere) this.solver.wall(from, pose, psi, start, this.out);
    const jumped = isThere && before.some((x, i) => this.explorer.data.arm.joints[i].kind === "revolute" && Math.abs(this.out[i] - x) > 1);
    this.word.textContent = words[found] ?? (jumped ? "went to another branch" : "");
    this.explorer.setPose(this.out);
    return found;
  }

  #follow(q) {
    if (this.isDragging) return;
    const m = armKinematics.flange(this.explorer.data.arm, q);
    new THREE.Matrix4().fromArray(m).decompose(this.handle.position, this.handle.quaternion, this.handle.scale);
    this.viewer.set_dirty();
  }

  // On the picture: a digit chooses a joint, left and right turn it; x, y, z move the flange by 5 mm, with Shift back.
  #keys() {
    const { pane } = this.stage;
    let joint = 0;
    pane.tabIndex = 0;
    pane.setAttribute("role", "application");
    pane.setAttribute("aria-label", "The arm: digits choose a joint, left and right turn it; x, y, z move the flange, with Shift back");
    pane.addEventListener("keydown", (event) => {
      const { key } = event, axis = ["x", "y", "z"].indexOf(key.toLowerCase()), turn = { ArrowLeft: -1, ArrowRight: 1 }[key];
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (key >= "1" && Number(key) <= this.n) joint = Number(key) - 1;
      else if (turn) {
        const q = Array.from(explorerState.q), { kind, slider: [low, up] } = this.explorer.data.arm.joints[joint];
        q[joint] = Math.min(Math.max(q[joint] + turn * (kind === "revolute" ? Math.PI / 180 : 0.005), low), up);
        this.explorer.setPose(q);
      } else if (axis >= 0) {
        this.psi = this.solver.armAngle(explorerState.q);
        this.explorer.robot.flange_pose(explorerState.q, this.pose);
        const from = Float64Array.from(this.pose);
        this.pose[4 * axis + 3] += event.shiftKey ? -0.005 : 0.005;
        this.go(this.pose, this.psi, from, explorerState.q);
      } else return;
      event.preventDefault();
    }, { signal: this.explorer.signal });
  }
}

explorerPanels.add("flangeDrag", (explorer) => (explorer.robot.flange_pose ? new FlangeDrag(explorer) : null));
