// Each link's share of an entry of B, C or g, from the links' masses, centres and moments in the page's data.
// Column i of a link's Jacobians: Jv = z_i x (c - p_i), Jw = z_i of a turning joint; Jv = z_i, Jw = 0 of a sliding one.
//   B_ij = sum m Jv_i . Jv_j + Jw_i . I Jw_j            (Siciliano et al., Robotics, eq. 7.32; rotors on the diagonal)
//   g_i  = -sum m g_0 . Jv_i                             (eq. 7.39)
//   C_ij = sum m Jv_i . dJv_j/dt + Jw_i . (I a_j + (Jw_j x I w + w x I Jw_j) / 2),
//          a_j = (dJw_j/dt + Jw_j x (w - w_j)) / 2, w the link's and w_j joint j's link's angular velocity.
// The last is the Christoffel form (eqs. 7.44, 7.45) link by link: C e_j = [h(dq + e_j) - h(dq) - h(e_j)] / 2 with h = C dq,
// written out; the centre's acceleration needs no half, since dJv_j/dq_l = dJv_l/dq_j.

const space3 = {
  cross: (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]],
  dot: (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  plus: (a, b, factor = 1) => [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]],
  times: (a, factor) => [a[0] * factor, a[1] * factor, a[2] * factor],
};

class LinkShares {
  // `arm` and `bodies` as in the page's data; all bodies are known. `rotors` [kg m^2 or kg], one a joint.
  constructor(arm, bodies, rotors) {
    Object.assign(this, { arm, bodies, rotors, n: arm.joints.length, links: [], axes: [] });
    this.load = null; // { mass, at }: a mass at a point of the flange's frame
  }

  // Where axes and links are at q, and how they move with dq; everything in the base frame.
  move(q, dq) {
    const { arm, bodies, load } = this, { cross, plus } = space3, frames = armKinematics.frames(arm, q);
    let w = [0, 0, 0], v = [0, 0, 0], at = [0, 0, 0];
    this.axes = [];
    this.links = frames.slice(0, this.n).map((pose, i) => {
      const z = [pose[8], pose[9], pose[10]], p = [pose[12], pose[13], pose[14]], turns = arm.joints[i].kind === "revolute";
      const before = w;
      v = plus(v, cross(w, plus(p, at, -1)));
      if (turns) w = plus(w, z, dq[i]);
      else v = plus(v, z, dq[i]);
      at = p;
      this.axes.push({ z, p, v, turns, before, after: w });
      return this.#link(pose, bodies[i], w, v);
    });
    if (load && load.mass) this.links.push(this.#load(frames[this.n], load));
    return this;
  }

  // The joint that moves link k; the payload, k = n, goes with the last one.
  jointOf(k) { return Math.min(k, this.n - 1); }

  // [{ linear, angular }] a link, zero before the later joint; kind "B", "C" or "g" (j is not used).
  entry(kind, i, j) {
    const first = kind === "g" ? i : Math.max(i, j);
    return this.links.map((link, k) => (this.jointOf(k) < first ? { linear: 0, angular: 0 } : this.#share(kind, link, i, j)));
  }

  // The rotor's share, k_r^2 I_m on the diagonal of B.
  rotor(kind, i, j) { return kind === "B" && i === j ? this.rotors[i] : 0; }

  #share(kind, link, i, j) {
    const { dot } = space3, of = this.column(link, i), { gravity } = this.arm;
    if (kind === "g") return { linear: -link.mass * dot(gravity, of.v), angular: 0 };
    const { v, w } = kind === "B" ? this.#motion(link, j) : this.#change(link, j);
    return { linear: link.mass * dot(of.v, v), angular: dot(of.w, w) };
  }

  // Jv and Jw of a link's centre of mass.
  column(link, i) {
    const { cross, plus } = space3, { z, p, turns } = this.axes[i];
    return turns ? { v: cross(z, plus(link.c, p, -1)), w: z } : { v: z, w: [0, 0, 0] };
  }

  #motion(link, j) {
    const { v, w } = this.column(link, j);
    return { v, w: this.#turned(link, w) };
  }

  #change(link, j) {
    const { cross, plus, times } = space3, { z, p, v, turns, before, after } = this.axes[j], zDot = cross(before, z);
    if (!turns) return { v: zDot, w: [0, 0, 0] };
    const linear = plus(cross(zDot, plus(link.c, p, -1)), cross(z, plus(link.cDot, v, -1)));
    const a = times(plus(zDot, cross(z, plus(link.w, after, -1))), 0.5);
    const gyro = plus(cross(z, this.#turned(link, link.w)), cross(link.w, this.#turned(link, z)));
    return { v: linear, w: plus(this.#turned(link, a), gyro, 0.5) };
  }

  // I x, with the moments in the link's frame.
  #turned({ pose, inertia }, x) {
    if (!inertia) return [0, 0, 0];
    const { dot } = space3, axis = (k) => [pose[4 * k], pose[4 * k + 1], pose[4 * k + 2]];
    const y = [0, 1, 2].map((k) => dot(axis(k), x)), t = inertia.map((row) => dot(row, y));
    return [0, 1, 2].map((k) => pose[k] * t[0] + pose[4 + k] * t[1] + pose[8 + k] * t[2]);
  }

  #link(pose, { mass, com, inertia }, w, v) {
    const { cross, plus } = space3, arm = [0, 1, 2].map((k) => pose[k] * com[0] + pose[4 + k] * com[1] + pose[8 + k] * com[2]);
    return { pose, mass, inertia, c: plus(arm, [pose[12], pose[13], pose[14]]), w, cDot: plus(v, cross(w, arm)) };
  }

  #load(flange, { mass, at }) {
    const last = this.axes[this.n - 1], { cross, plus } = space3;
    const c = [0, 1, 2].map((k) => flange[12 + k] + flange[k] * at[0] + flange[4 + k] * at[1] + flange[8 + k] * at[2]);
    return { pose: flange, mass, inertia: null, c, w: last.after, cDot: plus(last.v, cross(last.after, plus(c, last.p, -1))) };
  }
}
