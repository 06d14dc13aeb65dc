"use strict";

const ISO = [0.5, -0.78, 0.42]; // towards who looks
const NARROW_DEG = 0.5; // of the views along an axis: nearly parallel, so that lengths compare at whatever depth they are
const FILLED = 0.94; // share of the picture that the machine takes

// The model in 3D: poses, exploded view, section, names. Lengths in mm, z up; a picture is drawn only when asked for.
class Viewer extends Picture {
  constructor(canvas, data, glb) {
    super(canvas);
    this.data = data;
    this.parts = []; // {node, name, link, part, move: Vector3, placement: Matrix4, surfaces}
    this.apart = 0;
    this.pose = data.home_mm;
    this.plane = new THREE.Plane(new THREE.Vector3(0, 0, -1), 0);
    this.cutting = ["", 0]; // axis and share, as `cut` takes them
    this.caps = new THREE.Group();
    this.counters = counters(this.plane); // materials of the caps, made once: one made anew compiles its shader anew
    this.coats = new Map(); // number of a part -> material of its cap
    this.square = new THREE.PlaneGeometry(1, 1);
    this.shown = { cube: true, outline: true };
    this.renderer.localClippingEnabled = true;
    this.controls.addEventListener("change", () => this.clip());
    this.model = new THREE.Group();
    this.scene.add(this.model, this.caps);
    this.cube = this.lines(boxEdges(2 * data.cube.half_mm), 0x2f6fd0);
    this.cube.position.set(data.cube.centre_x_mm, 0, data.cube.bottom_mm + data.cube.half_mm);
    this.scene.add(this.cube);
    this.handle = new THREE.LineSegments(crossOf(7), new THREE.LineBasicMaterial({ color: 0xd05a10, depthTest: false }));
    this.handle.renderOrder = 2;
    this.scene.add(this.handle);
    this.ready = this.load(glb);
  }

  async load(glb) {
    const materials = new Map(); // parts of one material share one, until one is marked
    for (const { node, name, known: [link, part, move], placement } of await partsOf(glb, this.data.occurrences)) {
      if (!materials.has(node.material)) materials.set(node.material, this.surfaces(node.material));
      const surfaces = materials.get(node.material);
      node.material = surfaces.outer;
      this.parts.push({ node, name, link, part, placement, surfaces, move: new THREE.Vector3(...move) });
      this.model.add(node);
    }
    this.place();
    this.box = new THREE.Box3().setFromObject(this.model);
    this.box.union(new THREE.Box3().setFromObject(this.cube));
    const { centre_mm: [x, y], size_mm: [w, d] } = this.data.outline;
    this.outline = this.lines(rectangle(x, y, w, d, this.box.min.z), 0xc0392b, true);
    // what stays in the picture wherever the machine is moved: arms over the rectangle, about as high as the cube's
    // floor, and the knob over the cube
    const { half_mm: half, bottom_mm: bottom, centre_x_mm: middle } = this.data.cube;
    const over = this.box.max.z - bottom - half;
    const arms = new THREE.Box3().setFromObject(this.outline).expandByPoint(new THREE.Vector3(x, y, bottom));
    const knob = new THREE.Box3(
      new THREE.Vector3(middle - half, -half, bottom), new THREE.Vector3(middle + half, half, bottom + 2 * half + over),
    );
    this.reach = [...cornersOf(arms), ...cornersOf(knob)];
    this.scene.add(this.outline);
  }

  surfaces(material) {
    const outer = material.clone();
    const marked = outer.clone();
    marked.color.set(0xff7a1a);
    marked.emissive.set(0xb03a00);
    const faint = outer.clone();
    Object.assign(faint, { transparent: true, opacity: 0.14, depthWrite: false });
    return { outer, marked, faint };
  }

  lines(geometry, color, loop = false) {
    const material = new THREE.LineBasicMaterial({ color });
    return loop ? new THREE.LineLoop(geometry, material) : new THREE.LineSegments(geometry, material);
  }

  // Puts every part where the pose and the exploded view have it; false out of reach, where nothing moves.
  place(pose = this.pose) {
    const links = Delta.links(this.data.mechanism, pose);
    if (!links) return false;
    this.pose = pose;
    for (const part of this.parts) {
      put(part, links[part.link]);
      part.move.toArray().forEach((mm, k) => (part.node.matrix.elements[12 + k] += this.apart * mm));
    }
    this.handle.position.set(...pose);
    this.cut(...this.cutting);
    return true;
  }

  explode(share) {
    this.apart = share;
    this.handle.visible = share === 0;
    for (const name of Object.keys(this.shown)) this.show(name, this.shown[name]);
    this.place();
  }

  // Shows or hides "cube" or "outline"; of a machine that is apart neither means anything.
  show(name, shown) {
    this.shown[name] = shown;
    if (this[name]) this[name].visible = shown && this.apart === 0;
    this.draw();
  }

  // A section across an axis ("x", "y", "z", or "" for none), at -1 to 1 of the machine's half along it; its place.
  cut(axis, share) {
    const was = this.cutting[0];
    this.cutting = [axis, share];
    if (axis !== was) {
      const planes = axis ? [this.plane] : [];
      for (const material of new Set(this.parts.flatMap(({ surfaces }) => Object.values(surfaces)))) {
        material.clippingPlanes = planes;
        material.needsUpdate = true;
      }
    }
    this.caps.clear();
    this.draw();
    if (!axis) return undefined;
    const k = "xyz".indexOf(axis);
    const box = this.apart ? new THREE.Box3().setFromObject(this.model) : this.box;
    const [low, high] = [box.min.getComponent(k), box.max.getComponent(k)];
    // 0.05 mm off: many faces lie in the machine's own planes of symmetry
    const at = (low + high) / 2 + (share * (high - low)) / 2 + 0.05;
    const sense = k === 1 ? 1 : -1; // what is nearer to who looks goes
    this.plane.normal.set(0, 0, 0).setComponent(k, sense);
    this.plane.constant = -sense * at;
    this.parts.forEach((part, n) => this.cap(part, n, k, at));
    return at;
  }

  // Closes a part where the section cuts it: what has more of its back than of its front behind is inside it.
  cap({ node, surfaces }, n, k, at) {
    const box = new THREE.Box3().setFromObject(node);
    if (at <= box.min.getComponent(k) || at >= box.max.getComponent(k)) return;
    this.counters.forEach((material, turn) => {
      const count = new THREE.Mesh(node.geometry, material);
      count.matrixAutoUpdate = false;
      count.matrix.copy(node.matrix);
      count.renderOrder = 10 + 3 * n + turn;
      this.caps.add(count);
    });
    if (!this.coats.has(n)) this.coats.set(n, coat(surfaces.outer.color, n));
    const face = new THREE.Mesh(this.square, this.coats.get(n));
    const size = box.getSize(new THREE.Vector3());
    box.getCenter(face.position).setComponent(k, at);
    if (k === 0) face.rotation.set(0, Math.PI / 2, 0);
    if (k === 1) face.rotation.set(Math.PI / 2, 0, 0);
    face.scale.set(k === 0 ? size.z : size.x, k === 2 ? size.y : k === 1 ? size.z : size.y, 1).multiplyScalar(1.01);
    face.renderOrder = 12 + 3 * n;
    face.onAfterRender = (renderer) => renderer.clearStencil();
    this.caps.add(face);
  }

  // Draws parts, each by itself as it stands in the machine, one after the other into small canvases.
  // faces: canvas -> part numbers' indices, of one thing that may be drawn in pieces.
  portraits(faces) {
    const scene = new THREE.Scene();
    scene.environment = this.scene.environment;
    const sun = sunlight();
    const camera = new THREE.PerspectiveCamera(20, 1, 0.1, 10000);
    camera.up.set(0, 0, 1);
    this.renderer.setPixelRatio(1);
    for (const [canvas, pieces] of faces) {
      const shown = new THREE.Group();
      for (const piece of pieces) {
        const { node, surfaces } = this.parts.find(({ part }) => part === piece);
        const own = new THREE.Mesh(node.geometry, surfaces.outer);
        own.matrixAutoUpdate = false;
        own.matrix.copy(node.matrix);
        shown.add(own);
      }
      scene.clear();
      scene.add(shown, sun);
      shown.updateMatrixWorld(true);
      const box = new THREE.Box3().setFromObject(shown);
      const { center, radius } = box.getBoundingSphere(new THREE.Sphere());
      camera.aspect = canvas.width / canvas.height;
      camera.position.copy(center).addScaledVector(new THREE.Vector3(...ISO).normalize(), 6 * radius);
      camera.lookAt(center);
      camera.updateMatrixWorld();
      camera.zoom = 1;
      camera.updateProjectionMatrix();
      const seen = cornersOf(box).map((corner) => corner.project(camera));
      camera.zoom = 0.96 / Math.max(...seen.flatMap(({ x, y }) => [Math.abs(x), Math.abs(y)]));
      camera.updateProjectionMatrix();
      this.renderer.setSize(canvas.width, canvas.height, false);
      this.renderer.render(scene, camera);
      canvas.getContext("2d").drawImage(this.canvas, 0, 0);
    }
    this.fit();
  }

  // Brings out some parts among the others, which become faint; none of them: all are as they were.
  mark(chosen) {
    const marked = new Set(this.parts.filter(chosen));
    for (const one of this.parts) {
      const { outer, faint } = one.surfaces;
      one.node.material = marked.has(one) ? one.surfaces.marked : marked.size ? faint : outer;
    }
    this.draw();
  }

  look(view) {
    const towards = { iso: ISO, front: [0, -1, 0.0001], side: [1, 0, 0.0001], top: [0, -0.0001, 1] }[view];
    const points = this.apart > 0 ? this.parts.flatMap(({ node }) => cornersOf(new THREE.Box3().setFromObject(node))) : this.reach;
    const to = new THREE.Vector3(...towards).normalize();
    this.camera.fov = view === "iso" ? WIDE_DEG : NARROW_DEG;
    const [centre, away] = this.framed(points, to);
    this.size = new THREE.Box3().setFromPoints(points).getSize(new THREE.Vector3()).length();
    this.controls.maxDistance = 4 * away;
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(to, away);
    this.controls.update();
    this.clip();
    this.draw();
  }

  // Keeps the depths that are drawn about the machine, however far away who looks is.
  clip() {
    const away = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = Math.max(away / 200, away - 2 * this.size);
    this.camera.far = away + 4 * this.size;
    this.camera.updateProjectionMatrix();
  }

  // Where to look, and from how far, so that points fill the picture, seen from a direction.
  framed(points, to) {
    const right = new THREE.Vector3().crossVectors(this.camera.up, to).normalize();
    const up = new THREE.Vector3().crossVectors(to, right);
    const half = FILLED * Math.tan((this.camera.fov * Math.PI) / 360);
    const axes = [[right, half * this.camera.aspect], [up, half]];
    const sides = axes.flatMap(([axis, slope]) => [axis, axis.clone().negate()].map((side) => [side, slope]));
    // a point p is inside a side of the picture if (p - c).side <= slope (away - (p - c).to): the tightest of each side
    const [r, l, t, b] = sides.map(([side, slope]) => Math.max(...points.map((p) => p.dot(side) + slope * p.dot(to))));
    const [wide, high] = [(r + l) / 2 / (half * this.camera.aspect), (t + b) / 2 / half];
    const centre = right.multiplyScalar((r - l) / 2).addScaledVector(up, (t - b) / 2);
    const middle = new THREE.Box3().setFromPoints(points).getCenter(new THREE.Vector3()).dot(to);
    return [centre.addScaledVector(to, middle), Math.max(wide, high) - middle];
  }

  // Where an event's pointer is on the canvas, in pixels from its corner.
  pixel(event) {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  // The line of sight through a point of the canvas.
  ray(x, y) {
    const { clientWidth: w, clientHeight: h } = this.canvas;
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2((2 * x) / w - 1, 1 - (2 * y) / h), this.camera);
    return ray;
  }

  // The part under a point of the canvas, and where the line of sight meets it; null for none.
  hit(x, y) {
    const visible = (hit) => !this.cutting[0] || this.plane.distanceToPoint(hit.point) >= 0;
    const found = this.ray(x, y).intersectObjects(this.parts.map((one) => one.node), false).find(visible);
    return found ? { part: this.parts.find((one) => one.node === found.object), point: found.point } : null;
  }
}

// What counts the surfaces behind a section: backs up, fronts down.
function counters(plane) {
  const counted = { colorWrite: false, depthWrite: false, depthTest: false, stencilWrite: true };
  const ways = [[THREE.BackSide, THREE.IncrementWrapStencilOp], [THREE.FrontSide, THREE.DecrementWrapStencilOp]];
  return ways.map(([side, op]) => {
    const ops = { stencilFunc: THREE.AlwaysStencilFunc, stencilFail: op, stencilZFail: op, stencilZPass: op };
    return new THREE.MeshBasicMaterial({ ...counted, ...ops, side, clippingPlanes: [plane] });
  });
}

function coat(colour, n) {
  const shade = 0.35 + 0.3 * ((n * 0.618) % 1); // neighbours of one material are told apart
  const replace = THREE.ReplaceStencilOp;
  return new THREE.MeshBasicMaterial({
    color: colour.clone().lerp(new THREE.Color(0xe0812a), shade), side: THREE.DoubleSide, toneMapped: false,
    stencilWrite: true, stencilRef: 0, stencilFunc: THREE.NotEqualStencilFunc,
    stencilFail: replace, stencilZFail: replace, stencilZPass: replace,
  });
}

function cornersOf(box) {
  const corner = (k) => new THREE.Vector3(...[0, 1, 2].map((a) => box[k & (1 << a) ? "max" : "min"].getComponent(a)));
  return [...Array(8).keys()].map(corner);
}

function boxEdges(side) {
  return new THREE.EdgesGeometry(new THREE.BoxGeometry(side, side, side));
}

function crossOf(half) {
  const ends = [-half, 0, 0, half, 0, 0, 0, -half, 0, 0, half, 0, 0, 0, -half, 0, 0, half];
  return new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(ends, 3));
}

function rectangle(x, y, w, d, z) {
  const [a, b] = [w / 2, d / 2];
  const corners = [x - a, y - b, z, x + a, y - b, z, x + a, y + b, z, x - a, y + b, z];
  return new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(corners, 3));
}
