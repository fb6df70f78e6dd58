// Joint positions for a pose of the flange: the closed form where the arm has one, else damped steps along the Jacobian.
// An arm of fewer than six joints cannot reach most poses: it goes as near as it gets, and unless it is turned, the
// flange's place alone counts.

const flangeSolver = (arm, robot) => {
  const n = arm.joints.length, closed = robot.inverse_kinematics_near, byAngle = robot.inverse_kinematics_arm_angle;
  const REACHED = 0, OTHER_ANGLE = 1, OUTSIDE = 2, TOO_FAR = 3, NEAREST = 4, CLOSE = 1e-9, STEPS = 60, STEP = 0.3, SMALLEST = 1e-6, JUMP = 0.5, TRIES = 48;
  const jacobian = new Float64Array(6 * n), here = new Float64Array(16), error = new Float64Array(6), angle = new Float64Array(4);
  const inside = (x, i) => Math.min(Math.max(x, arm.joints[i].lower ?? -Infinity), arm.joints[i].upper ?? Infinity);

  // The way from the pose of q to the asked one: metres, then the small turn [rad].
  const away = (pose, q, count) => {
    robot.flange_pose(q, here);
    error.fill(0);
    for (let row = 0; row < 3; row += 1) error[row] = pose[4 * row + 3] - here[4 * row + 3];
    if (count === 6) for (let column = 0; column < 3; column += 1) {
      const [a, b, c] = [0, 4, 8].map((row) => here[row + column]), [x, y, z] = [0, 4, 8].map((row) => pose[row + column]);
      error[3] += (b * z - c * y) / 2;
      error[4] += (c * x - a * z) / 2;
      error[5] += (a * y - b * x) / 2;
    }
    return Math.hypot(...error);
  };

  const step = (q, count) => {
    robot.jacobian(q, jacobian);
    const damping = 1e-8 + 0.01 * Math.min(error.reduce((sum, x) => sum + x * x, 0), 1), rows = [0, 1, 2, 3, 4, 5].slice(0, count);
    const A = rows.map((row) => rows.map((column) => {
      let sum = row === column ? damping : 0;
      for (let i = 0; i < n; i += 1) sum += jacobian[row * n + i] * jacobian[column * n + i];
      return sum;
    }));
    const x = solvedPositive(A, Array.from(error.subarray(0, count)));
    if (!x) return;
    const move = Array.from(q, (_, i) => x.reduce((sum, value, row) => sum + jacobian[row * n + i] * value, 0));
    const shorter = Math.min(1, STEP / Math.max(...move.map(Math.abs), 1e-12));
    move.forEach((value, i) => { q[i] = inside(q[i] + shorter * value, i); });
  };

  const stepped = (pose, near, out, turning) => {
    const q = Float64Array.from(near), count = n >= 6 || turning ? 6 : 3, best = Float64Array.from(near);
    let left = away(pose, q, count), least = left;
    for (let k = 0; k < STEPS && left > CLOSE; k += 1) {
      step(q, count);
      left = away(pose, q, count);
      if (left < least) {
        best.set(q);
        least = left;
      } else if (k > 20 && left > 1e-3) break; // it does not come nearer
    }
    if (least > 1e-7 && n >= 6) return TOO_FAR;
    out.set(best);
    return least > 1e-7 ? NEAREST : REACHED;
  };

  // The arm angle of q where the arm has one, else null.
  const armAngle = (q) => {
    if (!byAngle) return null;
    byAngle(q, angle);
    return angle[0];
  };

  // Fills out; gives REACHED, OTHER_ANGLE, NEAREST (of few joints), or OUTSIDE (limits), TOO_FAR, where out is as it was.
  const solve = (pose, psi, near, out, turning = false) => {
    if (!closed) return stepped(pose, near, out, turning);
    return byAngle ? closed(pose, psi, near, out) : closed(pose, near, out);
  };

  // Goes straight (with the shortest turn) from a pose, whose joints are `start`, towards another one until a wall: there
  // is no solution, or only one at which a joint would jump. Fills out with the last solution.
  const wall = (from, to, psi, start, out) => {
    const [a, b] = [from, to].map((pose) => {
      const parts = [new THREE.Vector3(), new THREE.Quaternion(), new THREE.Vector3()];
      new THREE.Matrix4().set(...pose).decompose(...parts);
      return parts;
    });
    const at = (share) => armKinematics.rows(new THREE.Matrix4().compose(a[0].clone().lerp(b[0], share), a[1].clone().slerp(b[1], share), a[2]).elements).flat();
    const next = Float64Array.from(start);
    let [done, step] = [0, 1 / 16];
    out.set(start);
    for (let k = 0; k < TRIES && step > SMALLEST && done < 1; k += 1) {
      const share = Math.min(done + step, 1), found = solve(at(share), psi, out, next);
      if (found < OUTSIDE && next.every((x, i) => Math.abs(x - out[i]) < JUMP)) {
        out.set(next);
        done = share;
      } else step /= 2;
    }
  };
  return { solve, wall, armAngle, isClosed: Boolean(closed), OTHER_ANGLE, OUTSIDE, TOO_FAR, NEAREST };
};
