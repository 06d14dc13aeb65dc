// What the pages take of three.js; `make three` bundles it.
export {
  ACESFilmicToneMapping, AlwaysStencilFunc, BackSide, Box3, BoxGeometry, BufferGeometry, Color,
  DecrementWrapStencilOp, DirectionalLight, DoubleSide, EdgesGeometry, Float32BufferAttribute, FrontSide, Group,
  IncrementWrapStencilOp, LineBasicMaterial, LineLoop, LineSegments, Matrix4, Mesh, MeshBasicMaterial,
  NotEqualStencilFunc, PerspectiveCamera, Plane, PlaneGeometry, PMREMGenerator, Raycaster, ReplaceStencilOp, Scene,
  Sphere, Vector2, Vector3, WebGLRenderer,
} from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
export { RoomEnvironment } from "three/addons/environments/RoomEnvironment.js";
export { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
