// Joint positions for a pose of the flange: the closed form where the arm has one, else damped steps along the Jacobian.

const flangeSolver = (arm, robot) => {
  const n = arm.joints.length, closed = robot.inverse_kinematics_near, byAngle = robot.inverse_kinematics_arm_angle;
  const REACHED = 0, OTHER_ANGLE = 1, OUTSIDE = 2, TOO_FAR = 3, CLOSE = 1e-9, STEPS = 60, STEP = 0.3;
  const jacobian = new Float64Array(6 * n), here = new Float64Array(16), error = new Float64Array(6), angle = new Float64Array(4);
  const inside = (x, i) => Math.min(Math.max(x, arm.joints[i].lower ?? -Infinity), arm.joints[i].upper ?? Infinity);

  // The way from the pose of q to the asked one: metres, then the small turn [rad].
  const away = (pose, q) => {
    robot.flange_pose(q, here);
    error.fill(0);
    for (let row = 0; row < 3; row += 1) error[row] = pose[4 * row + 3] - here[4 * row + 3];
    for (let column = 0; column < 3; column += 1) {
      const [a, b, c] = [0, 4, 8].map((row) => here[row + column]), [x, y, z] = [0, 4, 8].map((row) => pose[row + column]);
      error[3] += (b * z - c * y) / 2;
      error[4] += (c * x - a * z) / 2;
      error[5] += (a * y - b * x) / 2;
    }
    return Math.hypot(...error);
  };

  // x of A x = b, A symmetric and positive (6 x 6), by elimination; both are used up.
  const solved = (A, b) => {
    for (let k = 0; k < 6; k += 1) {
      for (let row = k + 1; row < 6; row += 1) {
        const factor = A[row][k] / A[k][k];
        for (let column = k; column < 6; column += 1) A[row][column] -= factor * A[k][column];
        b[row] -= factor * b[k];
      }
    }
    for (let k = 5; k >= 0; k -= 1) {
      for (let column = k + 1; column < 6; column += 1) b[k] -= A[k][column] * b[column];
      b[k] /= A[k][k];
    }
    return b;
  };

  const step = (q) => {
    robot.jacobian(q, jacobian);
    const damping = 1e-8 + 0.01 * Math.min(error.reduce((sum, x) => sum + x * x, 0), 1);
    const A = [0, 1, 2, 3, 4, 5].map((row) => [0, 1, 2, 3, 4, 5].map((column) => {
      let sum = row === column ? damping : 0;
      for (let i = 0; i < n; i += 1) sum += jacobian[row * n + i] * jacobian[column * n + i];
      return sum;
    }));
    const x = solved(A, Array.from(error)), move = Array.from(q, (_, i) => x.reduce((sum, value, row) => sum + jacobian[row * n + i] * value, 0));
    const shorter = Math.min(1, STEP / Math.max(...move.map(Math.abs), 1e-12));
    move.forEach((value, i) => { q[i] = inside(q[i] + shorter * value, i); });
  };

  const stepped = (pose, near, out) => {
    const q = Float64Array.from(near);
    let left = away(pose, q);
    for (let k = 0; k < STEPS && left > CLOSE; k += 1) {
      step(q);
      left = away(pose, q);
    }
    if (left > 1e-7) return TOO_FAR;
    out.set(q);
    return REACHED;
  };

  // The arm angle of q where the arm has one, else null.
  const armAngle = (q) => {
    if (!byAngle) return null;
    byAngle(q, angle);
    return angle[0];
  };

  // Fills out; gives REACHED, OTHER_ANGLE, OUTSIDE (limits) or TOO_FAR, where out is as it was.
  const solve = (pose, psi, near, out) => {
    if (!closed) return stepped(pose, near, out);
    return byAngle ? closed(pose, psi, near, out) : closed(pose, near, out);
  };

  return { solve, armAngle, isClosed: Boolean(closed), OTHER_ANGLE, OUTSIDE, TOO_FAR };
};
