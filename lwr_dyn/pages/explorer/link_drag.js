// A link that is dragged turns its own joint: the point under the pointer goes round the joint's axis, or along it.

class LinkDrag {
  constructor(explorer) {
    Object.assign(this, { explorer, stage: explorer.stage, viewer: explorer.stage.viewer, held: null });
    this.ray = new THREE.Raycaster();
    const { pane } = this.stage, first = { capture: true, signal: explorer.signal }; // before the orbit controls, which listen on the canvas
    pane.addEventListener("pointerdown", (event) => this.#take(event), first);
    pane.addEventListener("pointermove", (event) => this.#move(event), first);
    ["pointerup", "pointercancel"].forEach((name) => pane.addEventListener(name, () => this.#drop(), first));
  }

  // The joint of the link under a point of the picture, and where it was hit; null beside the arm.
  hit(x, y) {
    this.viewer.camera.updateMatrixWorld();
    this.ray.setFromCamera(this.viewer.picturePoint(x, y), this.viewer.camera);
    const { chain } = this.explorer.run, shapes = [];
    this.stage.node(chain[0]).traverse((part) => { if (part.isMesh && !part.userData.added) shapes.push(part); });
    const [first] = this.ray.intersectObjects(shapes, false);
    if (!first) return null;
    const nodes = chain.slice(1, -1).map((path) => this.stage.node(path));
    let node = first.object;
    while (node && !nodes.includes(node)) node = node.parent;
    return node ? { joint: nodes.indexOf(node), node, point: first.point } : null;
  }

  #take(event) {
    const drag = this.explorer.flangeDrag;
    if (drag.controls.axis !== null || event.button !== 0 || !event.isPrimary) return;
    const found = this.hit(event.clientX, event.clientY);
    if (!found) return;
    const axis = new THREE.Vector3().setFromMatrixColumn(found.node.matrixWorld, 2).normalize();
    const origin = new THREE.Vector3().setFromMatrixPosition(found.node.matrixWorld);
    this.held = { ...found, axis, origin, x: event.clientX, y: event.clientY, start: explorerState.q[found.joint] };
    this.viewer.controls.enabled = false;
  }

  #move(event) {
    if (!this.held || !event.isPrimary) return;
    const { joint } = this.held, [low, up] = this.explorer.data.arm.joints[joint].slider, q = Array.from(explorerState.q);
    const asked = this.held.start + this.#turned(event);
    q[joint] = Math.min(Math.max(asked, low), up);
    this.explorer.flangeDrag.word.textContent = `${this.explorer.data.arm.joints[joint].name}${q[joint] === asked ? "" : ": at its limit"}`;
    this.explorer.setPose(q);
  }

  // By how much the joint moves for the pointer; a joint seen from its side follows the pointer across its axis.
  #turned({ clientX, clientY }) {
    const { axis, origin, point, joint } = this.held, { camera, canvas } = this.viewer;
    const { width, height } = canvas.getBoundingClientRect();
    const screen = (p) => { const s = p.clone().project(camera); return [((s.x + 1) * width) / 2, ((1 - s.y) * height) / 2]; };
    const along = this.explorer.data.arm.joints[joint].kind !== "revolute";
    const arm = point.clone().sub(origin), step = along ? axis.clone() : axis.clone().cross(arm);
    this.ray.setFromCamera(this.viewer.picturePoint(clientX, clientY), camera);
    if (!along && Math.abs(this.ray.ray.direction.dot(axis)) > 0.3) {
      const at = this.ray.ray.intersectPlane(new THREE.Plane().setFromNormalAndCoplanarPoint(axis, point), new THREE.Vector3());
      if (!at) return 0;
      const from = arm.projectOnPlane(axis), to = at.sub(origin).projectOnPlane(axis);
      return Math.atan2(axis.dot(from.clone().cross(to)), from.dot(to));
    }
    const a = screen(point), b = screen(point.clone().addScaledVector(step, 0.01)), d = [(b[0] - a[0]) / 0.01, (b[1] - a[1]) / 0.01];
    const size = d[0] * d[0] + d[1] * d[1];
    return size < 1 ? 0 : (d[0] * (clientX - this.held.x) + d[1] * (clientY - this.held.y)) / size;
  }

  #drop() {
    if (!this.held) return;
    this.held = null;
    this.viewer.controls.enabled = true;
    this.explorer.flangeDrag.word.textContent = "";
  }
}

explorerPanels.add("linkDrag", (explorer) => new LinkDrag(explorer));
