// Whether the flange gets to a distance from the first joint's axis and a height along it, and by which positions:
// damped Gauss-Newton steps (Levenberg 1944, Marquardt 1963) inside the joints' ranges.

class SectionReach {
  constructor(robot, arm) {
    const n = arm.joints.length;
    Object.assign(this, { robot, n, origin: arm.joints[0].origin, low: arm.joints.map(({ slider }) => slider[0]), up: arm.joints.map(({ slider }) => slider[1]) });
    Object.assign(this, { pose: new Float64Array(16), J: new Float64Array(6 * n), rates: new Float64Array(2 * n), free: new Uint8Array(n), way: new Float64Array(n), rho: 0, z: 0 });
  }

  // Sets rho (distance from the axis; x, y across it) and z (height along it) of q. Written out: it is called millions of times.
  place(q) {
    const { pose, origin: m } = this;
    this.robot.flange_pose(q, pose);
    const a = pose[3] - m[12], b = pose[7] - m[13], c = pose[11] - m[14];
    this.x = m[0] * a + m[1] * b + m[2] * c;
    this.y = m[4] * a + m[5] * b + m[6] * c;
    this.z = m[8] * a + m[9] * b + m[10] * c;
    this.rho = Math.sqrt(this.x * this.x + this.y * this.y);
    return this;
  }

  // How rho and z change with each joint, where `place` was.
  #rates(q) {
    const { n, J, rates, origin: m, x, y, rho } = this, u = rho > 1e-12 ? x / rho : 1, v = rho > 1e-12 ? y / rho : 0;
    const out0 = u * m[0] + v * m[4], out1 = u * m[1] + v * m[5], out2 = u * m[2] + v * m[6]; // away from the axis, in the base
    this.robot.jacobian(q, J);
    for (let i = 0; i < n; i += 1) {
      rates[i] = out0 * J[i] + out1 * J[n + i] + out2 * J[2 * n + i];
      rates[n + i] = m[8] * J[i] + m[9] * J[n + i] + m[10] * J[2 * n + i];
    }
  }

  // The largest area of two joints' rates at q: zero where the flange can move along one direction at most.
  bends(q) {
    const { n, rates } = this;
    let most = 0;
    this.place(q).#rates(q);
    for (let i = 0; i < n; i += 1) for (let j = 0; j < i; j += 1) most = Math.max(most, Math.abs(rates[i] * rates[n + j] - rates[j] * rates[n + i]));
    return most;
  }

  // The step towards what is left (a, b) into `way`; a joint that would pass its end stops there, the others do the rest.
  #step(q, a, b, damping) {
    const { n, rates, free, way, low, up } = this;
    free.fill(1);
    for (let pass = 0, again = true; pass <= n && again; pass += 1) {
      let [aa, ab, bb] = [0, 0, 0];
      for (let i = 0; i < n; i += 1) {
        if (!free[i]) continue;
        aa += rates[i] * rates[i];
        ab += rates[i] * rates[n + i];
        bb += rates[n + i] * rates[n + i];
      }
      const more = damping * (aa + bb) + 1e-14, det = (aa + more) * (bb + more) - ab * ab;
      const u = ((bb + more) * a - ab * b) / det, v = ((aa + more) * b - ab * a) / det;
      again = false;
      for (let i = 0; i < n; i += 1) {
        if (!free[i]) continue;
        way[i] = rates[i] * u + rates[n + i] * v;
        const end = Math.min(Math.max(q[i] + way[i], low[i]), up[i]) - q[i];
        if (end === way[i]) continue;
        way[i] = end;
        free[i] = 0;
        a -= rates[i] * end;
        b -= rates[n + i] * end;
        again = true;
      }
    }
    let most = 0;
    for (let i = 0; i < n; i += 1) most = Math.max(most, Math.abs(way[i]));
    if (most > 0.5) for (let i = 0; i < n; i += 1) way[i] *= 0.5 / most;
  }

  // Positions at (rho, z), found from `start`, or null.
  solve(rho, z, start) {
    let q = Float64Array.from(start), next = new Float64Array(this.n), damping = 1e-8, before = Infinity;
    let left = this.#left(q, rho, z);
    for (let k = 0; k < 40; k += 1) {
      if (left < 1e-9) return q;
      if (k % 5 === 4) {
        if (left > 0.6 * before) return null; // it does not get nearer
        before = left;
      }
      this.place(q).#rates(q);
      this.#step(q, rho - this.rho, z - this.z, damping);
      for (let i = 0; i < this.n; i += 1) next[i] = Math.min(Math.max(q[i] + this.way[i], this.low[i]), this.up[i]);
      const found = this.#left(next, rho, z);
      if (found < left) {
        [q, next, left] = [next, q, found];
        damping = Math.max(damping / 10, 1e-8);
      } else damping = Math.max(damping * 10, 1e-4);
    }
    return null;
  }

  // As `solve`, by Newton's steps with the second derivatives, for places at the end of the reach: there many joints have
  // to be just so, which first derivatives do not see.
  solveNear(rho, z, start) {
    const { n, low, up } = this, next = new Float64Array(n);
    let q = Float64Array.from(start, (x, i) => Math.min(Math.max(x + (i % 3 - 0.7) * 1e-3, low[i]), up[i])), damping = 1e-6; // off saddles
    let left = this.#left(q, rho, z), small = 0;
    for (let k = 0; k < 40 && damping < 1e3 && small < 3; k += 1) {
      if (left < 1e-9) return q;
      const step = this.#newton(q, rho, z, damping);
      if (step === null) return null;
      if (!step) {
        damping = Math.max(10 * damping, 1e-3);
        continue;
      }
      for (let i = 0; i < n; i += 1) next[i] = Math.min(Math.max(q[i] + this.way[i], low[i]), up[i]);
      const found = this.#left(next, rho, z);
      if (found < left) {
        small = found > 0.98 * left ? small + 1 : 0; // the nearest there is
        q = Float64Array.from(next);
        left = found;
        damping /= 10;
      } else damping = Math.max(10 * damping, 1e-3);
    }
    return null;
  }

  // The step into `way`, of the joints that are not pressed against an end; false where the Hessian is not positive, null
  // where no small step gets nearer.
  #newton(q, rho, z, damping) {
    const { n, rates, low, up } = this, first = new Float64Array(n), free = [], gentle = 1e-6;
    this.place(q).#rates(q);
    const a = rho - this.rho, b = z - this.z, at = Float64Array.from(rates), pull = (i) => a * rates[i] + b * rates[n + i];
    for (let i = 0; i < n; i += 1) {
      first[i] = pull(i);
      if (!(q[i] <= low[i] && first[i] < 0) && !(q[i] >= up[i] && first[i] > 0)) free.push(i);
    }
    const pulled = Math.max(0, ...free.map((i) => Math.abs(first[i])));
    if (pulled < 1e-6 * Math.hypot(a, b) * Math.max(...at.map(Math.abs))) return null;
    const trace = at.reduce((sum, x) => sum + x * x, 0), moved = Float64Array.from(q), H = free.map(() => new Float64Array(free.length));
    free.forEach((j, column) => {
      moved[j] = q[j] + gentle;
      this.place(moved).#rates(moved);
      moved[j] = q[j];
      free.forEach((i, row) => { H[row][column] = at[i] * at[j] + at[n + i] * at[n + j] - (pull(i) - first[i]) / gentle; });
    });
    free.forEach((_, row) => { H[row][row] += damping * trace + 1e-14; });
    const way = solvedPositive(H, free.map((i) => first[i]));
    if (!way) return false;
    this.way.fill(0);
    const most = Math.max(0.3, ...way.map(Math.abs));
    free.forEach((i, row) => { this.way[i] = (0.3 / most) * way[row]; });
    return true;
  }

  #left(q, rho, z) {
    this.place(q);
    return Math.hypot(rho - this.rho, z - this.z);
  }
}
