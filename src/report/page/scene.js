// The cell in three dimensions: arm, gripper, stones, layers. Uses THREE and `run`, the data of the report.
'use strict';

const decode = (text, Type) => {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Type(bytes.buffer);
};

// A pose is [x, y, z, qx, qy, qz, qw].
const setPose = (object, pose) => {
  object.position.set(pose[0], pose[1], pose[2]);
  object.quaternion.set(pose[3], pose[4], pose[5], pose[6]);
  object.updateMatrixWorld(true);
};

const STONE_COLOURS = [0xb8ad99, 0x9e9991, 0xb39980, 0x949ca1, 0xc2b8ac, 0x998a78, 0xa9a291, 0xbba58f];

// A stone's mesh with faceted shading and a little grain, so that its edges are seen.
function makeStone(stone, index) {
  const shared = decode(stone.vertices, Float32Array);
  const faces = decode(stone.faces, Uint16Array);
  const position = new Float32Array(faces.length * 3);
  const colour = new Float32Array(faces.length * 3);
  const base = new THREE.Color(STONE_COLOURS[index % STONE_COLOURS.length]).convertSRGBToLinear();
  for (let corner = 0; corner < faces.length; ++corner) {
    const grain = 0.94 + 0.12 * Math.abs(Math.sin(12.9898 * Math.floor(corner / 3) + 78.233 * index));
    for (let axis = 0; axis < 3; ++axis) position[3 * corner + axis] = shared[3 * faces[corner] + axis];
    colour.set([base.r * grain, base.g * grain, base.b * grain], 3 * corner);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(position, 3));
  geometry.setAttribute('color', new THREE.BufferAttribute(colour, 3));
  geometry.computeVertexNormals();
  const mesh = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial(
      {vertexColors: THREE.VertexColors, roughness: 0.95, metalness: 0, flatShading: true}));
  mesh.castShadow = mesh.receiveShadow = true;
  const edges = new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 32),
      new THREE.LineBasicMaterial({color: 0x3a352e, transparent: true, opacity: 0.35}));
  mesh.add(edges);
  return mesh;
}

// A surface of revolution: its profile lists distance along the axis and radius.
function makeLathe(shape, material) {
  const lathe = new THREE.Mesh(new THREE.LatheGeometry(
      shape.profile.map(([along, radius]) => new THREE.Vector2(Math.max(radius, 1e-5), along)), 48), material);
  lathe.position.set(...shape.p);
  lathe.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...shape.axis));
  lathe.castShadow = lathe.receiveShadow = true;
  return lathe;
}

// Links as nested groups: each joint turns about its own z.
function makeArm(robot) {
  const base = new THREE.Group();
  setPose(base, robot.T_W_R);
  const grey = new THREE.MeshStandardMaterial({color: 0xc3c9d0, roughness: 0.4, metalness: 0.1, side: THREE.DoubleSide});
  const blue = new THREE.MeshStandardMaterial({color: 0x5f9fd0, roughness: 0.4, metalness: 0.1, side: THREE.DoubleSide});
  const dark = new THREE.MeshStandardMaterial({color: 0x33373d, roughness: 0.6, metalness: 0.3});
  const links = [base], joints = [];
  for (const pose of robot.T_parent_joint) {
    const mount = new THREE.Group(), joint = new THREE.Group();
    setPose(mount, pose);
    mount.add(joint);
    links[links.length - 1].add(mount);
    links.push(joint);
    joints.push(joint);
  }
  robot.shapes.forEach((shape) => links[shape.link].add(makeLathe(shape, shape.lid ? blue : grey)));
  const flange = new THREE.Group(), tool = new THREE.Group();
  setPose(flange, robot.T_6_F);
  setPose(tool, robot.T_F_T);
  flange.add(tool);
  links[6].add(flange);
  const boxes = robot.boxes.map((box) => {
    const mesh = new THREE.Mesh(new THREE.BoxGeometry(...box.size), box.camera ? grey : dark);
    mesh.castShadow = mesh.receiveShadow = true;
    tool.add(mesh);
    return {mesh, box};
  });
  const advance = (opening) => {
    const at = Math.min(Math.max(opening / robot.reach_step, 0), robot.reach.length - 1), k = Math.floor(at);
    const next = robot.reach[Math.min(k + 1, robot.reach.length - 1)];
    return robot.reach[k] + (at - k) * (next - robot.reach[k]);
  };
  const move = (sample) => {
    joints.forEach((joint, i) => { joint.rotation.z = sample.q[i]; });
    for (const {mesh, box} of boxes)
      mesh.position.set(box.centre[0] + box.side * sample.opening / 2, box.centre[1] +
          box.spread * (sample.spacing - robot.spacing), box.centre[2] + box.advance * advance(sample.opening));
    base.updateMatrixWorld(true);
  };
  return {base, tool, move};
}

function makeArrow(from, vector, colour) {
  const length = Math.max(vector.length(), 0.005);
  return new THREE.ArrowHelper(vector.clone().normalize(), from, length, colour, Math.min(0.012, 0.4 * length),
      Math.min(0.007, 0.25 * length));
}

// Orbit with the mouse or a finger: drag turns, wheel and pinch zoom, right button or Shift moves the target.
function makeOrbit(camera, element, target, changed) {
  const pointers = new Map();
  const offset = new THREE.Spherical().setFromVector3(fromWorld(camera.position.clone().sub(target)));
  function fromWorld(v) { return new THREE.Vector3(v.y, v.z, v.x); }
  const apply = () => {
    offset.phi = Math.min(Math.max(offset.phi, 0.05), 1.65);
    offset.radius = Math.min(Math.max(offset.radius, 0.15), 8);
    const v = new THREE.Vector3().setFromSpherical(offset);
    camera.position.set(target.x + v.z, target.y + v.x, target.z + v.y);
    camera.lookAt(target);
    changed();
  };
  const pan = (dx, dy) => {
    const scale = offset.radius / element.clientHeight;
    const right = new THREE.Vector3().setFromMatrixColumn(camera.matrix, 0);
    const up = new THREE.Vector3().setFromMatrixColumn(camera.matrix, 1);
    target.addScaledVector(right, -dx * scale).addScaledVector(up, dy * scale);
  };
  element.style.touchAction = 'none';
  element.addEventListener('contextmenu', (e) => e.preventDefault());
  element.addEventListener('pointerdown', (e) => {
    pointers.set(e.pointerId, e);
    element.setPointerCapture(e.pointerId);
  });
  const drop = (e) => pointers.delete(e.pointerId);
  element.addEventListener('pointerup', drop);
  element.addEventListener('pointercancel', drop);
  element.addEventListener('pointermove', (e) => {
    const last = pointers.get(e.pointerId);
    if (!last) return;
    const dx = e.clientX - last.clientX, dy = e.clientY - last.clientY;
    if (pointers.size === 2) {
      const other = [...pointers.values()].find((p) => p.pointerId !== e.pointerId);
      const spread = (p) => Math.hypot(p.clientX - other.clientX, p.clientY - other.clientY);
      offset.radius *= spread(last) / Math.max(spread(e), 1);
      pan(dx / 2, dy / 2);
    } else if (e.buttons & 2 || e.shiftKey) {
      pan(dx, dy);
    } else {
      offset.theta -= 0.007 * dx;
      offset.phi -= 0.007 * dy;
    }
    pointers.set(e.pointerId, e);
    apply();
  });
  element.addEventListener('wheel', (e) => {
    e.preventDefault();
    offset.radius *= Math.exp(0.001 * e.deltaY);
    apply();
  }, {passive: false});
  apply();
}

const RUN_VIEW = {eye: [1.75, -1.15, 0.85], target: [0.5, 0.1, 0.24], table: [0.5, 0.05, 2.6, 2.2], fog: [3, 7]};

// Draws `run` into an element, seen from `view`: eye and target, middle and size of the table, begin and end of the fog
// [m]. Throws where the browser has no WebGL.
function makeScene(element, view = RUN_VIEW) {
  const renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
  renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = THREE.PCFSoftShadowMap;
  renderer.gammaOutput = true;
  renderer.gammaFactor = 2.2;
  element.appendChild(renderer.domElement);
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0xdde4ec);
  scene.fog = new THREE.Fog(0xdde4ec, view.fog[0], view.fog[1]);
  scene.add(new THREE.HemisphereLight(0xe8eefc, 0x8a8078, 0.5));
  const sun = new THREE.DirectionalLight(0xfff2dd, 0.62);
  sun.position.set(0.1, -1.4, 2.4);
  sun.target.position.set(0.6, 0.1, 0);
  sun.castShadow = true;
  sun.shadow.mapSize.set(2048, 2048);
  sun.shadow.bias = -0.0006;
  Object.assign(sun.shadow.camera, {left: -1.1, right: 1.1, top: 1.1, bottom: -1.1, near: 0.5, far: 5});
  scene.add(sun, sun.target);

  // Colours are given in sRGB, light is added in linear space.
  const linear = (material) => { material.color.convertSRGBToLinear(); return material; };
  const table = new THREE.Mesh(new THREE.PlaneBufferGeometry(view.table[2], view.table[3]),
      linear(new THREE.MeshStandardMaterial({color: 0x9a9ea4, roughness: 0.9, metalness: 0})));
  table.position.set(view.table[0], view.table[1], -0.0005);
  table.receiveShadow = true;
  scene.add(table);
  const [cx, cy] = run.field.centre, [sx, sy] = run.field.size;
  const outline = [[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]].map(
      ([x, y]) => new THREE.Vector3(cx + x * sx / 2, cy + y * sy / 2, 0.0005));
  scene.add(new THREE.Line(new THREE.BufferGeometry().setFromPoints(outline),
      new THREE.LineBasicMaterial({color: 0xf4f6f8})));
  const site = new THREE.Mesh(new THREE.RingBufferGeometry(0.012, 0.016, 40),
      new THREE.MeshBasicMaterial({color: 0xb4632a}));
  site.position.set(run.site[0], run.site[1], 0.0008);
  scene.add(site);

  let arm = makeArm(run.robot_model);
  scene.add(arm.base);
  const stones = [];
  const addStones = () => run.stones.slice(stones.length).forEach((entry) => {
    const stone = makeStone(entry, stones.length);
    stone.visible = false;
    stones.push(stone);
    scene.add(stone);
  });
  addStones();

  // Layers: groups that are shown or hidden, filled for a moment in time.
  const layers = {};
  for (const name of ['detections', 'cloud', 'candidates', 'support', 'contacts', 'mass']) scene.add(layers[name] = new THREE.Group());
  // Drawn last and through what stands before it.
  const addOnTop = (group, object) => {
    object.traverse((part) => {
      part.renderOrder = 10;
      if (part.material) Object.assign(part.material, {transparent: true, depthTest: false});
    });
    group.add(object);
  };
  const clear = (group) => {
    while (group.children.length) group.remove(group.children[0]);
  };
  const showDecision = (decision) => {
    clear(layers.candidates);
    clear(layers.support);
    if (!decision) return;
    decision.candidates.forEach((candidate, rank) => {
      const ghost = new THREE.Mesh(stones[candidate.stone].geometry, new THREE.MeshBasicMaterial(
          {color: candidate.chosen ? 0x2f7d4f : 0x3c6fa8, transparent: true, depthWrite: false,
            opacity: candidate.chosen ? 0.42 : 0.16}));
      setPose(ghost, candidate.T_W_O);
      layers.candidates.add(ghost);
      if (!candidate.support.length || !candidate.chosen) return;
      const corners = candidate.support.map((p) => new THREE.Vector3(...p));
      addOnTop(layers.support, new THREE.LineLoop(new THREE.BufferGeometry().setFromPoints(corners),
          new THREE.LineBasicMaterial({color: 0xd0342c})));
    });
  };
  // Contact points and forces of the tower or wall as it came to rest, and the thrust lines through them.
  const showTower = (moment) => {
    clear(layers.contacts);
    clear(layers.mass);
    if (!moment) return;
    for (const contact of moment.contacts) {
      const point = new THREE.Vector3(...contact.p);
      const ball = new THREE.Mesh(new THREE.SphereBufferGeometry(0.0025, 12, 8),
          new THREE.MeshBasicMaterial({color: 0xd0342c}));
      ball.position.copy(point);
      addOnTop(layers.contacts, ball);
      const force = new THREE.Vector3(...contact.f);
      if (force.length() > 0.01) addOnTop(layers.contacts, makeArrow(point, force.multiplyScalar(0.004), 0xd0342c));
    }
    for (const centre of moment.centres) {
      const ball = new THREE.Mesh(new THREE.SphereBufferGeometry(0.005, 16, 12),
          new THREE.MeshBasicMaterial({color: 0x1d5fa8}));
      ball.position.set(...centre);
      addOnTop(layers.mass, ball);
    }
    if (moment.thrust.length)
      addOnTop(layers.mass, new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(
          moment.thrust.flat().map((p) => new THREE.Vector3(...p))),
      new THREE.LineBasicMaterial({color: 0x1d5fa8})));
  };

  // Stones as they were seen last: ellipsoids of one standard deviation, enlarged, and the points of the camera.
  let viewShown = null;
  const showView = (view) => {
    if (view === viewShown) return;
    viewShown = view;
    clear(layers.detections);
    clear(layers.cloud);
    if (!view) return;
    view.stones.forEach(([stone, pose], i) => {
      const [x, y, z, turn] = view.sigmas[i];
      const outline = new THREE.LineSegments(new THREE.EdgesGeometry(stones[stone].geometry, 40),
          new THREE.LineBasicMaterial({color: 0x7a3fa8}));
      setPose(outline, pose);
      addOnTop(layers.detections, outline);
      if (!(x + y + z > 0)) return;
      const ball = new THREE.Mesh(new THREE.SphereBufferGeometry(1, 20, 14),
          new THREE.MeshBasicMaterial({color: 0x7a3fa8, opacity: 0.5}));
      ball.position.set(pose[0], pose[1], pose[2]);
      ball.scale.set(Math.max(0.04 * x, 1e-4), Math.max(0.04 * y, 1e-4), Math.max(0.04 * z, 1e-4));
      ball.userData = {stone, sigma: [x, y, z], turn};
      addOnTop(layers.detections, ball);
    });
    const millimetres = decode(view.cloud, Int16Array);
    const points = new THREE.BufferGeometry();
    points.setAttribute('position', new THREE.BufferAttribute(Float32Array.from(millimetres, (v) => 1e-3 * v), 3));
    layers.cloud.add(new THREE.Points(points,
        new THREE.PointsMaterial({color: 0x1d7a8a, size: 2.5, sizeAttenuation: false})));
  };

  const camera = new THREE.PerspectiveCamera(38, 1, 0.02, 20);
  camera.up.set(0, 0, 1);
  camera.position.set(...view.eye);
  const target = new THREE.Vector3(...view.target);
  const render = () => renderer.render(scene, camera);
  makeOrbit(camera, renderer.domElement, target, render);
  const resize = () => {
    const {clientWidth: w, clientHeight: h} = element;
    renderer.setSize(w, h, false);
    camera.aspect = w / h;
    camera.updateProjectionMatrix();
    render();
  };
  window.addEventListener('resize', resize);
  resize();
  const setArm = (model) => {
    scene.remove(arm.base);
    arm = makeArm(model);
    scene.add(arm.base);
  };
  return {get arm() { return arm; }, setArm, addStones, stones, layers, showDecision, showTower, showView, render, addOnTop, clear, root: scene, element: renderer.domElement};
}
