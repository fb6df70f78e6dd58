// The stage: meshcat's viewer with light, floor and camera, the arms of all runs, their paths, targets and frames; z up.
// Still poses stand behind the runs in `arms`; they show their frames and no path.

class Stage {
  // `covered()` says how many pixels of the pane lie under other things, at its left, top and bottom; where the free part
  // can be chosen in several ways, each of them.
  constructor(pane, data, covered = () => [{}]) {
    Object.assign(this, { pane, data, covered });
    this.viewer = new MeshCat.Viewer(pane);
    const fit = this.viewer.set_3d_pane_size; // meshcat takes the window's height
    this.viewer.set_3d_pane_size = (width = pane.clientWidth, height = pane.clientHeight) => {
      if (width > 0 && height > 0) fit.call(this.viewer, width, height);
    };
    data.scene.forEach((command) => this.viewer.handle_command(command));
    this.arms = [...data.runs, ...(data.stills ?? [])].map((record, i) => this.#run(record, i));
    this.runs = this.arms.slice(0, data.runs.length);
    this.stills = this.arms.slice(data.runs.length);
    this.framed = this.runs;
    this.#surroundings();
    this.#camera();
    this.stills.forEach((still) => this.#settle(still));
    window.addEventListener("resize", () => this.frameView(!this.turned));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.repaint());
    this.repaint();
  }

  // Takes all colours from the look again, as they are in the present scheme.
  repaint() {
    this.scene().traverse((part) => {
      if (part.userData.token) part.material.color.set(ink(part.userData.token));
      part.userData.repaint?.();
    });
    this.grid.geometry.setAttribute("color", this.#gridColours());
    const parts = (token) => new THREE.Color(ink(token)).toArray();
    this.paint(parts("sky"), parts("ground"));
  }

  #gridColours() {
    const line = new THREE.Color(ink("floor")), count = this.grid.geometry.getAttribute("position").count;
    return new THREE.Float32BufferAttribute(Array.from({ length: count }, () => line.toArray()).flat(), 3);
  }

  node(path) {
    return this.viewer.scene_tree.find(path).object;
  }

  #run(record, i) {
    const n = record.joints.length, root = ["arms", `run_${i}`], chain = [root.concat("link_0")];
    for (let k = 1; k <= n + 1; k += 1) chain.push(chain[k - 1].concat(`link_${k}`));
    const times = unpack(record.trace.t), trace = rowsOf(record.trace.points), reference = rowsOf(record.reference);
    const parts = {
      record, root, chain, n, reference, trace, t: unpack(record.t), q: unpack(record.q), qRef: unpack(record.q_ref),
      tipError: unpack(record.tip_error), traceTube: tube(trace, times, 0.003, runToken(record)),
      flange: new THREE.Matrix4().fromArray(record.flange),
    };
    if (parts.traceTube) this.viewer.set_object(root.concat("trace"), parts.traceTube);
    const desired = tube(reference, null, 0.0018, "reference-path");
    if (desired) this.viewer.set_object(root.concat("reference"), desired);
    this.viewer.set_object(root.concat("target"), triad(TARGET_SIZE, 0.0035, null));
    parts.triads = [chain[0], ...record.native.map((_, k) => chain[k + 1])].map((path, k) => {
      const at = path.concat("frame");
      this.viewer.set_object(at, triad(FRAME_SIZE, 0.004, String(k)));
      this.viewer.set_transform(at, k > 0 ? record.native[k - 1] : record.base);
      return at;
    });
    parts.traceTube?.until(-1);
    return parts;
  }

  // Puts another run of the same arm in the place of run i.
  replace(i, record) {
    ["trace", "reference"].forEach((path) => this.viewer.delete_path(this.arms[i].root.concat(path)));
    this.arms[i] = this.#run(record, i);
    this.runs = this.arms.slice(0, this.runs.length);
    this.framed = this.runs;
    this.repaint();
  }

  // A still keeps its pose; it is hidden until it is chosen.
  #settle(still) {
    const tip = this.flangePose(this.arms.indexOf(still)).map((row) => row[3]);
    still.reach = Math.hypot(tip[0], tip[1], tip[2]);
    still.azimuth = Math.hypot(tip[0], tip[1]) > 0.3 * still.reach ? Math.atan2(tip[1], tip[0]) - 1 : this.azimuth; // from its side
    this.viewer.set_property(still.root.concat("target"), "visible", false);
    this.viewer.set_property(still.root, "visible", false);
  }

  // Shows only the still `index`, or with null the runs.
  showStill(index) {
    this.stills.forEach((still, i) => this.viewer.set_property(still.root, "visible", i === index));
    if (index !== null) this.runs.forEach((run) => this.viewer.set_property(run.root, "visible", false));
    this.framed = index === null ? this.runs : [this.stills[index]];
    this.viewer.set_3d_pane_size();
    this.frameView();
  }

  paint(top, bottom) {
    this.viewer.set_property(["Background"], "top_color", top);
    this.viewer.set_property(["Background"], "bottom_color", bottom);
    this.viewer.set_dirty();
  }

  #surroundings() {
    const viewer = this.viewer, floor = Math.min(...this.arms.map((arm) => arm.record.floor));
    viewer.delete_path(["Axes"]);
    this.grid = new THREE.GridHelper(6, 24);
    this.grid.rotateX(Math.PI / 2);
    this.grid.position.z = floor;
    viewer.set_object(["Grid"], this.grid);
    const shade = new THREE.Mesh(new THREE.PlaneGeometry(6, 6), new THREE.ShadowMaterial({ opacity: 0.2 }));
    shade.receiveShadow = true;
    shade.position.z = floor - 0.001;
    viewer.set_object(["Floor"], shade);
    const sun = new THREE.DirectionalLight(0xffffff, 0.45);
    sun.position.set(1.6, -1.2, 3.2);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    sun.shadow.bias = -0.0008;
    Object.assign(sun.shadow.camera, { left: -2, right: 2, top: 2, bottom: -2, near: 0.5, far: 8 });
    viewer.set_object(["Lights", "Sun"], sun);
    ["PointLightNegativeX", "PointLightPositiveX"].forEach((name) => viewer.set_property(["Lights", name, "<object>"], "intensity", 0.28));
    viewer.set_property(["Lights", "AmbientLight", "<object>"], "intensity", 0.55);
  }

  // The camera looks at the path from its front when it lies in an upright plane, a little from the side of the path.
  #camera() {
    const points = this.runs.flatMap((run) => run.reference), box = new THREE.Box3();
    points.forEach((p) => box.expandByPoint(new THREE.Vector3(p[0], p[1], p[2])));
    const size = box.getSize(new THREE.Vector3()), middle = box.getCenter(new THREE.Vector3());
    const facesY = size.y < 0.25 * size.x && size.y < 0.25 * size.z;
    this.azimuth = facesY ? -Math.PI / 2 - Math.sign(middle.x || 1) * -0.42 : Math.sign(middle.y || -1) * 0.42;
    this.elevation = 0.27;
    const camera = new THREE.PerspectiveCamera(32, 1, 0.02, 60);
    this.viewer.set_object(["Cameras", "default", "rotated"], camera);
    this.viewer.set_camera(camera);
    this.viewer.controls.addEventListener("change", () => { this.turned = true; }); // until it is framed again
    this.viewer.set_3d_pane_size();
  }

  setPose(run, q) {
    run.record.joints.forEach((joint, k) => this.viewer.set_transform(run.chain[k + 1], jointPose(joint, q[k]).elements));
  }

  setTarget(run, q) {
    const pose = new THREE.Matrix4();
    run.record.joints.forEach((joint, k) => pose.multiply(jointPose(joint, q[k])));
    this.viewer.set_transform(run.root.concat("target"), pose.multiply(run.flange).elements);
  }

  // The pose of the flange in its own base, read from the objects on the stage: four rows of four.
  flangePose(index) {
    const run = this.arms[index], flange = this.node(run.chain[run.n + 1]), base = this.node(run.root);
    flange.updateWorldMatrix(true, false);
    const m = base.matrixWorld.clone().invert().multiply(flange.matrixWorld).elements;
    return [0, 1, 2, 3].map((row) => [m[row], m[row + 4], m[row + 8], m[row + 12]]);
  }

  show(what, visible) {
    this.runs.forEach((run) => {
      const paths = what === "frame" ? run.triads : [run.root.concat(what)];
      paths.forEach((path) => this.viewer.set_property(path, "visible", visible));
    });
    this.viewer.set_dirty();
  }

  showRun(index, visible) {
    this.viewer.set_property(this.runs[index].root, "visible", visible);
    this.viewer.set_dirty();
  }

  // Side by side the arms stand apart along the picture's horizontal; overlaid all but the first are grey ghosts
  // whose bands keep the colour of their run.
  setBeside(beside) {
    this.beside = beside;
    const right = new THREE.Vector3(-Math.sin(this.azimuth), Math.cos(this.azimuth), 0);
    const offs = beside ? besideEachOther(this.runs.map((run) => runOutline(this, run)), right) : this.runs.map(() => 0);
    this.runs.forEach((run, i) => {
      this.viewer.set_transform(run.root, new THREE.Matrix4().makeTranslation(offs[i] * right.x, offs[i] * right.y, 0).elements);
      this.node(run.chain[0]).traverse((part) => {
        if (!part.isMesh || part.renderOrder > 0) return;
        part.material.transparent = !beside && i > 0;
        part.material.opacity = beside || i === 0 ? 1 : /^run/.test(part.userData.token) ? 0.8 : 0.25;
        part.castShadow = beside || i === 0;
      });
    });
    this.frameView();
  }

  // Points that must be visible, of all runs that are framed.
  outline() {
    return this.framed.flatMap((run) => runOutline(this, run).map((point) => point.add(this.node(run.root).position)));
  }

  scene() {
    return this.viewer.scene;
  }

  // Places the camera so that the outline fills the free part of the pane; or, where it stays, in the pane's shape only.
  // Of several free parts the one is taken in which the arm is largest.
  frameView(moves = true) {
    const viewer = this.viewer, camera = viewer.camera, points = this.outline();
    const width = this.pane.clientWidth, height = this.pane.clientHeight;
    if (width === 0 || height === 0 || points.length === 0) return;
    const azimuth = this.framed[0].azimuth ?? this.azimuth;
    const out = new THREE.Vector3(
      Math.cos(azimuth) * Math.cos(this.elevation), Math.sin(azimuth) * Math.cos(this.elevation), Math.sin(this.elevation));
    const right = new THREE.Vector3(-Math.sin(azimuth), Math.cos(azimuth), 0), up = out.clone().cross(right);
    const tall = (FILL * Math.tan((camera.fov / 2) * (Math.PI / 180))) / height;
    const choices = this.covered().map(({ left = 0, top = 0, bottom = 0 }) => {
      const slopes = [width - left, height - top - bottom].map((free) => tall * Math.max(free, 40));
      return { left, top, bottom, ...nearestEye(points, { out, right, up }, slopes) };
    });
    const { left, top, bottom, eye, target } = choices.reduce((best, each) => (each.depth < best.depth ? each : best));
    camera.setViewOffset(width, height, -left / 2, (bottom - top) / 2, width, height);
    viewer.set_dirty();
    if (!moves) return;
    camera.position.set(eye.x, eye.z, -eye.y); // meshcat's camera frame has y up
    viewer.controls.target.set(target.x, target.z, -target.y);
    viewer.controls.update();
    this.turned = false;
  }
}
