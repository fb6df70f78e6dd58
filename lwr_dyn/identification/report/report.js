// The report of an identification: the recordings replayed in 3D with the links' ellipsoids, torque charts in step.

class IdentificationReport {
  constructor(data) {
    this.data = data;
    this.records = [...data.runs, ...data.others];
    this.stage = new Stage(document.getElementById("stage"), { scene: data.scene, runs: data.runs });
    this.chosen = 0;
    this.time = 0;
    this.playing = false;
    this.paths = { before: [], after: [] };
    data.native.forEach((pose, i) => {
      this.#ellipsoid("before", i, pose, data.before[i]);
      this.#ellipsoid("after", i, pose, data.after[i]);
    });
    ["target", "frame"].forEach((part) => this.stage.show(part, false));
    this.#controls();
    this.#charts();
    this.stage.repaint();
    this.choose(0);
    this.stage.frameView();
  }

  get run() {
    return this.stage.runs[0];
  }

  get duration() {
    return this.run.t[this.run.t.length - 1];
  }

  setTime(t) {
    this.time = Math.min(Math.max(Number(t) || 0, 0), this.duration);
    this.stage.setPose(this.run, sampleAt(this.run, this.time).q);
    this.run.traceTube?.until(this.time);
    document.getElementById("scrub").value = this.time;
    document.getElementById("clock").textContent = `${this.time.toFixed(2)} / ${this.duration.toFixed(2)} s`;
    this.charts.forEach(({ chart, low, high }) => chart.style.setProperty("--at", (this.time - low) / (high - low)));
    this.stage.viewer.set_dirty();
  }

  // Another recording in 3D and in the charts.
  choose(k) {
    if (k !== this.chosen) this.stage.replace(0, this.records[k]);
    this.chosen = k;
    document.querySelectorAll("[data-recording]").forEach((part) => { part.hidden = Number(part.dataset.recording) !== k; });
    document.querySelectorAll("select.which, #recording").forEach((list) => { list.value = k; });
    document.getElementById("scrub").max = this.duration;
    this.stage.showRun(0, true);
    ["target", "frame"].forEach((part) => this.stage.show(part, false));
    this.#path(document.getElementById("show-path").checked);
    this.setTime(0);
  }

  play(on) {
    if (on && this.time >= this.duration) this.setTime(0);
    this.playing = on;
    document.getElementById("play").textContent = on ? "\u275A\u275A" : "\u25B6";
    if (!on) return;
    let before = performance.now();
    const step = (now) => {
      if (!this.playing) return;
      const ahead = this.time + ((now - before) / 1000) * Number(document.getElementById("speed").value);
      before = now;
      this.setTime(ahead);
      if (ahead >= this.duration) this.play(false);
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  // For scripts and tests.
  hook() {
    return {
      ready: true,
      duration: () => this.duration,
      setTime: (t) => this.setTime(t),
      time: () => this.time,
      choose: (k) => this.choose(k),
      flangePose: () => this.stage.flangePose(0),
      ellipsoids: (what) => this.paths[what].map((path) => this.#drawn(path)),
      stage: this.stage,
    };
  }

  // Where an ellipsoid stands now, in the arm's first frame: 16 numbers, and whether it is shown.
  #drawn(path) {
    const node = this.stage.node(path), base = this.stage.node(this.run.root);
    node.updateWorldMatrix(true, false);
    return { matrix: base.matrixWorld.clone().invert().multiply(node.matrixWorld).toArray(), visible: node.visible };
  }

  // The unit sphere in a link, as its matrix makes it: three circles, and inside the result's a body.
  #ellipsoid(what, i, native, matrix) {
    if (matrix === null) return;
    const group = new THREE.Group(), token = what === "after" ? "run1" : "reference-path";
    const circle = Array.from({ length: 73 }, (_, k) => new THREE.Vector3(Math.cos((k * Math.PI) / 36), Math.sin((k * Math.PI) / 36), 0));
    [[0, 0], [Math.PI / 2, 0], [0, Math.PI / 2]].forEach(([x, y]) => {
      const line = painted(new THREE.Line(new THREE.BufferGeometry().setFromPoints(circle), new THREE.LineBasicMaterial()), token);
      line.rotation.set(x, y, 0);
      group.add(line);
    });
    if (what === "after") {
      const body = new THREE.MeshLambertMaterial({ transparent: true, opacity: 0.4, depthWrite: false });
      group.add(painted(new THREE.Mesh(new THREE.SphereGeometry(1, 36, 24), body), token));
    }
    group.traverse((part) => { part.userData.added = true; part.castShadow = false; part.renderOrder = 5; });
    const path = this.run.chain[i + 1].concat(`${what}_ellipsoid`), pose = new THREE.Matrix4().fromArray(native);
    this.stage.viewer.set_object(path, group);
    this.stage.viewer.set_transform(path, pose.multiply(new THREE.Matrix4().fromArray(thick(matrix))).elements);
    this.paths[what].push(path);
  }

  #show(what, on) {
    this.paths[what].forEach((path) => this.stage.viewer.set_property(path, "visible", on));
    this.stage.viewer.set_dirty();
  }

  #path(on) {
    ["reference", "trace"].forEach((part) => this.stage.show(part, on));
  }

  // The arm's own shapes, so that what lies inside them is seen.
  #seeThrough(on) {
    this.stage.node(this.run.chain[0]).traverse((part) => {
      if (!part.isMesh || part.userData.added || part.renderOrder > 0) return;
      Object.assign(part.material, { transparent: on, opacity: on ? 0.22 : 1, depthWrite: !on });
      part.castShadow = !on;
    });
    this.stage.viewer.set_dirty();
  }

  #controls() {
    const scrub = document.getElementById("scrub");
    scrub.addEventListener("input", () => this.setTime(scrub.value));
    document.getElementById("play").addEventListener("click", () => this.play(!this.playing));
    document.querySelectorAll("select.which, #recording").forEach((list) => {
      list.addEventListener("change", () => this.choose(Number(list.value)));
    });
    const bind = (id, act) => {
      const box = document.getElementById(id);
      box.addEventListener("change", () => act(box.checked));
      act(box.checked);
    };
    bind("show-before", (on) => this.#show("before", on));
    bind("show-after", (on) => this.#show("after", on));
    bind("see-through", (on) => this.#seeThrough(on));
    bind("show-path", (on) => this.#path(on));
  }

  // A line at the replay's time in every torque chart; a click there sets the time.
  #charts() {
    this.charts = [...document.querySelectorAll(".torques")].map((chart) => ({ chart, low: Number(chart.dataset.low), high: Number(chart.dataset.high) }));
    this.charts.forEach(({ chart, low, high }) => chart.querySelectorAll(".plane").forEach((plane) => {
      plane.addEventListener("click", (event) => {
        const box = plane.getBoundingClientRect();
        this.setTime(low + ((event.clientX - box.left) / box.width) * (high - low));
      });
    }));
  }
}

// A flat ellipsoid gets a thickness of a millimetre: a surface without volume has no light.
function thick(matrix) {
  const out = new THREE.Matrix4().fromArray(matrix), axes = [0, 1, 2].map(() => new THREE.Vector3());
  out.extractBasis(...axes);
  axes.forEach((axis, k) => {
    if (axis.length() >= 1e-3) return;
    axis.crossVectors(axes[(k + 1) % 3], axes[(k + 2) % 3]);
    if (axis.length() > 0) axis.setLength(1e-3);
  });
  return out.makeBasis(...axes).setPosition(matrix[12], matrix[13], matrix[14]).elements;
}

// Without WebGL there is no 3D; everything else stands, with the charts of all recordings.
try {
  window.lwrReport = new IdentificationReport(JSON.parse(document.getElementById("stage-data").textContent)).hook();
} catch (fault) {
  const stage = document.getElementById("stage");
  stage.classList.add("flat");
  stage.replaceChildren(element("p", "note", `No 3D in this browser: ${fault.message}`));
  document.querySelectorAll("[data-recording]").forEach((part) => { part.hidden = false; });
}
