// What the explorer adds to the arm on the stage: frames, centres of mass, ellipsoids, limits, gravity.
// Everything hangs below the nodes of the links, so it moves when they move.

class ArmParts {
  constructor({ stage, data, run }) {
    Object.assign(this, { stage, data, run });
    const { arm } = data;
    this.reach = armKinematics.reach(arm);
    this.size = Math.min(Math.max(0.075 * this.reach, 0.02), 0.22);
    this.lines = new THREE.BufferGeometry().setFromPoints(Array.from({ length: 72 }, (_, k) => new THREE.Vector3(Math.cos((k * Math.PI) / 36), Math.sin((k * Math.PI) / 36), 0)));
    this.paths = { frames: [], native: [], flange: [], centres: [], ellipsoids: [], limits: [], gravity: [] };
    this.#frames();
    data.bodies.forEach((body, i) => this.#body(body, this.run.chain[i + 1]));
    arm.joints.forEach((joint, i) => this.#limits(joint, i));
    this.#gravity();
    stage.repaint();
  }

  // Another arm is chosen: what was added goes, and the arm is solid.
  remove() {
    this.seeThrough(false);
    Object.values(this.paths).flat().forEach((path) => this.stage.viewer.delete_path(path));
  }

  show(what, on) {
    this.paths[what].forEach((path) => this.stage.viewer.set_property(path, "visible", on));
    this.stage.viewer.set_dirty();
  }

  // The arm's own shapes: as solids, or so that what lies inside them is seen.
  seeThrough(on) {
    this.stage.node(this.run.chain[0]).traverse((part) => {
      if (!part.isMesh || part.userData.added || part.renderOrder > 0) return;
      part.material.transparent = on;
      part.material.opacity = on ? 0.25 : 1;
      part.material.depthWrite = !on;
      part.castShadow = !on;
    });
    this.stage.viewer.set_dirty();
  }

  // Points that a picture of the arm as it stands has to hold: corners of its shapes, the flange's frame, the arrow.
  outline(run = this.run) {
    const inverse = new THREE.Matrix4(), points = run === this.run ? [...(this.arrow ?? [])] : [];
    this.stage.scene().updateMatrixWorld(true);
    inverse.copy(this.stage.node(run.root).matrixWorld).invert();
    this.stage.node(run.chain[0]).traverse((part) => {
      if (!part.isMesh || part.userData.added || part.renderOrder > 0) return;
      part.geometry.computeBoundingBox();
      const { min, max } = part.geometry.boundingBox, pose = inverse.clone().multiply(part.matrixWorld);
      [min.x, max.x].forEach((x) => [min.y, max.y].forEach((y) => [min.z, max.z].forEach((z) => {
        points.push(new THREE.Vector3(x, y, z).applyMatrix4(pose));
      })));
    });
    const flange = inverse.multiply(this.stage.node(run.chain[run.n + 1]).matrixWorld);
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((axis) => {
      points.push(new THREE.Vector3(...axis).multiplyScalar(1.4 * this.size).applyMatrix4(flange));
    });
    return points;
  }

  #add(what, path, object, pose) {
    object.traverse((part) => { part.userData.added = true; part.castShadow = false; });
    this.stage.viewer.set_object(path, object);
    if (pose) this.stage.viewer.set_transform(path, pose);
    this.paths[what].push(path);
  }

  // A mesh in a colour of the look; `lit` ones have light and shade.
  #mesh(geometry, token, { lit = false, ...options } = {}) {
    const material = lit ? new THREE.MeshLambertMaterial(options) : new THREE.MeshBasicMaterial(options);
    return painted(new THREE.Mesh(geometry, material), token);
  }

  #frames() {
    const { chain, record, n } = this.run, { native } = this.data.arm, thin = 0.03 * this.size;
    this.#add("frames", chain[0].concat("frame_base"), triad(this.size, thin, "0"), record.base);
    for (let k = 1; k <= n; k += 1) this.#add("frames", chain[k].concat("frame_joint"), triad(this.size, thin, String(k)));
    this.#add("flange", chain[n + 1].concat("frame_flange"), triad(1.3 * this.size, 1.3 * thin, null));
    (native ?? []).forEach((pose, k) => this.#add("native", chain[k + 1].concat("frame_native"), triad(this.size, thin, String(k + 1)), pose));
  }

  #body(body, path) {
    if (body.com) {
      const ball = this.#mesh(new THREE.SphereGeometry(0.085 * this.size, 20, 14), "ink", { depthTest: false, transparent: true });
      const ring = this.#mesh(new THREE.SphereGeometry(0.125 * this.size, 20, 14), "card", { depthTest: false, transparent: true });
      ring.renderOrder = 11;
      ball.renderOrder = 12;
      const both = new THREE.Group();
      both.add(ring, ball);
      this.#add("centres", path.concat("centre"), both, new THREE.Matrix4().makeTranslation(...body.com).elements);
    }
    if (body.ellipsoid) {
      const solid = this.#mesh(new THREE.SphereGeometry(1, 40, 26), "soft", { lit: true, transparent: true, opacity: 0.28, depthWrite: false });
      const group = new THREE.Group(), { lines } = this;
      group.add(solid, ...[[0, 0], [Math.PI / 2, 0], [0, Math.PI / 2]].map(([x, y]) => {
        const circle = painted(new THREE.LineLoop(lines, new THREE.LineBasicMaterial()), "ink");
        circle.rotation.set(x, y, 0);
        return circle;
      }));
      this.#add("ellipsoids", path.concat("ellipsoid"), group, drawable(body.ellipsoid));
    }
  }

  // The range as a sector about the joint's axis (a bar along it), in the link before; a needle that moves with the joint.
  #limits(joint, i) {
    const { lower, upper } = joint, before = this.run.chain[i].concat(`range_${i + 1}`), after = this.run.chain[i + 1].concat("needle");
    if (lower === null || upper === null) return;
    const side = { side: THREE.DoubleSide, transparent: true, opacity: 0.45, depthWrite: false }, wide = 1.5 * this.size;
    if (joint.kind === "revolute") {
      const turn = Math.min(upper - lower, 2 * Math.PI);
      const sector = this.#mesh(new THREE.RingGeometry(0.82 * wide, wide, 72, 1, lower, turn), "soft", side);
      const ends = [lower, upper].map((angle) => this.#bar(0.7 * wide, 1.08 * wide, angle, "soft"));
      const group = new THREE.Group();
      group.add(sector, ...ends);
      this.#add("limits", before, group, joint.origin);
      this.#add("limits", after, this.#bar(0, 1.14 * wide, 0, "ink"));
    } else {
      const long = Math.max(upper - lower, 1e-6), rail = this.#mesh(new THREE.CylinderGeometry(0.05 * this.size, 0.05 * this.size, long, 12), "soft", side);
      rail.rotation.x = Math.PI / 2;
      rail.position.set(wide, 0, (lower + upper) / 2);
      const group = new THREE.Group();
      group.add(rail);
      this.#add("limits", before, group, joint.origin);
      this.#add("limits", after, this.#bar(0, 1.14 * wide, 0, "ink"));
    }
  }

  // A bar in the plane across the axis, from one radius to another.
  #bar(from, to, angle, token) {
    const thick = 0.025 * this.size, bar = this.#mesh(new THREE.BoxGeometry(to - from, 2 * thick, 2 * thick), token);
    const turned = new THREE.Group();
    bar.position.x = (from + to) / 2;
    turned.add(bar);
    turned.rotation.z = angle;
    return turned;
  }

  // An arrow beside the arm, as long as two frames' axes.
  #gravity() {
    const g = new THREE.Vector3(...this.data.arm.gravity), long = 2.2 * this.size, thin = 0.045 * this.size;
    if (g.length() === 0) return;
    const arrow = new THREE.Group();
    const shaft = this.#mesh(new THREE.CylinderGeometry(thin, thin, 0.78 * long, 16), "ink", { lit: true });
    const head = this.#mesh(new THREE.ConeGeometry(2.8 * thin, 0.22 * long, 20), "ink", { lit: true });
    shaft.position.y = 0.39 * long;
    head.position.y = 0.89 * long;
    arrow.add(shaft, head);
    arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), g.clone().normalize());
    const points = this.outline(), middle = new THREE.Box3().setFromPoints(points).getCenter(new THREE.Vector3());
    const left = new THREE.Vector3(Math.sin(this.run.azimuth), -Math.cos(this.run.azimuth), 0); // in the picture
    const away = Math.max(...points.map((point) => left.dot(point))) + 1.5 * this.size;
    const aside = left.multiplyScalar(away - left.dot(middle));
    arrow.position.copy(middle.add(aside)).addScaledVector(g.normalize(), -long / 2);
    this.arrow = [arrow.position.clone(), arrow.position.clone().addScaledVector(g, long)];
    const group = new THREE.Group();
    group.add(arrow);
    this.#add("gravity", this.run.root.concat("gravity"), group);
  }
}

// The bands of a drawn arm have the colour of a joint, not that of a run.
function plainColours(stage, run) {
  stage.node(run.chain[0]).traverse((part) => {
    if (/^run/.test(part.userData.token)) part.userData.token = "joint";
  });
}

// A flat ellipsoid gets a thickness of a tenth of a millimetre: three.js cannot light a surface without volume.
function drawable(pose) {
  const out = new THREE.Matrix4().fromArray(pose), axes = [0, 1, 2].map(() => new THREE.Vector3()), least = 1e-4;
  out.extractBasis(...axes);
  axes.forEach((axis, k) => {
    if (axis.length() >= least) return;
    axis.crossVectors(axes[(k + 1) % 3], axes[(k + 2) % 3]);
    if (axis.length() > 0) axis.setLength(least);
  });
  return out.makeBasis(...axes).setPosition(pose[12], pose[13], pose[14]).elements;
}
