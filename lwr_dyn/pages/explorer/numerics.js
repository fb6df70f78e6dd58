// What several panels compute with: singular values, a symmetric positive system, random numbers.

const LOST = 1e-9; // of the largest singular value: smaller ones are lost directions
const PAIRS = [[0, 1], [0, 2], [1, 2]];

// Jacobi's rotations from one side (Hestenes 1958): three rows of n numbers become orthogonal, their lengths are the
// singular values `sizes`, the columns of `turned` the directions. Small ones keep their digits, as squares would not.
function singularValues(rows, n, sizes, turned) {
  const dot = (p, r) => {
    let sum = 0;
    for (let i = 0; i < n; i += 1) sum += rows[p * n + i] * rows[r * n + i];
    return sum;
  };
  const turn = (values, a, b, c, s) => {
    const x = values[a], y = values[b];
    values[a] = c * x - s * y;
    values[b] = s * x + c * y;
  };
  turned.fill(0);
  for (let k = 0; k < 3; k += 1) turned[4 * k] = 1;
  for (let round = 0; round < 12; round += 1) {
    let left = 0;
    for (const [p, r] of PAIRS) {
      const a = dot(p, p), b = dot(r, r), off = dot(p, r);
      if (Math.abs(off) <= 1e-16 * Math.sqrt(a * b)) continue;
      left += 1;
      const theta = (b - a) / (2 * off), t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.hypot(theta, 1));
      const c = 1 / Math.hypot(t, 1), s = t * c;
      for (let i = 0; i < n; i += 1) turn(rows, p * n + i, r * n + i, c, s);
      for (let k = 0; k < 3; k += 1) turn(turned, 3 * k + p, 3 * k + r, c, s);
    }
    if (left === 0) break;
  }
  for (let k = 0; k < 3; k += 1) sizes[k] = Math.sqrt(dot(k, k));
}

// Yoshikawa's (1985): the product of the singular values; 0 where a direction is lost.
function manipulability(sizes) {
  const largest = Math.max(...sizes);
  return sizes.some((x) => x <= LOST * largest) ? 0 : sizes.reduce((product, x) => product * x, 1);
}

// x of H x = b for a symmetric positive H by Cholesky's factors (its lower half is read); null where it is not positive.
function solvedPositive(H, b) {
  const n = b.length;
  for (let k = 0; k < n; k += 1) {
    for (let m = 0; m < k; m += 1) H[k][k] -= H[k][m] * H[k][m];
    if (!(H[k][k] > 0)) return null;
    H[k][k] = Math.sqrt(H[k][k]);
    for (let i = k + 1; i < n; i += 1) {
      for (let m = 0; m < k; m += 1) H[i][k] -= H[i][m] * H[k][m];
      H[i][k] /= H[k][k];
    }
    for (let m = 0; m < k; m += 1) b[k] -= H[k][m] * b[m];
    b[k] /= H[k][k];
  }
  for (let k = n - 1; k >= 0; k -= 1) {
    for (let i = k + 1; i < n; i += 1) b[k] -= H[i][k] * b[i];
    b[k] /= H[k][k];
  }
  return b;
}

// Random numbers below 1, the same on every page (Lehmer; Park and Miller 1988).
function repeatable(seed) {
  return () => {
    seed = (seed * 48271) % 2147483647;
    return seed / 2147483647;
  };
}
