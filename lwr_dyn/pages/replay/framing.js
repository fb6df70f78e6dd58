// Framing: which points of the arms and their paths a picture has to hold, and where the camera holds all of them.
// Lengths in m, z up; the camera's direction is given, its distance and its place across that direction follow.

const FILL = 0.88; // of the free part of the pane that the points take, in the direction that is tighter
const SAMPLES = 24; // poses of the motion whose bodies are held
const FRAME_SIZE = 0.13, TARGET_SIZE = 0.1; // of a link's drawn frame, and of the frame at the desired pose

// Corners of the bodies of each link, in the link's own frame: an octagon around each rim of a cylinder.
function bodyCorners(stage, run) {
  stage.scene().updateMatrixWorld(true);
  return run.chain.map((path, k) => {
    const node = stage.node(path), next = run.chain[k + 1] ? stage.node(run.chain[k + 1]) : null, points = [];
    const own = node.matrixWorld.clone().invert();
    const walk = (part) => {
      if (part === next || part.userData.added) return;
      if (part.isMesh && part.renderOrder === 0) points.push(...rims(part.geometry, own.clone().multiply(part.matrixWorld)));
      part.children.forEach(walk);
    };
    walk(node);
    return points;
  });
}

function rims(geometry, pose) {
  geometry.computeBoundingBox();
  const middle = geometry.boundingBox.getCenter(new THREE.Vector3()), half = geometry.boundingBox.getSize(new THREE.Vector3()).multiplyScalar(0.5);
  const around = Array.from({ length: 8 }, (_, k) => ((k + 0.5) * Math.PI) / 4), out = 1 / Math.cos(Math.PI / 8);
  return around.flatMap((angle) => [-1, 1].map((end) =>
    new THREE.Vector3(out * Math.cos(angle), end, out * Math.sin(angle)).multiply(half).add(middle).applyMatrix4(pose)));
}

// What must be seen of a run, in the frame of its root: bodies over the whole motion, paths, target frames, the floor below.
function runOutline(stage, run) {
  const { record, n } = run, points = [], corners = bodyCorners(stage, run), last = run.t.length - 1;
  const isStill = stage.stills.includes(run); // it shows the frames of its links
  const add = (x, y, z) => points.push(new THREE.Vector3(x, y, z));
  const seen = (what) => stage.node(run.root.concat(what)).visible, hasTarget = seen("target");
  [...run.reference, ...(seen("trace") ? run.trace : [])].forEach(([x, y, z]) => add(x, y, z));
  [[-0.1, 0], [0.1, 0], [0, -0.1], [0, 0.1]].forEach(([x, y]) => add(x, y, record.floor));
  const axes = (pose, size) => [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((axis) => points.push(new THREE.Vector3(...axis).multiplyScalar(size).applyMatrix4(pose)));
  for (let s = 0; s <= SAMPLES; s += 1) {
    const k = Math.round((s / SAMPLES) * last), pose = new THREE.Matrix4(), wanted = new THREE.Matrix4();
    corners.forEach((own, link) => {
      if (link > 0 && link <= n) {
        pose.multiply(jointPose(record.joints[link - 1], run.q[k * n + link - 1]));
        wanted.multiply(jointPose(record.joints[link - 1], run.qRef[k * n + link - 1]));
      } else if (link > n) [pose, wanted].forEach((each) => each.multiply(run.flange));
      own.forEach((point) => points.push(point.clone().applyMatrix4(pose)));
      if (isStill) axes(pose, FRAME_SIZE);
    });
    if (hasTarget) axes(wanted, TARGET_SIZE);
    if (last === 0) break;
  }
  return points;
}

// How far each run is moved along `right`, so that they stand beside each other without touching, about the middle.
function besideEachOther(outlines, right) {
  const spans = outlines.map((points) => {
    const along = points.map((point) => point.dot(right));
    return along.reduce(([low, high], x) => [Math.min(low, x), Math.max(high, x)], [Infinity, -Infinity]);
  });
  const whole = spans.reduce((sum, [low, high]) => sum + high - low, 0), gap = (0.12 * whole) / spans.length;
  let from = -(whole + gap * (spans.length - 1)) / 2;
  return spans.map(([low, high]) => {
    const off = from - low;
    from += high - low + gap;
    return off;
  });
}

// The nearest eye that looks against `out` and sees all points within the slopes to the right and up, in the middle of
// each: a point p is within a slope s where |(p - eye).right| <= s (eye - p).out, so the sums of both sides' bounds decide.
function nearestEye(points, { out, right, up }, slopes) {
  const bounds = [right, up].map((axis, i) => [1, -1].map((sign) =>
    points.reduce((most, p) => Math.max(most, sign * p.dot(axis) + slopes[i] * p.dot(out)), -Infinity)));
  const ahead = points.reduce((most, p) => Math.max(most, p.dot(out)), -Infinity);
  const depth = Math.max(ahead + 0.1, ...bounds.map(([a, b], i) => (a + b) / (2 * slopes[i])));
  const [across, height] = bounds.map(([a, b]) => (a - b) / 2);
  const eye = [[out, depth], [right, across], [up, height]].reduce((sum, [axis, x]) => sum.addScaledVector(axis, x), new THREE.Vector3());
  const middle = new THREE.Box3().setFromPoints(points).getCenter(new THREE.Vector3());
  return { eye, target: eye.clone().addScaledVector(out, middle.dot(out) - depth), depth };
}
