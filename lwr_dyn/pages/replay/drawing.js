// Shapes that meshcat has no command for: paths as tubes, frames as three arrows.
// Lengths in m. Matrices are arrays of 16 numbers, column after column, as in three.js.

const THREE = MeshCat.THREE;
const AXES = ["axis-x", "axis-y", "axis-z"]; // tokens of the look
const MIN_STEP = 0.0005; // nearer points of a drawn path count as one point
const TUBE_SIDES = 8;

function jointPose(joint, value) {
  const origin = new THREE.Matrix4().fromArray(joint.origin);
  const motion = joint.kind === "revolute"
    ? new THREE.Matrix4().makeRotationZ(value)
    : new THREE.Matrix4().makeTranslation(0, 0, value);
  return origin.multiply(motion);
}

// A path through given points; `index` along it is linear in the number of points, so a tube can grow with time.
class Polyline extends THREE.Curve {
  constructor(points) {
    super();
    this.points = points;
  }

  getPointAt(u) {
    return this.points[Math.round(u * (this.points.length - 1))].clone();
  }

  getTangentAt(u) {
    const last = this.points.length - 1, i = Math.round(u * last);
    const ahead = this.points[Math.min(i + 1, last)], behind = this.points[Math.max(i - 1, 0)];
    const along = ahead.clone().sub(behind);
    return along.lengthSq() > 1e-18 ? along.normalize() : this.points[Math.min(i + 1, last)].clone().sub(this.points[i]).normalize();
  }
}

// Gives a mesh the colour of a token, now and whenever the scheme changes (`Stage.repaint`).
function painted(mesh, token) {
  mesh.userData.token = token;
  mesh.material.color.set(ink(token));
  return mesh;
}

// A tube along rows of points; `until(t)` says how many of its indices are drawn at time t.
function tube(rows, times, radius, token) {
  const points = [], kept = [];
  rows.forEach((row, i) => {
    const point = new THREE.Vector3(row[0], row[1], row[2]);
    if (points.length === 0 || point.distanceTo(points[points.length - 1]) >= MIN_STEP) {
      points.push(point);
      kept.push(times === null ? 0 : times[i]);
    }
  });
  if (points.length < 2) return null;
  const geometry = new THREE.TubeGeometry(new Polyline(points), points.length - 1, radius, TUBE_SIDES, false);
  const mesh = painted(new THREE.Mesh(geometry, new THREE.MeshPhongMaterial({ shininess: 10 })), token);
  mesh.until = (t) => {
    const reached = lastAtMost(kept, t);
    geometry.setDrawRange(0, Math.max(0, reached) * TUBE_SIDES * 6);
  };
  return mesh;
}

// Three arrows x, y, z; seen through bodies, since a joint's frame lies inside its housing.
function triad(length, radius, label) {
  const group = new THREE.Group();
  AXES.forEach((token, axis) => {
    const arrow = new THREE.Group();
    const material = new THREE.MeshBasicMaterial({ depthTest: false, transparent: true });
    const shaft = painted(new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, length * 0.8, 12), material), token);
    const head = painted(new THREE.Mesh(new THREE.ConeGeometry(radius * 2.6, length * 0.2, 16), material), token);
    shaft.position.y = length * 0.4;
    head.position.y = length * 0.9;
    arrow.add(shaft, head);
    if (axis === 0) arrow.rotation.z = -Math.PI / 2;
    if (axis === 2) arrow.rotation.x = Math.PI / 2;
    group.add(arrow);
  });
  if (label !== null) group.add(nameplate(label, length));
  group.traverse((part) => { part.renderOrder = 10; part.castShadow = false; });
  return group;
}

function nameplate(text, size) {
  const canvas = document.createElement("canvas"), pen = canvas.getContext("2d");
  canvas.width = canvas.height = 64;
  pen.font = `600 40px ${getComputedStyle(document.body).fontFamily}`;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.lineWidth = 8;
  const texture = new THREE.CanvasTexture(canvas);
  const material = new THREE.SpriteMaterial({ map: texture, depthTest: false, transparent: true });
  const sprite = new THREE.Sprite(material);
  sprite.userData.repaint = () => {
    pen.strokeStyle = ink("card");
    pen.strokeText(text, 32, 34);
    pen.fillStyle = ink("ink");
    pen.fillText(text, 32, 34);
    texture.needsUpdate = true;
  };
  sprite.userData.repaint();
  sprite.scale.setScalar(size * 0.55);
  const turn = 2.4 * Number(text); // frames at one place: their names are drawn around it
  sprite.position.set(0.4 * size * Math.cos(turn), 0.4 * size * Math.sin(turn), 0.15 * size);
  return sprite;
}
