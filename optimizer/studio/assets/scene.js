"use strict";

// The machine in 3D: the body in closed form of the present lengths, and the solids of the last machine. Lengths in mm.
class Scene extends Picture {
  constructor(canvas) {
    super(canvas);
    this.controls.enablePan = false;
    this.body = new THREE.Group();
    this.solids = new THREE.Group();
    this.cube = cubeOfOne();
    this.outline = rectangle();
    this.scene.add(this.body, this.solids, this.cube, this.outline);
    this.links = new Map(); // link -> group of the present body
    this.parts = []; // of the solids, as `partsOf` gives them
    this.materials = new Map();
    this.framed = 0; // size that the camera was set for
    this.shown = { body: true, solids: true, cube: true };
    this.turn = 0;
    new ResizeObserver(() => this.fit()).observe(canvas);
  }

  // The loader's own material, which surfaces of the body share with the solids.
  async begin() {
    const json = JSON.stringify({ asset: { version: "2.0" }, materials: [{ doubleSided: true }], scenes: [{}], scene: 0 });
    this.plain = await (await parsed(json)).parser.getDependency("material", 0);
  }

  material(colour) {
    if (!this.materials.has(colour)) {
      const made = this.plain.clone();
      made.color.set(colour);
      Object.assign(made, { metalness: 0.25, roughness: 0.55, side: THREE.DoubleSide });
      this.materials.set(colour, made);
    }
    return this.materials.get(colour);
  }

  // The present machine: {geometry, body, outline_mm}.
  set(answer) {
    this.present = answer;
    for (const group of this.links.values()) group.traverse((node) => node.geometry?.dispose());
    this.body.clear();
    this.links.clear();
    for (const piece of answer.body) {
      if (!this.links.has(piece.link)) {
        const group = new THREE.Group();
        group.matrixAutoUpdate = false;
        this.links.set(piece.link, group);
        this.body.add(group);
      }
      const geometry = piece.outline ? prism(piece) : sphere(piece.place, piece.radius);
      const mesh = new THREE.Mesh(geometry, this.material(piece.colour));
      if (piece.at) {
        mesh.matrixAutoUpdate = false;
        mesh.matrix.set(...piece.at);
      }
      this.links.get(piece.link).add(mesh);
    }
    const { bottom_mm: bottom, half_mm: half, centre_x_mm: x } = answer.geometry.cube;
    this.middle = [x, 0, bottom + half];
    this.half = half;
    this.cube.position.set(...this.middle);
    this.cube.scale.setScalar(2 * half);
    this.floor = Math.min(...answer.body.filter((one) => one.link === "base" && one.axis === "z").map((one) => one.ends[0]));
    // of a rectangle the long side lies along y, about the middle of what the elbows reach along x
    const [deep, wide] = [...answer.outline_mm].sort((a, b) => a - b).map((one) => one / 2);
    const { radial, outs_mm: outs, base_radius_mm: base, upper_arm_mm: arm } = answer.geometry;
    const reach = radial.map((u, k) => u[0] * (base + outs[k] + arm));
    const at = (Math.max(...reach) + Math.min(...reach)) / 2;
    const corners = [[at - deep, -wide], [at + deep, -wide], [at + deep, wide], [at - deep, wide]];
    const places = this.outline.geometry.getAttribute("position");
    places.array.set(corners.flatMap((xy) => [...xy, this.floor]));
    places.needsUpdate = true;
    this.place();
    this.frame(Math.hypot(2 * wide, 2 * deep, bottom + 2 * half - this.floor));
  }

  // Where the handle is: on its way through the cube, or in its middle.
  pose(cube) {
    const [x, y, z] = cube.middle;
    if (!this.turn) return cube.middle;
    const r = 0.8 * cube.half;
    return [x + r * Math.cos(this.turn), y + r * Math.sin(this.turn), z + r * Math.sin(2 * this.turn + 1)];
  }

  place() {
    if (this.present) {
      const springs = { springs_mm: [], pinion_mm: [0, 0], eye_inside_mm: 0 };
      const frames = Delta.links({ ...this.present.geometry, ...springs }, this.pose({ middle: this.middle, half: this.half }));
      for (const [link, group] of frames ? this.links : []) group.matrix.set(...frames[link]);
      for (const group of this.links.values()) group.matrixWorldNeedsUpdate = true;
    }
    if (this.last) {
      const { centre_x_mm: x, bottom_mm: bottom, half_mm: half } = this.last.cube;
      const middle = [x, 0, bottom + half];
      const frames = Delta.links(this.last.mechanism, this.turn ? this.pose({ middle, half }) : this.last.home_mm);
      for (const part of frames ? this.parts : []) put(part, frames[part.known[0]]);
    }
    this.draw();
  }

  // Takes the solids of a machine in place of those before, which stay until the new ones are there.
  async load(scene, glb) {
    const found = await partsOf(glb, scene.occurrences);
    clear(this.solids);
    this.last = scene;
    this.parts = found;
    for (const { node } of found) {
      node.material = node.material.clone();
      this.solids.add(node);
    }
    this.look();
    this.place();
  }

  // Solids are faint where they are not of the present lengths.
  look() {
    this.body.visible = this.shown.body;
    this.cube.visible = this.shown.cube;
    this.solids.visible = this.shown.solids;
    const faint = this.shown.body;
    for (const { node } of this.parts) {
      Object.assign(node.material, { transparent: faint, opacity: faint ? 0.18 : 1, depthWrite: !faint });
      node.material.needsUpdate = true;
    }
    this.draw();
  }

  frame(size) {
    if (this.framed && Math.abs(size / this.framed - 1) < 0.25) return;
    this.framed = size;
    this.fit();
    const narrow = Math.min(1, this.camera.aspect);
    const away = (2.15 * size) / narrow;
    const target = new THREE.Vector3(0, 0, (this.floor + this.middle[2] + this.half) / 2);
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(new THREE.Vector3(0.55, -0.78, 0.42).normalize(), away);
    this.camera.near = away / 100;
    this.camera.far = away * 10;
    this.controls.minDistance = away / 4;
    this.controls.maxDistance = away * 3;
    this.camera.updateProjectionMatrix();
    this.controls.update();
  }

  move(on) {
    cancelAnimationFrame(this.moving);
    let before = null;
    const step = (now) => {
      this.turn += before === null ? 0.001 : (now - before) / 1600;
      before = now;
      this.place();
      this.moving = requestAnimationFrame(step);
    };
    if (on) this.moving = requestAnimationFrame(step);
    else this.turn = 0;
    this.place();
  }
}

// What every answer moves is made once: a material that is made anew compiles its shader anew, for tenths of a second.
function cubeOfOne() {
  const box = new THREE.BoxGeometry(1, 1, 1);
  const faces = new THREE.MeshBasicMaterial({ color: 0x4c8df0, transparent: true, opacity: 0.1, depthWrite: false });
  const edges = new THREE.LineSegments(new THREE.EdgesGeometry(box), new THREE.LineBasicMaterial({ color: 0x1f5fbf }));
  return new THREE.Group().add(edges, new THREE.Mesh(box, faces));
}

function rectangle() {
  const places = new THREE.BufferGeometry();
  places.setAttribute("position", new THREE.Float32BufferAttribute(new Float32Array(12), 3));
  const line = new THREE.LineLoop(places, new THREE.LineBasicMaterial({ color: 0xc0392b }));
  line.frustumCulled = false;
  return line;
}

function clear(group) {
  group.traverse((node) => {
    node.geometry?.dispose();
    node.material?.dispose?.();
  });
  group.clear();
}

// Triangles with a normal of each, from corners in mm.
function mesh(triangles) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(triangles.flat(), 3));
  geometry.computeVertexNormals();
  return geometry;
}

// A prism over an outline that is star-shaped about its middle, along an axis of its own frame.
function prism({ outline, ends: [low, high], axis }) {
  const to = { x: (a, b, t) => [t, a, b], y: (a, b, t) => [a, t, b], z: (a, b, t) => [a, b, t] }[axis];
  const n = outline.length;
  const sum = outline.reduce(([a, b], [x, y]) => [a + x / n, b + y / n], [0, 0]);
  const triangles = [];
  outline.forEach(([a, b], k) => {
    const [c, d] = outline[(k + 1) % n];
    for (const t of [low, high]) triangles.push(...to(...sum, t), ...to(a, b, t), ...to(c, d, t));
    triangles.push(...to(a, b, low), ...to(c, d, low), ...to(c, d, high));
    triangles.push(...to(a, b, low), ...to(c, d, high), ...to(a, b, high));
  });
  return mesh(triangles);
}

function sphere([x, y, z], radius) {
  const at = (i, j) => {
    const [u, v] = [(2 * Math.PI * i) / 16, (Math.PI * j) / 10];
    return [x + radius * Math.sin(v) * Math.cos(u), y + radius * Math.sin(v) * Math.sin(u), z + radius * Math.cos(v)];
  };
  const triangles = [];
  for (let i = 0; i < 16; i++) {
    for (let j = 0; j < 10; j++) {
      triangles.push(...at(i, j), ...at(i, j + 1), ...at(i + 1, j + 1), ...at(i, j), ...at(i + 1, j + 1), ...at(i + 1, j));
    }
  }
  return mesh(triangles);
}
