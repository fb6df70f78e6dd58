// The largest B_ii of each joint within the limits, as lwr_dyn.control.worst_case_inertia searches it: along a turning joint
// B_ii = a0 + a1 cos + b1 sin + a2 cos 2 + b2 sin 2, so five values give the line and its maximum; along a sliding one it is
// a convex parabola, largest at an end. Climbs joint by joint, from corners and places drawn the same on every page.

const largestInertia = (() => {
  const STARTS = 48, ROUNDS = 40, FIFTHS = [0, 1, 2, 3, 4].map((m) => (2 * Math.PI * m) / 5);

  // Where f of the line through `values` at the fifths of a turn is largest in [low, up].
  const peak = (values, low, up) => {
    const sum = (wave) => FIFTHS.reduce((total, angle, m) => total + (2 / 5) * values[m] * wave(angle), 0);
    const a1 = sum(Math.cos), b1 = sum(Math.sin), a2 = sum((x) => Math.cos(2 * x)), b2 = sum((x) => Math.sin(2 * x));
    const at = (x) => a1 * Math.cos(x) + b1 * Math.sin(x) + a2 * Math.cos(2 * x) + b2 * Math.sin(2 * x);
    const slope = (x) => b1 * Math.cos(x) - a1 * Math.sin(x) + 2 * (b2 * Math.cos(2 * x) - a2 * Math.sin(2 * x));
    const bend = (x) => -a1 * Math.cos(x) - b1 * Math.sin(x) - 4 * (a2 * Math.cos(2 * x) + b2 * Math.sin(2 * x));
    let best = low;
    for (let m = 1; m <= 48; m += 1) {
      const x = low + ((up - low) * m) / 48;
      if (at(x) > at(best)) best = x;
    }
    for (let m = 0; m < 6 && bend(best) < 0; m += 1) { // Newton's
      const next = Math.min(Math.max(best - slope(best) / bend(best), low), up);
      if (!(at(next) >= at(best))) break;
      best = next;
    }
    return best;
  };

  // [kg m^2 or kg] of joint i; joints as in the page's data.
  return (robot, joints, i) => {
    const { n } = robot, B = new Float64Array(n * n), q = new Float64Array(n), values = new Float64Array(5);
    const random = repeatable(1);
    const value = () => robot.mass_matrix(q, B)[i * n + i];

    const along = (k) => {
      const { kind, slider: [low, up] } = joints[k];
      const places = kind === "revolute" ? FIFTHS : [low, up];
      places.forEach((x, m) => {
        q[k] = x;
        values[m] = value();
      });
      if (kind === "revolute") q[k] = peak(values, low, up);
      else q[k] = values[0] > values[1] ? low : up;
    };

    const climb = () => {
      let best = value();
      for (let round = 0; round < ROUNDS; round += 1) {
        for (let k = i + 1; k < n; k += 1) along(k); // joints before i change nothing of B_ii
        const now = value();
        if (now - best <= 1e-13 * now) return now;
        best = now;
      }
      return best;
    };

    let largest = 0;
    for (let start = 0; start < (i === n - 1 ? 1 : STARTS); start += 1) {
      joints.forEach(({ slider: [low, up] }, k) => {
        const corner = (Math.PI / 2) * Math.round((low + random() * (up - low)) / (Math.PI / 2));
        q[k] = start % 2 ? low + random() * (up - low) : Math.min(Math.max(corner, low), up);
      });
      largest = Math.max(largest, climb());
    }
    return largest;
  };
})();
