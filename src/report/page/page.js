// The page around the scene: tables, decisions, time.
'use strict';

const fixed = (value, digits) => (value === null || value === undefined ? '' : value.toFixed(digits));
const stoneName = (index) => run.stones[index].name;

function fillTable(table, head, rows) {
  table.replaceChildren();
  const top = table.createTHead().insertRow();
  head.forEach((text) => top.appendChild(make('th', text)));
  const body = table.createTBody();
  for (const row of rows) {
    const line = body.insertRow();
    if (row.name) line.className = row.name;
    row.cells.forEach((text, i) => line.appendChild(make('td', text, row.long === i ? 'long' : '')));
    if (row.click) line.addEventListener('click', row.click);
  }
}

// Time line
const samples = [];
function addSamples(text) {
  const flat = decode(text, Float32Array), width = 11;
  for (let i = 0; i < flat.length; i += width)
    samples.push({time: flat[i], q: Array.from(flat.slice(i + 1, i + 7)), opening: flat[i + 7],
      spacing: flat[i + 8], force: flat[i + 9], holds: flat[i + 10] > 0.5});
}
let duration = 0;
function measureTime() {
  duration = Math.max(0, ...samples.slice(-1).map((s) => s.time), ...run.events.slice(-1).map((e) => e.t));
  $('time').max = duration;
}

function sampleAt(time) {
  if (!samples.length) return null;
  let low = 0, high = samples.length - 1;
  if (time >= samples[high].time) return samples[high];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (samples[middle].time <= time) low = middle; else high = middle;
  }
  const a = samples[low], b = samples[high];
  const share = b.time > a.time ? Math.min(Math.max((time - a.time) / (b.time - a.time), 0), 1) : 0;
  const mix = (x, y) => x + share * (y - x);
  return {...a, q: a.q.map((x, i) => mix(x, b.q[i])), opening: mix(a.opening, b.opening),
    spacing: mix(a.spacing, b.spacing), force: mix(a.force, b.force)};
}
const lastBefore = (list, time) => {
  let found = null;
  for (const item of list) if (item.t <= time + 1e-6) found = item;
  return found;
};

let scene = null, now = 0, playing = false;

// Stones where they were seen last; the one in the gripper moves with it, and stays where it was let go.
function placeStones(time) {
  const poses = new Map();
  const seen = lastBefore(run.views, time) || run.views[0];
  if (seen) seen.stones.forEach(([stone, pose]) => poses.set(stone, pose));
  scene.stones.forEach((mesh, stone) => {
    mesh.visible = poses.has(stone);
    if (mesh.visible) setPose(mesh, poses.get(stone));
  });
  for (const carry of run.carries) {
    if (carry.begin > time || (seen && seen.t > carry.end)) continue;
    scene.arm.move(sampleAt(Math.min(time, carry.end)));
    const T_W_O = scene.arm.tool.matrixWorld.clone().multiply(new THREE.Matrix4().compose(
        new THREE.Vector3(...carry.T_T_O.slice(0, 3)), new THREE.Quaternion(...carry.T_T_O.slice(3)),
        new THREE.Vector3(1, 1, 1)));
    const mesh = scene.stones[carry.stone];
    T_W_O.decompose(mesh.position, mesh.quaternion, new THREE.Vector3());
    mesh.visible = true;
  }
}

function show(time) {
  now = Math.min(Math.max(time, 0), duration);
  $('time').value = now;
  $('clock').textContent = `${now.toFixed(1)} s of ${duration.toFixed(1)} s`;
  const event = lastBefore(run.events, now);
  $('caption').textContent = event ? event.text : '';
  const decision = lastBefore(run.decisions, now);
  document.querySelectorAll('#decisions > li').forEach(
      (item, i) => item.classList.toggle('now', run.decisions[i] === decision));
  const cursor = document.querySelector('#forces .cursor');
  if (cursor) cursor.setAttribute('x', duration ? 1000 * now / duration : 0);
  if (!scene) return;
  placeStones(now);
  const sample = sampleAt(now);
  if (sample) scene.arm.move(sample);
  scene.showDecision(decision);
  scene.showTower(lastBefore(run.towers, now));
  scene.showView(lastBefore(run.views, now) || run.views[0]);
  scene.render();
}

function play(on) {
  playing = on;
  $('play').textContent = on ? '❚❚' : '▶';
  $('play').setAttribute('aria-label', on ? 'Pause' : 'Play');
  if (!on) return;
  if (now >= duration) show(0);
  let last = performance.now();
  const step = (stamp) => {
    if (!playing) return;
    show(now + Number($('speed').value) * (stamp - last) / 1000);
    last = stamp;
    if (now >= duration) play(false); else requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
}

function fillHead() {
  document.title = $('title').textContent = run.title;
  $('subtitle').textContent = `${run.robot}, seed ${run.seed}, stonestack ${run.version}` +
      (run.cell ? `, cell ${run.cell}` : '');
  $('facts').replaceChildren();
  const fact = (value, label, mood) => {
    const item = make('li');
    item.append(make('b', value, mood), make('span', label));
    $('facts').append(item);
  };
  fact(`${run.height} of ${run.present}`, 'stones stacked', run.height >= run.present ? 'good' : '');
  if (run.truth)
    fact(run.truth.stands ? `${run.truth.height} stand` : 'fell', `after ${run.truth.seconds} s in the true world`,
        run.truth.stands ? 'good' : 'bad');
  if (run.truth && run.truth.disagree)
    fact(run.truth.engines.map(([name, height]) => `${name} ${height}`).join(', '), 'stones stand, by engine', 'bad');
  fact(`${run.paper_height}`, 'height by the paper’s protocol');
  fact(`${fixed(run.seconds.motion, 0)} s`, 'robot time');
  fact(run.live ? 'running' : run.ended.replaceAll('_', ' '), 'end of the run');
}

const MILLIMETRES = ['joint_cover', 'off_height', 'off_axis'];
const termLabel = (term) => term.replaceAll('_', ' ') + (MILLIMETRES.includes(term) ? ' mm' : '');
const termText = (term, value) => (value !== undefined && MILLIMETRES.includes(term) ? fixed(1e3 * value, 0) : fixed(value, 2));
const choice = (c) => (c.chosen ? 'chosen' : c.why_not || (c.predicted === null ? 'ranked lower, not tried' : 'ranked lower'));

function fillDecisions() {
  for (const decision of run.decisions.slice($('decisions').childElementCount)) {  // those before stay open or shut
    const item = make('li');
    const jump = make('button', decision.title, 'jump');
    jump.type = 'button';
    jump.addEventListener('click', () => { play(false); show(decision.t); });
    item.append(jump);
    for (const line of decision.why.slice(-4)) item.append(make('p', line));
    if (decision.candidates.length) {
      const more = make('details'), table = make('table'), box = make('div', undefined, 'wide');
      more.append(make('summary', `${decision.candidates.length} placement${decision.candidates.length > 1 ? 's' : ''} compared`), box);
      box.append(table);
      const terms = decision.terms;
      fillTable(table, ['stone', 'choice', 'predicted', 'expected height', 'margin g', 'cost', ...terms.map(termLabel)],
          decision.candidates.map((c) => ({name: c.chosen ? 'chosen' : '', long: 1, cells: [stoneName(c.stone), choice(c),
            fixed(c.predicted, 2), fixed(c.expected, 2), fixed(c.margin, 3), fixed(c.cost, 2),
            ...terms.map((term) => termText(term, c.terms[term]))]})));
      item.append(more);
    }
    $('decisions').append(item);
  }
  if (!run.decisions.length && !run.live) $('decisions').append(make('li', 'No decision was made.'));
}

function fillModels() {
  const made = run.modelling;
  $('modelling').hidden = !made;
  if (!made) return;
  $('modelling-note').textContent = `${made.views} views in ${fixed(made.robot_seconds, 0)} s of the robot; surfaces ` +
    `that two views show differ by ${fixed(1e3 * made.apart_after_m, 2)} mm (median), by ` +
    `${fixed(1e3 * made.apart_before_m, 2)} mm as the arm reported its poses.`;
  fillTable($('models'), ['stone', 'mass (kg)', 'weighed', 'seen (%)', 'sigma (mm)', 'views', 'turned', 'note'],
    made.stones.map((s) => ({cells: [s.name, fixed(s.mass, 2), s.weighed ? 'yes' : 'no', fixed(100 * s.seen_share, 0),
      fixed(1e3 * s.sigma_m, 2), s.views, s.turned ? 'yes' : 'no', s.note]})));
}

function fillTables() {
  fillModels();
  const terms = run.terms;
  fillTable($('placements'), ['level', 'stone', 'outcome', 'predicted', 'cost', ...terms, 'planned (mm)',
    'measured (mm)', 'off by', 'note'], run.placements.map((p) => ({cells: [p.level || '', p.stone, p.outcome,
      fixed(p.predicted, 2), fixed(p.cost, 2), ...terms.map((term) => fixed(p.terms[term], 2)), p.planned,
      p.measured, p.off, p.note], name: p.outcome === 'placed' ? '' : 'bad'})));
  fillTable($('log'), ['s', 'event'], run.events.filter((e) => e.text).map((e) => ({cells: [fixed(e.t, 1), e.text],
    long: 1, click: () => { play(false); show(e.t); }})));
  const stages = [['detection', 'detection'], ['search', 'search'], ['planning', 'motion planning'],
    ['beside_motion', 'beside motion'], ['motion', 'robot motion']];
  const longest = Math.max(...stages.map(([key]) => run.seconds[key]), 1e-9);
  $('stages').replaceChildren();
  for (const [key, label] of stages) {
    const row = make('div', undefined, 'bar'), bar = make('i');
    bar.style.width = `${100 * run.seconds[key] / longest}%`;
    const track = make('div');
    track.append(bar);
    row.append(make('span', label), track, make('b', `${fixed(run.seconds[key], 1)} s`));
    $('stages').append(row);
  }
  $('stages').append(make('p', 'Host seconds for which the arm waited; motion in robot seconds. What ran while the ' +
      'arm moved counts as beside motion.', 'hint'));
  $('costs').innerHTML = run.figure5;
}

function fillOptions() {
  fillTable($('changed'), ['option', 'value', 'default'], run.changed.map((cells) => ({cells})));
  if (!run.changed.length) $('changed').parentElement.textContent = 'All options have their defaults.';
  $('options').textContent = run.options;
  $('footer').textContent = `stonestack ${run.version}. Catalogue ${run.catalogue}.`;
}

function fillForces() {
  const largest = Math.max(10, ...samples.map((s) => s.force));
  const points = samples.map((s) => `${(1000 * s.time / (duration || 1)).toFixed(1)},` +
      `${(50 - 46 * s.force / largest).toFixed(1)}`).join(' ');
  $('forces').innerHTML = '<svg viewBox="0 0 1000 54" preserveAspectRatio="none">' +
      `<polyline points="${points}" fill="none" stroke="currentColor" stroke-opacity=".55" ` +
      'vector-effect="non-scaling-stroke"/><rect class="cursor" width="1.5" height="54" fill="#b4632a"/></svg>';
  $('forces').title = `force at the wrist, up to ${largest.toFixed(0)} N`;
}

function fillAll() {
  measureTime();
  fillHead();
  fillDecisions();
  fillTables();
  fillForces();
}

// Messages of the live view: what to append and what to replace, and at the end all that the report holds.
let waiting = false;
function update(data, whole) {
  const atEnd = now >= duration - 1e-6, {samples: more, ...rest} = data;
  if (whole) samples.length = 0;
  addSamples(more);
  for (const [name, value] of Object.entries(rest))
    run[name] = !whole && ['views', 'towers', 'decisions', 'events'].includes(name) ? run[name].concat(value) : value;
  if (scene && rest.robot_model) scene.setArm(rest.robot_model);
  if (scene && rest.stones) scene.addStones();
  if (whole) run.live = false;
  if (whole || atEnd) now = Infinity;
  if (waiting) return;
  waiting = true;  // what comes together is drawn together
  setTimeout(() => {
    waiting = false;
    fillAll();
    show(now);
  });
}

function start() {
  addSamples(run.samples);
  fillAll();
  fillOptions();
  try {
    scene = makeScene($('view'));
  } catch (problem) {
    const text = 'This browser shows no WebGL: here is the picture of the end.';
    $('view').append(run.picture ? Object.assign(make('img'), {src: run.picture, alt: text}) : make('p', text));
    $('layers').textContent = text;
  }
  if (scene) {
    const labels = {detections: 'detections, standard deviations x 40', cloud: 'points that the camera saw', candidates: 'candidate poses', support: 'support polygon', contacts: 'contacts and forces',
      mass: 'centres of mass and thrust lines'};
    for (const [name, group] of Object.entries(scene.layers)) addLayer(name, labels[name], group, false, scene.render);
  }
  $('play').addEventListener('click', () => play(!playing));
  $('time').addEventListener('input', () => { play(false); show(Number($('time').value)); });
  window.addEventListener('keydown', (e) => {
    if (e.target !== document.body) return;
    if (e.key === ' ') { e.preventDefault(); play(!playing); }
    if (e.key === 'ArrowRight') show(now + 1);
    if (e.key === 'ArrowLeft') show(now - 1);
  });
  show(duration);
  if (run.live) followLive({add: (data) => update(data, false), end: (data) => update(data, true)});
  document.documentElement.dataset.ready = 'true';
}
start();
