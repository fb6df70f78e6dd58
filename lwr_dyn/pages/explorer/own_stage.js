// The scene tree that stage.js draws into, on our own bundle of three.js: what it asks of meshcat's viewer, no more.
// Nodes are named by their path; z is up in the tree, y in the camera's frame. Drawn only when something has changed.

const MeshCat = (() => {
  const THREE = lwrThree;
  THREE.ColorManagement.enabled = false; // the look's colours are shown as they are

  const parts = (path) => (typeof path === "string" ? path.split("/").filter((name) => name !== "") : path);

  class Tree {
    constructor(object) {
      this.object = object;
      this.children = {};
    }

    find(path) {
      return parts(path).reduce((node, name) => {
        if (!node.children[name]) {
          node.children[name] = new Tree(new THREE.Group());
          node.object.add(node.children[name].object);
        }
        return node.children[name];
      }, this);
    }

    drop(path) {
      const names = parts(path), last = names[names.length - 1], parent = this.find(names.slice(0, -1)), node = parent.children[last];
      if (!node) return;
      parent.object.remove(node.object);
      delete parent.children[last];
    }
  }

  // A cylinder as the page's data have it (arms_shown.py): the only shape of a drawn arm.
  const cylinder = (matrix, [top, bottom, height, sides], [color, specular, shininess], token) => {
    const mesh = new THREE.Mesh(new THREE.CylinderGeometry(top, bottom, height, sides), new THREE.MeshPhongMaterial({ color, specular, shininess }));
    new THREE.Matrix4().fromArray(matrix).decompose(mesh.position, mesh.quaternion, mesh.scale);
    mesh.userData = { token };
    mesh.castShadow = mesh.receiveShadow = true;
    return mesh;
  };

  class Viewer {
    constructor(pane) {
      Object.assign(this, { pane, dirty: true, sky: ["transparent", "transparent"] });
      this.renderer = this.#renderer(); // null without WebGL: everything but the picture works
      this.canvas = this.renderer?.domElement ?? document.createElement("canvas");
      if (this.renderer) pane.append(this.canvas);
      else pane.append(Object.assign(document.createElement("p"), { id: "no-webgl", textContent: "This browser draws no WebGL: the arm is not shown. The numbers, sliders and tables work." }));
      this.scene = new THREE.Group();
      this.scene.rotation.x = -Math.PI / 2;
      this.world = new THREE.Scene(); // y up: the arm's scene, and handles that face the camera
      this.world.add(this.scene);
      this.scene_tree = new Tree(this.scene);
      this.camera = new THREE.PerspectiveCamera(32, 1, 0.02, 60);
      this.#lights();
      new ResizeObserver(() => this.set_3d_pane_size()).observe(pane);
      const draw = () => { this.draw(); requestAnimationFrame(draw); };
      requestAnimationFrame(draw);
    }

    #renderer() {
      try {
        const renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true });
        renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
        renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
        renderer.shadowMap.enabled = true;
        return renderer;
      } catch {
        return null;
      }
    }

    #lights() {
      this.scene_tree.find("Lights/AmbientLight").object.add(new THREE.AmbientLight(0xffffff, 0.55 * Math.PI));
      [-1, 1].forEach((side) => {
        const light = new THREE.PointLight(0xffffff, 0.28 * Math.PI, 0, 0);
        light.position.set(side * 1.5, 1.2 * side, 2);
        this.scene_tree.find(`Lights/Point${side}`).object.add(light);
      });
    }

    draw() {
      if (!this.dirty || !this.renderer) return;
      this.dirty = false;
      this.renderer.render(this.world, this.camera);
    }

    // What is drawn over the scene, in the camera's frame.
    set overlay(object) {
      this.world.add(object);
    }

    set_dirty() {
      this.dirty = true;
    }

    // A point of the window in the camera's picture, -1 to 1 to the right and up.
    picturePoint(x, y) {
      const { left, top, width, height } = this.canvas.getBoundingClientRect();
      return new THREE.Vector2((2 * (x - left)) / width - 1, 1 - (2 * (y - top)) / height);
    }

    // A link's transform, or a cylinder on it.
    handle_command([run, link, matrix, ...shape]) {
      const path = ["arms", `run_${run}`, ...Array.from({ length: link + 1 }, (_, k) => `link_${k}`)];
      if (shape.length === 0) this.set_transform(path, matrix);
      else this.set_object([...path, `shape_${(this.shapes = (this.shapes ?? 0) + 1)}`], cylinder(matrix, ...shape));
    }

    set_object(path, object) {
      const node = this.scene_tree.find(path);
      if (node.shown) node.object.remove(node.shown);
      if (object.isDirectionalLight) object.intensity *= Math.PI;
      node.shown = object;
      node.object.add(object);
      this.set_dirty();
    }

    set_transform(path, matrix) {
      const { object } = this.scene_tree.find(path);
      new THREE.Matrix4().fromArray(matrix).decompose(object.position, object.quaternion, object.scale);
      this.set_dirty();
    }

    // Visible or not; the sky's two colours. Other properties belong to meshcat's own lights.
    set_property(path, property, value) {
      if (property === "visible") this.scene_tree.find(path).object.visible = value;
      if (property === "top_color" || property === "bottom_color") {
        this.sky[property === "top_color" ? 0 : 1] = `#${new THREE.Color(...value).getHexString()}`;
        this.pane.style.background = `linear-gradient(${this.sky.join(", ")})`;
      }
      this.set_dirty();
    }

    delete_path(path) {
      this.scene_tree.drop(path);
      this.set_dirty();
    }

    set_camera(camera) {
      this.camera = camera;
      this.world.add(camera); // out of the tree, which is turned
      this.controls = new THREE.OrbitControls(camera, this.canvas);
      this.controls.addEventListener("change", () => this.set_dirty());
    }

    set_3d_pane_size() {
      const { clientWidth: width, clientHeight: height } = this.pane;
      if (width === 0 || height === 0) return;
      this.renderer?.setSize(width, height);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
      this.set_dirty();
    }
  }

  return { THREE, Viewer };
})();
