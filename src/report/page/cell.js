// The page of a cell before anything moves: arm, obstacles, limits, reach and camera in 3-D, findings, numbers. Uses
// THREE, makeScene and makeArm of scene.js, and `run`, the data of the page.
'use strict';

const COLOURS = {obstacles: '#b3584c', workspace: '#2f7d4f', fence: '#b3382c', reach: '#2f6db3', camera: '#c77f1a'};
const NAME_HEIGHT = 0.03;  // at a distance of 1
const linearColour = (colour) => new THREE.Color(colour).convertSRGBToLinear();
const vectors = (points) => points.map((p) => new THREE.Vector3(...p));
const lineOf = (points, colour, loop) => new (loop ? THREE.LineLoop : THREE.LineSegments)(
    new THREE.BufferGeometry().setFromPoints(points), new THREE.LineBasicMaterial({color: linearColour(colour)}));

function patch(points, colour, opacity) {
  const geometry = new THREE.BufferGeometry().setFromPoints(points);
  geometry.setIndex(Array.from({length: points.length - 2}, (_, i) => [0, i + 1, i + 2]).flat());
  return new THREE.Mesh(geometry, new THREE.MeshBasicMaterial(
      {color: linearColour(colour), transparent: true, opacity, side: THREE.DoubleSide, depthWrite: false}));
}

// A name that faces the viewer, drawn over what stands before it.
function makeName(text, place) {
  const canvas = document.createElement('canvas'), pen = canvas.getContext('2d'), font = '600 44px system-ui, sans-serif';
  pen.font = font;
  canvas.width = Math.ceil(pen.measureText(text).width) + 32;
  canvas.height = 64;
  pen.fillStyle = 'rgba(255, 255, 255, .82)';
  pen.fillRect(0, 0, canvas.width, canvas.height);
  pen.font = font;
  pen.fillStyle = '#23262b';
  pen.fillText(text, 16, 47);
  const texture = new THREE.CanvasTexture(canvas);
  texture.minFilter = THREE.LinearFilter;
  const name = new THREE.Sprite(new THREE.SpriteMaterial({map: texture, fog: false, sizeAttenuation: false}));
  name.scale.set(NAME_HEIGHT * canvas.width / canvas.height, NAME_HEIGHT, 1);
  name.position.set(...place);
  return name;
}

function makeObstacle(obstacle) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(obstacle.vertices), 3));
  geometry.setIndex(obstacle.faces);
  const solid = geometry.toNonIndexed();
  solid.computeVertexNormals();
  const mesh = new THREE.Mesh(solid, new THREE.MeshStandardMaterial(
      {color: linearColour(COLOURS.obstacles), transparent: true, opacity: 0.55, roughness: 0.9, flatShading: true, side: THREE.DoubleSide}));
  mesh.castShadow = true;
  mesh.add(new THREE.LineSegments(new THREE.EdgesGeometry(solid, 20), new THREE.LineBasicMaterial({color: 0x5c2a23})));
  return mesh;
}

function makeLimits(box, colour) {
  const size = box.max.map((high, i) => high - box.min[i]);
  const geometry = new THREE.BoxBufferGeometry(...size), group = new THREE.Group();
  group.add(new THREE.LineSegments(new THREE.EdgesGeometry(geometry), new THREE.LineBasicMaterial({color: linearColour(colour)})));
  group.add(new THREE.Mesh(geometry, new THREE.MeshBasicMaterial(
      {color: linearColour(colour), transparent: true, opacity: 0.05, side: THREE.DoubleSide, depthWrite: false})));
  group.position.set(...box.min.map((low, i) => low + size[i] / 2));
  return group;
}

// Camera, the edges of what it sees, and the part of the table in its image.
function drawCamera(group, pose) {
  if (!pose.seen.length) return;
  const eye = new THREE.Vector3(...pose.T_W_C.slice(0, 3)), corners = vectors(pose.seen);
  group.add(lineOf(corners.flatMap((corner) => [eye, corner]), COLOURS.camera));
  const onTable = corners.map((p) => new THREE.Vector3(p.x, p.y, p.z + 0.002));
  group.add(lineOf(onTable, COLOURS.camera, true), patch(onTable, COLOURS.camera, 0.25));
}

function drawReach(group) {
  const flat = (points, z) => points.map(([x, y]) => new THREE.Vector3(x, y, z));
  group.add(lineOf(flat(run.reach, 0.003), COLOURS.reach, true), lineOf(flat(run.too_near, 0.003), COLOURS.reach, true));
  const outer = flat(run.reach, 0.001), inner = flat(run.too_near, 0.001), count = outer.length;
  const geometry = new THREE.BufferGeometry().setFromPoints([...outer, ...inner]);
  geometry.setIndex(outer.flatMap((_, i) => {
    const next = (i + 1) % count;
    return [i, next, count + i, next, count + next, count + i];
  }));
  group.add(new THREE.Mesh(geometry, new THREE.MeshBasicMaterial(
      {color: linearColour(COLOURS.reach), transparent: true, opacity: 0.12, side: THREE.DoubleSide, depthWrite: false})));
}

function drawNames(group) {
  const [fx, fy] = run.field.centre, [sx, sy] = run.field.size;
  const names = [['field', [fx - sx / 2, fy, 0.03]], ['site', [...run.site, 0.06]], ['base', run.base]];
  for (const obstacle of run.obstacles) names.push([obstacle.name, obstacle.top]);
  for (const [text, place] of names) {
    const name = makeName(text, place);
    name.renderOrder = 11;
    name.material.depthTest = false;
    group.add(name);
  }
}

// The axes of W at its origin: x red, y green, z blue.
function drawAxes(group) {
  [[1, 0, 0, 0xd0342c], [0, 1, 0, 0x2f9a4f], [0, 0, 1, 0x2f6db3]].forEach(([x, y, z, colour]) => group.add(
      new THREE.ArrowHelper(new THREE.Vector3(x, y, z), new THREE.Vector3(0, 0, 0.002), 0.35, linearColour(colour), 0.05, 0.025)));
}

function makeCell() {
  const view = {...run.view};
  const {clientWidth, clientHeight} = $('view'), narrow = Math.max(1, 1.5 * clientHeight / clientWidth);
  view.eye = view.eye.map((x, i) => view.target[i] + narrow * (x - view.target[i]));
  const away = Math.hypot(...view.eye.map((x, i) => x - view.target[i]));
  Object.assign(view, {table: [...view.target.slice(0, 2), 20, 20], fog: [1.5 * away, 3 * away]});
  const scene = makeScene($('view'), view);
  const layers = {};
  for (const name of ['obstacles', 'workspace', 'fence', 'reach', 'camera', 'names', 'axes'])
    scene.root.add(layers[name] = new THREE.Group());
  run.obstacles.forEach((obstacle) => layers.obstacles.add(makeObstacle(obstacle)));
  if (run.workspace) layers.workspace.add(makeLimits(run.workspace, COLOURS.workspace));
  if (run.fence) layers.fence.add(makeLimits(run.fence, COLOURS.fence));
  drawReach(layers.reach);
  drawNames(layers.names);
  const axes = new THREE.Group();
  drawAxes(axes);
  scene.addOnTop(layers.axes, axes);
  const show = (pose) => {
    scene.arm.move({q: pose.q, opening: run.opening, spacing: run.robot_model.spacing});
    scene.clear(layers.camera);
    drawCamera(layers.camera, pose);
    $('caption').textContent = `${pose.name}: joints ${pose.q.map((q) => (180 / Math.PI * q).toFixed(1)).join(', ')}°`;
    scene.render();
  };
  const labels = {obstacles: 'obstacles', workspace: 'workspace of the tool tip', fence: 'fence of the whole arm',
    reach: 'reach, gripper down', camera: 'what the camera sees', names: 'names', axes: 'axes of W'};
  addLayer('arm', 'arm and gripper', scene.arm.base, true, scene.render);
  for (const [name, group] of Object.entries(layers))
    if (group.children.length || (name === 'camera' && run.has_camera))
      addLayer(name, labels[name], group, true, scene.render, COLOURS[name]);
  return {...scene, layers, show};
}

function fillPoses(show) {
  run.poses.forEach((pose, i) => {
    const label = make('label'), box = make('input');
    Object.assign(box, {type: 'radio', name: 'pose', id: `pose-${i}`, checked: i === 0});
    box.addEventListener('change', () => show(pose));
    label.append(box, ` ${pose.name}`);
    $('poses').append(label);
  });
}

function fillText() {
  document.title = $('title').textContent = run.title;
  $('subtitle').textContent = run.subtitle;
  for (const [value, label, mood] of run.facts) {
    const item = make('li');
    item.append(make('b', value, mood), make('span', label));
    $('facts').append(item);
  }
  const order = ['bad', 'note', 'good'];  // what is wrong comes first
  for (const finding of [...run.findings].sort((a, b) => order.indexOf(a.mood) - order.indexOf(b.mood))) {
    const item = make('li', undefined, finding.mood);
    item.append(make('b', `${finding.device}, ${finding.step}`), make('p', finding.text));
    $('findings').append(item);
  }
  const table = $('numbers'), top = table.createTHead().insertRow(), body = table.createTBody();
  ['what', 'value', 'from'].forEach((text) => top.append(make('th', text)));
  for (const [name, value, origin] of run.numbers) {
    const row = body.insertRow();
    row.append(make('td', name), make('td', value, 'long'), make('td', origin));
  }
  $('footer').textContent = 'Drawn from the cell file alone: nothing was connected, nothing moved. Compare it with the real cell.';
}

let cell = null;
fillText();
try {
  cell = makeCell();
} catch (problem) {
  const text = 'This browser shows no WebGL: here is a picture of the start.';
  $('view').append(run.picture ? Object.assign(make('img'), {src: run.picture, alt: text}) : make('p', text));
  $('layers').textContent = text;
}
if (cell) {
  fillPoses(cell.show);
  cell.show(run.poses[0]);
}
document.documentElement.dataset.ready = 'true';
