// A section of the workspace: where the flange gets in the upright plane through the first joint's axis, by sampling.

const workspaceSection = (explorer) => {
  const SAMPLES = 20000, { arm, robot, run, stage: { viewer } } = explorer;
  let seed = 1;
  const random = () => { // the same points on every page (Lehmer, Park and Miller 1988)
    seed = (seed * 48271) % 2147483647;
    return seed / 2147483647;
  };

  // Points (distance from the axis, height along it) in the frame of the first joint, over the joints' whole ranges.
  const points = () => {
    const q = new Float64Array(arm.joints.length), pose = new Float64Array(16), out = new Float32Array(3 * SAMPLES);
    const into = new THREE.Matrix4().fromArray(arm.joints[0].origin).invert(), at = new THREE.Vector3();
    for (let k = 0; k < SAMPLES; k += 1) {
      arm.joints.forEach(({ slider: [low, up] }, i) => { q[i] = low + random() * (up - low); });
      robot.flange_pose(q, pose);
      at.set(pose[3], pose[7], pose[11]).applyMatrix4(into);
      out.set([Math.hypot(at.x, at.y), 0, at.z], 3 * k);
    }
    return out;
  };

  const path = run.chain[0].concat("section");
  let cloud = null;
  // In the plane in which the flange is now.
  const turn = (q) => {
    if (!cloud || !box.checked) return;
    const m = new THREE.Matrix4().fromArray(arm.joints[0].origin), flange = new THREE.Vector3().setFromMatrixPosition(new THREE.Matrix4().fromArray(armKinematics.flange(arm, q)));
    flange.applyMatrix4(m.clone().invert());
    viewer.set_transform(path, m.multiply(new THREE.Matrix4().makeRotationZ(Math.atan2(flange.y, flange.x))).elements);
  };
  const box = explorer.addSwitch("section", "workspace section");
  const draw = () => {
    if (!cloud && box.checked) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.Float32BufferAttribute(points(), 3));
      cloud = painted(new THREE.Points(geometry, new THREE.PointsMaterial({ size: 2, sizeAttenuation: false, transparent: true, opacity: 0.5 })), "focus");
      explorer.addObject(path, cloud);
    }
    if (cloud) viewer.set_property(path, "visible", box.checked);
    turn(explorerState.q);
  };
  box.addEventListener("change", draw);
  explorerState.listen((state) => turn(state.q));
  return { points };
};

explorerPanels.add("section", (explorer) => (explorer.arm.joints[0].kind === "revolute" && explorer.robot.flange_pose ? workspaceSection(explorer) : null));
