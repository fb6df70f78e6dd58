// Kinematics of an arm, from the page's data alone: nothing here draws, and nothing here reads the page.
// Poses are 16 numbers, column after column; angles in rad, lengths in m.
"use strict";

const armKinematics = (() => {
  const product = (a, b) => {
    const out = new Float64Array(16);
    for (let row = 0; row < 4; row += 1) {
      for (let column = 0; column < 4; column += 1) {
        let sum = 0;
        for (let k = 0; k < 4; k += 1) sum += a[4 * k + row] * b[4 * column + k];
        out[4 * column + row] = sum;
      }
    }
    return out;
  };

  // Turn about z by q, or slide along z by q.
  const motion = (kind, q) => {
    const c = kind === "revolute" ? Math.cos(q) : 1, s = kind === "revolute" ? Math.sin(q) : 0;
    return [c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, 0, 0, kind === "revolute" ? 0 : q, 1];
  };

  // T_0,1 ... T_0,n of the joints' own frames, and T_0,flange.
  const frames = (arm, q) => {
    let pose = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
    const out = arm.joints.map((joint, i) => {
      pose = product(product(pose, joint.origin), motion(joint.kind, q[i]));
      return pose;
    });
    return [...out, product(pose, arm.flange)];
  };

  // T_0,flange, without the frames between; the last one is kept, for all who ask for the same positions.
  const kept = { arm: null, q: new Float64Array(0), pose: null };
  const flange = (arm, q) => {
    const { joints } = arm;
    if (kept.arm === arm && kept.q.every((x, i) => x === q[i])) return kept.pose;
    let pose = new Float64Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    for (let i = 0; i < joints.length; i += 1) {
      const { origin, kind } = joints[i];
      pose = product(pose, origin);
      const c = Math.cos(q[i]), s = Math.sin(q[i]);
      for (let row = 0; row < 3; row += 1) {
        const a = pose[row], b = pose[4 + row];
        if (kind === "revolute") [pose[row], pose[4 + row]] = [c * a + s * b, c * b - s * a];
        else pose[12 + row] += pose[8 + row] * q[i];
      }
    }
    Object.assign(kept, { arm, q: Float64Array.from(q), pose: product(pose, arm.flange) });
    return kept.pose;
  };

  // The length of the arm along its joints, which no pose exceeds but by sliding joints.
  const reach = (arm) => [...arm.joints.map((joint) => joint.origin), arm.flange].reduce((sum, pose) => sum + Math.hypot(pose[12], pose[13], pose[14]), 0);

  // Four rows of four, as NumPy has them.
  const rows = (pose) => [0, 1, 2, 3].map((row) => [pose[row], pose[row + 4], pose[row + 8], pose[row + 12]]);

  // Roll, pitch, yaw with R = Rz(yaw) Ry(pitch) Rx(roll); near a pitch of 90 degrees roll follows from the yaw.
  const rollPitchYaw = (pose) => {
    const [r00, r10, r20, , r01, r11, , , r02, r12] = pose, level = Math.hypot(r00, r10), pitch = Math.atan2(-r20, level);
    if (level < 1e-14) return [0, pitch, Math.atan2(-r01, r11)];
    const yaw = Math.atan2(r10, r00), c = Math.cos(yaw), s = Math.sin(yaw);
    return [Math.atan2(s * r02 - c * r12, c * r11 - s * r01), pitch, yaw];
  };

  // A position in the units of the command line (deg; m of a sliding joint), and back.
  const shown = (joint, q) => (joint.kind === "revolute" ? (q * 180) / Math.PI : q);
  const meant = (joint, value) => (joint.kind === "revolute" ? value * (Math.PI / 180) : value);

  return { frames, flange, reach, rows, rollPitchYaw, shown, meant };
})();
