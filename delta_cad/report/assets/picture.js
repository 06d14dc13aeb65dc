"use strict";

const WIDE_DEG = 28;

// A picture of a machine in 3D on a canvas: a scene lit by a room and a sun, drawn only when asked for. Lengths in mm.
class Picture {
  constructor(canvas) {
    this.canvas = canvas;
    this.pending = false;
    const kept = { alpha: true, preserveDrawingBuffer: true, stencil: true }; // kept for print
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, ...kept });
    this.renderer.toneMapping = THREE.ACESFilmicToneMapping;
    this.renderer.toneMappingExposure = 1.15;
    this.scene = new THREE.Scene();
    const room = new THREE.PMREMGenerator(this.renderer);
    this.scene.environment = room.fromScene(new THREE.RoomEnvironment(), 0, 0.1, 100, { size: 64 }).texture;
    this.scene.add(sunlight());
    this.camera = new THREE.PerspectiveCamera(WIDE_DEG, 1, 5, 8000);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
  }

  fit() {
    const { clientWidth: w, clientHeight: h } = this.canvas;
    if (!w || !h) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(w, h, false);
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.renderer.render(this.scene, this.camera);
      this.canvas.dataset.drawn = String(Number(this.canvas.dataset.drawn ?? 0) + 1);
    });
  }
}

function sunlight() {
  const sun = new THREE.DirectionalLight(0xffffff, 1.4);
  sun.position.set(300, -500, 800);
  return sun;
}

function parsed(glb) {
  return new Promise((done, failed) => new THREE.GLTFLoader().parse(glb, "", done, failed));
}

// Parts of a model that a scene knows by name, each free of the model's tree: {node, name, known, placement}.
async function partsOf(glb, occurrences) {
  const found = [];
  (await parsed(glb)).scene.traverse((node) => {
    const name = node.userData.name ?? node.name;
    if (occurrences[name] && node.isMesh) found.push({ node, name, known: occurrences[name] });
  });
  for (const part of found) {
    part.node.updateMatrix();
    part.placement = part.node.matrix.clone();
    part.node.removeFromParent();
    part.node.matrixAutoUpdate = false;
  }
  return found;
}

// Puts a part of a model, which is in metres, where its link's frame (16 numbers, mm) has it.
function put({ node, placement }, frame) {
  const toMm = new THREE.Matrix4().makeScale(1000, 1000, 1000);
  node.matrix.copy(placement).premultiply(toMm).premultiply(new THREE.Matrix4().set(...frame));
  node.matrixWorldNeedsUpdate = true;
}
