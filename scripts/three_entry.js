// What the explorer takes of three.js: esbuild leaves out the rest (scripts/build_three.py).
export {
  AmbientLight, ArrowHelper, Box3, BoxGeometry, BufferAttribute, BufferGeometry, CanvasTexture, Color, ColorManagement, ConeGeometry, Curve,
  CylinderGeometry, DirectionalLight, DoubleSide, Euler, Float32BufferAttribute, GridHelper, Group, Line, LineBasicMaterial, LineLoop,
  LineSegments, LinearSRGBColorSpace, Matrix3, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial, MeshPhongMaterial, Object3D,
  PerspectiveCamera, Plane, PlaneGeometry, PointLight, Points, PointsMaterial, Quaternion, Ray, Raycaster, REVISION, RingGeometry, Scene,
  ShadowMaterial, SphereGeometry, Sprite, SpriteMaterial, TubeGeometry, Vector2, Vector3, WebGLRenderer,
} from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
export { TransformControls } from "three/examples/jsm/controls/TransformControls.js";
