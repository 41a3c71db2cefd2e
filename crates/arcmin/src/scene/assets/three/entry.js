// What is taken of three.js 0.187. `node build.mjs` beside it writes three.min.js (needs npm packages three@0.187, esbuild).
export {
  Scene, PerspectiveCamera, WebGLRenderer, Group, Mesh, LineSegments, InstancedMesh, BufferGeometry, BufferAttribute,
  ExtrudeGeometry, CylinderGeometry, SphereGeometry, ConeGeometry, PlaneGeometry, Shape, Path, MeshLambertMaterial, MeshBasicMaterial, LineBasicMaterial,
  EdgesGeometry, HemisphereLight, DirectionalLight, AmbientLight, Color, Vector2, Vector3, Matrix4, Quaternion, Plane, Raycaster, Box3, DoubleSide, FrontSide
} from 'three';
export { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
