// An assembly in three dimensions with its contacts and forces. Uses THREE, makeOrbit and makeArrow of scene.js,
// and `assembly`: blocks {name, support, moving, p, f}, contacts {p, force} in metres, text.
'use strict';

function showAssembly(element) {
  const renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
  renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
  element.appendChild(renderer.domElement);
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0xdde4ec);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x8a8078, 0.9));
  const sun = new THREE.DirectionalLight(0xfff2dd, 0.5);
  sun.position.set(0.5, -1.4, 2.0);
  scene.add(sun);
  for (const block of assembly.blocks) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(block.p), 3));
    geometry.setIndex(block.f);
    const solid = geometry.toNonIndexed();
    solid.computeVertexNormals();
    scene.add(new THREE.Mesh(solid, new THREE.MeshStandardMaterial({
      color: block.moving ? 0xd98a3d : block.support ? 0x6d7278 : 0xb8ad99, transparent: true, opacity: 0.35,
      depthWrite: false, side: THREE.DoubleSide, flatShading: true})));
    scene.add(new THREE.LineSegments(new THREE.EdgesGeometry(solid, 20),
        new THREE.LineBasicMaterial({color: 0x3a352e, transparent: true, opacity: 0.6})));
  }
  for (const contact of assembly.contacts) {
    const point = new THREE.Vector3(...contact.p);
    const ball = new THREE.Mesh(new THREE.SphereBufferGeometry(0.003, 12, 8),
        new THREE.MeshBasicMaterial({color: 0x1d5fa8}));
    ball.position.copy(point);
    scene.add(ball);
    const force = new THREE.Vector3(...contact.force);
    if (force.length() > 0.002) scene.add(makeArrow(point, force, 0xd0342c));
  }
  const camera = new THREE.PerspectiveCamera(38, 1, 0.02, 20);
  camera.up.set(0, 0, 1);
  const target = new THREE.Vector3(0, 0, assembly.height / 2);
  camera.position.set(0.45, -1.15, target.z + 0.35);
  const render = () => renderer.render(scene, camera);
  makeOrbit(camera, renderer.domElement, target, render);
  const resize = () => {
    renderer.setSize(element.clientWidth, element.clientHeight, false);
    camera.aspect = element.clientWidth / element.clientHeight;
    camera.updateProjectionMatrix();
    render();
  };
  window.addEventListener('resize', resize);
  resize();
}

document.getElementById('text').textContent = assembly.text;
try {
  showAssembly(document.getElementById('view'));
} catch (error) {
  document.getElementById('view').textContent = 'This browser shows no WebGL: ' + error.message;
}
