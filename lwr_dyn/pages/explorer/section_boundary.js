// The boundary of the workspace in the upright plane through the first joint's axis: closed curves of (distance, height).
// The set of all distances and heights is symmetric about the axis. A grid of places is reached from random positions
// and from neighbours (SectionReach); where a reached place has one that is not beside it, the boundary is between them:
// halving finds it, and on the way between two such points again where the curve has a corner. Each point of the
// curves has positions that reach it.

function* sectionBoundary(robot, arm, cells = 56) {
  const reach = new SectionReach(robot, arm), { n } = reach, random = repeatable(1), samples = randomPlaces(reach, random, 4000);
  const far = Math.max(...samples.map(({ rho }) => rho)), heights = samples.map(({ z }) => z);
  const wide = Math.max(2 * far, Math.max(...heights) - Math.min(...heights)), h = wide / cells, nodes = new Map(), queue = [];
  const shown = samples.map(({ rho, z: height }) => ({ s: rho, z: height }));
  if (!isArea(samples, wide)) return { loops: [], faces: [], h, tolerance: 0, samples: shown };
  const tolerance = h / 50, s = (i) => (i + 0.5) * h, z = (k) => k * h, key = (i, k) => (i < 0 ? -1 - i : i) * 8192 + k + 4096;

  const node = (i, k) => {
    const at = key(i, k);
    if (!nodes.has(at)) nodes.set(at, { i, k, q: null, starts: [], next: 0 });
    return nodes.get(at);
  };
  const offer = (i, k, q) => {
    const place = node(i < 0 ? -1 - i : i, k);
    if (place.q || place.starts.length >= 12) return;
    place.starts.push(q);
    queue.push(place);
  };
  const around = (i, k, act) => { for (let a = -1; a <= 1; a += 1) for (let b = -1; b <= 1; b += 1) if (a || b) act(i + a, k + b); };
  const spread = () => {
    while (queue.length > 0) {
      const place = queue.pop();
      while (!place.q && place.next < place.starts.length) place.q = reach.solve(s(place.i), z(place.k), place.starts[place.next++]);
      if (place.q && !place.done) {
        place.done = true;
        around(place.i, place.k, (i, k) => offer(i, k, place.q));
      }
    }
  };
  const sampled = new Map();
  samples.forEach((place) => {
    const at = key(Math.max(Math.round(place.rho / h - 0.5), 0), Math.round(place.z / h));
    sampled.set(at, [...(sampled.get(at) ?? []), place]);
  });
  samples.forEach(({ rho, z: height, q }) => offer(Math.max(Math.round(rho / h - 0.5), 0), Math.round(height / h), q));
  spread();
  // Other branches of the arm, and small changes of what is known, for a place that seems to be out of reach.
  const others = (at, q) => {
    const away = (place) => Math.hypot(place.rho - Math.abs(at.s), place.z - at.z), count = Math.abs(at.s) < h ? 60 : 6; // more at the axis
    const i = Math.round(Math.abs(at.s) / h - 0.5), k = Math.round(at.z / h), near = [];
    for (let a = -2; a <= 2; a += 1) for (let b = -2; b <= 2; b += 1) if (i + a >= 0) near.push(...(sampled.get(key(i + a, k + b)) ?? []));
    const chosen = near.sort((one, other) => away(one) - away(other)).slice(0, count);
    const kicked = [0.05, 0.3].map((size) => q.map((x, i) => x + size * (random() - 0.5) * Math.min(reach.up[i] - reach.low[i], 2)));
    return [...chosen.map((place) => place.q), ...kicked];
  };
  for (const place of nodes.values()) { // with those that are added on the way
    yield;
    const { i, k, starts } = place;
    place.q ??= firstOf([...starts, ...others({ s: s(i), z: z(k) }, starts[starts.length - 1])], (q) => reach.solveNear(s(i), z(k), q));
    if (place.done) continue;
    queue.push(place);
    spread();
  }

  // The last place that is reached on the way from one that is to one that is not.
  const last = (from, to, starts, isThorough) => {
    const at = (share) => ({ s: from.s + share * (to.s - from.s), z: from.z + share * (to.z - from.z) });
    const reached = (place, some) => firstOf(some, (start) => reach.solve(Math.abs(place.s), place.z, start));
    let [low, high, q] = [0, 1, from.q];
    for (let again = true; again; ) {
      for (let round = 0; round < 9; round += 1) {
        const share = (low + high) / 2, found = reached(at(share), [q, ...starts]);
        if (found) [low, q] = [share, found];
        else high = share;
      }
      const beyond = Math.min(low + tolerance / Math.hypot(to.s - from.s, to.z - from.z), 1);
      const found = low < 1 ? firstOf([q, ...starts, ...(isThorough ? others(at(beyond), q) : [])], (start) => reach.solveNear(Math.abs(at(beyond).s), at(beyond).z, start)) : null;
      again = Boolean(found);
      if (found) [low, high, q] = [beyond, 1, found];
    }
    return { ...at(low), q, to };
  };

  const crossings = new Map();
  const crossing = ([i, k], [a, b]) => {
    const name = `${key(i, k)},${key(a, b)}`;
    if (!crossings.has(name)) {
      const starts = [];
      around(a, b, (x, y) => { const other = nodes.get(key(x, y)); if (other?.q && starts.length < 5) starts.push(other.q); });
      const half = (x) => (x < 0 ? -1 - x : x);
      crossings.set(name, last({ s: s(half(i)), z: z(k), q: nodes.get(key(i, k)).q }, { s: s(half(a)), z: z(b) }, starts, true));
    }
    const found = crossings.get(name);
    return i < 0 ? { ...found, s: -found.s, to: { ...found.to, s: -found.to.s } } : found;
  };

  // Each cell of the grid: the way along its reached part's boundary, and the part itself.
  const ways = new Map(), faces = [], isReached = ([i, k]) => Boolean(nodes.get(key(i, k))?.q);
  const cell = (i, k) => {
    const corners = [[i, k], [i + 1, k], [i + 1, k + 1], [i, k + 1]], part = [], ends = [];
    corners.forEach((corner, m) => {
      const next = corners[(m + 1) % 4], here = isReached(corner);
      if (here) part.push({ s: s(corner[0]), z: z(corner[1]) });
      if (here === isReached(next)) return;
      const point = here ? crossing(corner, next) : crossing(next, corner), name = [corner, next].map(String).sort().join(";");
      part.push(point);
      ends.push({ leaves: here, name, point });
    });
    ends.forEach((end, m) => { if (end.leaves) ways.set(end.name, { point: end.point, next: ends[(m + 1) % ends.length].name }); });
    for (let m = 2; m < part.length; m += 1) faces.push([part[0], part[m - 1], part[m]]);
  };
  const cellsToDo = new Set();
  nodes.forEach(({ i, k, q }) => { if (q) [0, -1].forEach((a) => [0, -1].forEach((b) => [i + a, -2 - i - a].forEach((x) => cellsToDo.add(`${x},${k + b}`)))); });
  for (const name of cellsToDo) {
    cell(...name.split(",").map(Number));
    yield;
  }

  // A point of the curve goes on where its neighbours know how.
  const further = (points, m) => {
    const { s: x, z: y, to } = points[m], far = Math.hypot(to.s - x, to.z - y), share = Math.min(1.5 * tolerance / far, 1);
    if (far < tolerance) return;
    const beyond = { s: x + share * (to.s - x), z: y + share * (to.z - y) }, starts = [1, 2, 4, -1, -2, -4].map((d) => points.at((m + d) % points.length).q);
    const q = firstOf(starts, (start) => reach.solveNear(Math.abs(beyond.s), beyond.z, start));
    if (q) points[m] = last({ ...beyond, q }, to, starts, false);
  };

  // Points between two of the curve where it bends: on the normal, towards what is not reached or back.
  const between = (a, b, depth) => {
    const ds = b.s - a.s, dz = b.z - a.z, atAxis = Math.min(Math.abs(a.s), Math.abs(b.s)) < h;
    if (depth === 0 || Math.hypot(ds, dz) < 2 * tolerance) return [];
    const part = Math.abs(a.s + b.s) < tolerance ? 0.4 : 0.5, middle = { s: a.s + part * ds, z: a.z + part * dz }; // beside the axis
    const starts = [a.q, b.q, ...(atAxis ? others(middle, a.q) : [])];
    const out = { s: middle.s + dz, z: middle.z - ds }, back = { s: middle.s - dz, z: middle.z + ds };
    const by = (at, how) => firstOf(starts, (start) => reach[how](Math.abs(at.s), at.z, start)), reached = (at) => by(at, "solve") ?? by(at, "solveNear");
    const q = reached(middle), inner = q ?? reached(back);
    if (!inner) return [];
    const [from, to] = q ? [middle, out] : [back, middle], found = last({ ...from, q: inner }, to, starts, atAxis);
    if (depth < 5 && Math.hypot(found.s - middle.s, found.z - middle.z) < tolerance) return [];
    return [...between(a, found, depth - 1), found, ...between(found, b, depth - 1)];
  };

  const loops = [];
  while (ways.size > 0) {
    const points = [];
    for (let [name] = ways.keys(); ways.has(name); ) {
      const { point, next } = ways.get(name);
      ways.delete(name);
      points.push(point);
      name = next;
    }
    for (let round = 0; round < 2; round += 1) for (let m = 0; m < points.length; m += 1) {
      further(points, m);
      yield;
    }
    const loop = [];
    for (let m = 0; m < points.length; m += 1) {
      loop.push(points[m], ...between(points[m], points[(m + 1) % points.length], 5));
      yield;
    }
    loops.push(loop);
  }
  return { loops, faces, h, tolerance, samples: shown };
}

// Whether places are more than a point or a curve: somewhere the flange gets beside the curve's direction.
function isArea(places, wide) {
  return places.some(({ bends }) => bends > 1e-9 * wide * wide);
}

function firstOf(starts, find) {
  for (const start of starts) {
    const found = find(start);
    if (found) return found;
  }
  return null;
}

// Places of random positions, the same on every page; every other one has joints at their ends.
function randomPlaces(reach, random, count) {
  return Array.from({ length: count }, (_, m) => {
    const q = Float64Array.from(reach.low, (low, i) => {
      const share = random(), atEnd = m % 2 === 1 && random() < 0.4;
      return low + (atEnd ? Math.round(share) : share) * (reach.up[i] - low);
    }), { rho, z } = reach.place(q);
    return { rho, z, q, bends: reach.bends(q) };
  });
}
