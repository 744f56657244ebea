// What the page uses of three.js 0.187.0; bundled with esbuild 0.28.2 into three.min.js:
//   esbuild three.entry.js --bundle --minify --format=iife --global-name=THREE --legal-comments=none --target=es2020 --outfile=three.min.js
export { WebGLRenderer, Scene, PerspectiveCamera, HemisphereLight, DirectionalLight, BufferGeometry, BufferAttribute, Mesh, InstancedMesh, MeshLambertMaterial, LineBasicMaterial, LineSegments, Color, Plane, Vector3, Vector2, Box3, Raycaster, Matrix4, Quaternion, DoubleSide, CylinderGeometry, MathUtils } from 'three';
export { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
