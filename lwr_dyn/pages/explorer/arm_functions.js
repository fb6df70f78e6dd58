// The functions of one arm: those of its set with the arm's own numbers as data - inertia of the links with the payload,
// rotors, gravity. Arms with the same kinematics share a set. Null where the page computes nothing for the arm.

function armFunctions({ set, inertia, rotors, carrier, arm }) {
  const own = set === null ? null : armSets[set];
  if (!own || !inertia || !own.inverse_dynamics) return own && { ...own, n: arm.joints.length, carry: () => {} };
  const { n } = own, bare = Float64Array.from(inertia), numbers = bare.slice(), gravity = Float64Array.from(arm.gravity);
  const zero = new Float64Array(n), still = new Float64Array(3), [alone, unit, both, faster, step] = Array.from({ length: 5 }, () => new Float64Array(n));
  const made = () => new Float64Array(n);

  // C dq, without gravity; quadratic in dq.
  const ofSpeed = (q, dq, out) => own.inverse_dynamics(q, dq, zero, numbers, still, out);

  const inverse_dynamics = (q, dq, ddq, out = made()) => {
    own.inverse_dynamics(q, dq, ddq, numbers, gravity, out);
    for (let i = 0; i < n; i += 1) out[i] += rotors[i] * ddq[i];
    return out;
  };

  const mass_matrix = (q, out = new Float64Array(n * n)) => {
    own.mass_matrix(q, numbers, out);
    for (let i = 0; i < n; i += 1) out[i * n + i] += rotors[i];
    return out;
  };

  // Christoffel's C, column by column: C e_j = [h(dq + e_j) - h(dq) - h(e_j)] / 2 with h = C dq.
  const coriolis_matrix = (q, dq, out = new Float64Array(n * n)) => {
    ofSpeed(q, dq, alone);
    faster.set(dq);
    for (let j = 0; j < n; j += 1) {
      step[j] = 1;
      faster[j] = dq[j] + 1;
      ofSpeed(q, step, unit);
      ofSpeed(q, faster, both);
      for (let i = 0; i < n; i += 1) out[i * n + j] = (both[i] - alone[i] - unit[i]) / 2;
      step[j] = 0;
      faster[j] = dq[j];
    }
    return out;
  };

  // A mass [kg] at a point [m] of the flange's frame, added to the last link: m, m p, m (p.p E - p p^T).
  const carry = (mass, at) => {
    const p = [0, 1, 2].map((row) => carrier[row] * at[0] + carrier[4 + row] * at[1] + carrier[8 + row] * at[2] + carrier[12 + row]), [x, y, z] = p;
    const load = [1, x, y, z, y * y + z * z, -x * y, x * x + z * z, -x * z, -y * z, x * x + y * y];
    load.forEach((part, k) => { numbers[10 * (n - 1) + k] = bare[10 * (n - 1) + k] + mass * part; });
  };

  return { ...own, inertia: numbers, rotors: Float64Array.from(rotors), inverse_dynamics, mass_matrix, coriolis_matrix, carry, gravity_vector: (q, out = made()) => own.gravity_vector(q, numbers, gravity, out) };
}
