// What coupling makes of diagonal gains: modes of B x'' + Kd x' + Kp x = 0, with Kp = omega_n^2 b, Kd = 2 xi omega_n b.
// B v = lambda diag(b) v leaves each mode alone with x'' + (2 xi omega_n x' + omega_n^2 x) / lambda = 0: natural frequency
// omega_n / sqrt(lambda), damping ratio xi / sqrt(lambda). Where b is the diagonal of B, the mean of the n lambda is 1.

class LoopModes {
  constructor(n) {
    Object.assign(this, { n, B: new Float64Array(n * n), b: new Float64Array(n), Kp: new Float64Array(n), Kd: new Float64Array(n) });
    Object.assign(this, { scaled: new Float64Array(n * n), turned: new Float64Array(n * n), lambda: new Float64Array(n), led: new Int32Array(n) });
    this.defined = false; // false where a joint has no inertia, or B is singular to rounding
  }

  // Gains and modes of this.B; lambda falling, so the slowest mode first. b is the diagonal of B if not given.
  compute(omega, xi, inertias = null) {
    const { n, B, b, Kp, Kd, scaled, turned, lambda, led } = this;
    for (let i = 0; i < n; i += 1) {
      b[i] = inertias ? inertias[i] : B[i * n + i];
      Kp[i] = omega * omega * b[i];
      Kd[i] = 2 * xi * omega * b[i];
    }
    this.defined = b.every((x) => x > 0);
    if (!this.defined) return this;
    for (let i = 0; i < n; i += 1) {
      for (let j = 0; j < n; j += 1) scaled[i * n + j] = B[i * n + j] / Math.sqrt(b[i] * b[j]);
    }
    symmetricModes(scaled, turned, n);
    const order = Array.from({ length: n }, (_, k) => k).sort((k, m) => scaled[m * (n + 1)] - scaled[k * (n + 1)]);
    order.forEach((k, place) => {
      lambda[place] = scaled[k * (n + 1)];
      led[place] = largestOf(turned, k, n);
    });
    this.defined = lambda[n - 1] > 1e-13;
    return this;
  }

  // [rad/s], and the ratio of mode k.
  frequency(k, omega) { return omega / Math.sqrt(this.lambda[k]); }

  damping(k, xi) { return xi / Math.sqrt(this.lambda[k]); }

  // [Hz] Torque held from sample to sample, no delay, g compensated: a mode is x'' = u with u = -(kd x' + kp x), kd = 2 xi omega_n / lambda,
  // kp = omega_n^2 / lambda. By Jury's test it holds where T kd < 2 (lwr_dyn.design.sampled_loop) and T kp < 2 kd, so above this rate.
  leastRate(omega, xi) {
    return Math.max((xi * omega) / this.lambda[this.n - 1], omega / (4 * xi));
  }
}

// Which entry of column k is the largest.
function largestOf(turned, k, n) {
  let best = 0;
  for (let i = 1; i < n; i += 1) if (Math.abs(turned[i * n + k]) > Math.abs(turned[best * n + k])) best = i;
  return best;
}

// Jacobi's rotations (Golub, Van Loan, Matrix Computations, section 8.5): the symmetric n x n matrix becomes diagonal, the columns of `turned` its axes.
function symmetricModes(matrix, turned, n) {
  turned.fill(0);
  for (let i = 0; i < n; i += 1) turned[i * (n + 1)] = 1;
  for (let round = 0; round < 30; round += 1) {
    let off = 0;
    for (let p = 0; p < n; p += 1) {
      for (let r = p + 1; r < n; r += 1) {
        off = Math.max(off, Math.abs(matrix[p * n + r]));
        if (Math.abs(matrix[p * n + r]) > 1e-300) rotateJacobi(matrix, turned, n, p, r);
      }
    }
    if (off < 1e-15) return;
  }
}

function rotateJacobi(matrix, turned, n, p, r) {
  const theta = (matrix[r * n + r] - matrix[p * n + p]) / (2 * matrix[p * n + r]);
  const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.sqrt(theta * theta + 1)), c = 1 / Math.sqrt(t * t + 1), s = t * c;
  for (let k = 0; k < n; k += 1) {
    const a = matrix[k * n + p], b = matrix[k * n + r], u = turned[k * n + p], v = turned[k * n + r];
    matrix[k * n + p] = c * a - s * b;
    matrix[k * n + r] = s * a + c * b;
    turned[k * n + p] = c * u - s * v;
    turned[k * n + r] = s * u + c * v;
  }
  for (let k = 0; k < n; k += 1) {
    const a = matrix[p * n + k], b = matrix[r * n + k];
    matrix[p * n + k] = c * a - s * b;
    matrix[r * n + k] = s * a + c * b;
  }
}
