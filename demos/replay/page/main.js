// Assembles the page and runs it.

const $ = id => document.getElementById(id);
const speeds = [0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1, 2, 4, 8];

// The next of them from any speed on; 0, as fast as it can, is beyond them all.
function nextSpeed(now, way) {
  const rest = way > 0 ? speeds.filter(s => now && s > now) : speeds.filter(s => !now || s < now).reverse();
  return rest.length ? rest[0] : now;
}

function complain(html) {
  $('message').innerHTML = '<div>' + html + '</div>';
  $('message').hidden = false;
}

// The scale of arrows and colors, the same in all takes and frames.
function contactScale(record, size) {
  const forces = [], depths = [];
  for (const {contacts: c} of record.takes) {
    // Counts each patch once for each frame that shows it.
    const every = Math.max(1, Math.floor(c.shown.length / 20000));
    for (let k = 0; k < c.shown.length; k += every) {
      const first = c.patchPoint[c.shown[k]], end = first + c.patchCount[c.shown[k]];
      for (let i = first; i < end; ++i) {
        forces.push(forceOf(c, i));
        depths.push(depthOf(c, c.pointDepth[i]));
      }
    }
  }
  // More bodies are smaller, and so are their arrows.
  const moving = Math.max(...record.takes.map(take => take.bodies.filter(body => !body.fixed).length), 1);
  const length = Math.min(0.12, 0.2 / Math.cbrt(moving)) * size / Math.sqrt(record.takes.length);
  const force = quantile(forces, 0.9) || 1;
  return {unit: force, force, depth: quantile(depths, 0.98) || record.voxel || 1, length};
}

// Of a live view: the scale goes gently to that of the contacts of now.
function followScale(scale, contacts) {
  const forces = Array.from(contacts.pointForce, (_, i) => forceOf(contacts, i));
  const depths = Array.from(contacts.pointDepth, whole => depthOf(contacts, whole));
  const toward = (now, goal) => goal > 0 ? now + (scale.isSet ? 0.05 : 1) * (goal - now) : now;
  scale.unit = toward(scale.unit, quantile(forces, 0.9));
  scale.depth = toward(scale.depth, quantile(depths, 0.98));
  scale.isSet = scale.isSet || forces.length > 0;
}

class Player {
  constructor(seconds, show) {
    this.seconds = seconds || 1e-9;
    this.time = 0;
    this.playing = false;
    this.show = show;
    const calm = speeds.filter(s => this.seconds / s >= 6 && s <= 1);
    this.speed = this.seconds > 40 ? 2 : calm.length ? calm[calm.length - 1] : speeds[0];
  }
  seek(t) {
    this.time = Math.min(this.seconds, Math.max(0, t));
    this.show(this.time);
  }
  play(on) {
    this.playing = on;
    if (on && this.time >= this.seconds) this.seek(0);
    $('play').setAttribute('aria-pressed', on);
    $('play').setAttribute('aria-label', on ? 'Pause' : 'Play');
    $('play').innerHTML = on ? '&#10074;&#10074;' : '&#9654;';
  }
  tick(passed) {
    if (!this.playing) return;
    this.seek(this.time + passed * this.speed);
    if (this.time >= this.seconds) this.play(false);
  }
}

function wireTimeline(player, record) {
  for (const s of speeds) element('option', s + '\u00d7', $('speed')).value = s;
  $('speed').value = player.speed;
  $('speed').onchange = () => { player.speed = Number($('speed').value); };
  $('play').onclick = () => player.play(!player.playing);
  $('scrub').max = record.seconds;
  $('scrub').step = record.seconds / 10000;
  $('scrub').oninput = () => player.seek(Number($('scrub').value));
  const times = record.takes[0].figures.time;
  const step = count => {
    player.play(false);
    player.seek(times[Math.min(times.length - 1, Math.max(0, indexAt(times, player.time + 1e-9) + count))]);
  };
  const faster = way => {
    $('speed').value = player.speed = nextSpeed(player.speed, way);
  };
  return {
    ' ': () => player.play(!player.playing), ArrowLeft: e => step(e.shiftKey ? -10 : -1), ArrowRight: e => step(e.shiftKey ? 10 : 1),
    Home: () => player.seek(0), End: () => player.seek(record.seconds), ArrowUp: () => faster(1), ArrowDown: () => faster(-1)
  };
}

function wireKeys(actions) {
  document.addEventListener('keydown', event => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.matches('#cut-at, #arrows')) return;
    const own = event.target.closest('select, button');
    if (own && (event.key === ' ' || event.key === 'Enter' || own.tagName === 'SELECT')) return;
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action) return;
    event.preventDefault();
    action(event);
  });
}

const pressed = id => $(id).getAttribute('aria-pressed') === 'true';

function toggle(id, changed) {
  const act = () => {
    $(id).setAttribute('aria-pressed', !pressed(id));
    changed(pressed(id));
  };
  $(id).onclick = act;
  return act;
}

function wireCut(stage, changed) {
  let axis = 'y', flipped = false;
  const apply = () => {
    stage.cut(pressed('cut'), axis, Number($('cut-at').value), flipped);
    $('cutting').hidden = !pressed('cut');
    changed();
  };
  const buttons = document.querySelectorAll('#cutting [data-axis]');
  for (const button of buttons)
    button.onclick = () => {
      axis = button.dataset.axis;
      for (const b of buttons) b.setAttribute('aria-checked', b === button);
      apply();
    };
  $('cut-at').oninput = apply;
  $('cut-flip').onclick = () => { flipped = !flipped; apply(); };
  return toggle('cut', apply);
}

function addLabels(record, stage) {
  if (record.takes.length < 2) return () => {};
  const labels = record.takes.map((take, i) => {
    const label = element('span', take.label, $('labels'));
    label.style.color = takeColors[i % 6];
    return label;
  });
  return () => {
    const placed = [];
    record.takes.forEach((take, i) => {
      const middle = [(take.startLow[0] + take.startHigh[0]) / 2, take.startLow[1], take.startLow[2]];
      const [x, y] = stage.onScreen(take, middle);
      labels[i].style.left = x + 'px';
      // Moves overlapping labels down by a line.
      const half = labels[i].offsetWidth / 2, high = labels[i].offsetHeight;
      let top = y;
      for (const other of placed)
        if (Math.abs(other.x - x) < other.half + half + 4 && Math.abs(other.top - top) < high) top = other.top + high;
      labels[i].style.top = top + 'px';
      placed.push({x, half, top});
    });
  };
}

// Bodies, contacts and everything else that changes with time, drawn by WebGL.
async function buildStage(record) {
  const stage = new Stage($('view'), record);
  const buffer = await inflated('replay-gltf');
  const gltf = await new Promise((resolve, reject) => new THREE.GLTFLoader().parse(buffer, '', resolve, reject));
  const motion = await Motion.of(gltf);
  stage.scene.add(gltf.scene);
  // The loader adds children as they become ready, so use the order in the file.
  const {nodes, scenes} = gltf.parser.json, rootNumber = scenes[0].nodes[0];
  const nodeOf = number => gltf.parser.getDependency('node', number);
  const root = await nodeOf(rootNumber);
  const views = await Promise.all(record.takes.map((take, t) => Promise.all(take.bodies.map(async (body, b) =>
    new BodyView(body, await nodeOf(nodes[nodes[rootNumber].children[t]].children[b]), stage.planes)))));
  for (const view of views.flat()) if (!view.body.plane) stage.addSection(view.section);
  const takeNodes = await Promise.all(nodes[rootNumber].children.map(nodeOf));
  const scale = contactScale(record, stage.size);
  const upright = new THREE.Group();
  upright.quaternion.copy(root.quaternion);
  stage.overlay.add(upright);
  const contacts = record.takes.map(take => {
    const group = new THREE.Group();
    group.position.fromArray(take.offset);
    upright.add(group);
    return new ContactView(take, group, scale);
  });
  return {stage, motion, views, contacts, scale, upright, takeNodes};
}

function wireStage(record, built, player) {
  const {stage, motion, views, contacts, scale} = built;
  const showBody = view => {
    view.show(view.state, view.asVoxels, pressed('cut'), record.shells);
    view.stateButton.textContent = view.state;
    if (view.body.clouds.length) view.voxelButton.textContent = view.asVoxels ? 'voxels' : 'mesh';
    stage.changed = true;
  };
  const all = views.flat(), showAll = () => all.forEach(showBody);
  fillBodies(record, views, showBody);
  const showScale = fillLegend(record, scale);
  const arrows = () => {
    scale.force = scale.unit / 2 ** Number($('arrows').value);
    showScale();
  };
  $('arrows').oninput = () => { arrows(); player.seek(player.time); };
  arrows();
  const placeLabels = addLabels(record, stage);
  const showContacts = () => { stage.overlay.visible = pressed('contacts'); $('legend').hidden = !pressed('contacts'); stage.changed = true; };
  const keys = {
    c: toggle('contacts', showContacts),
    x: wireCut(stage, showAll),
    f: toggle('fade', on => { all.forEach(v => { if (!v.body.plane) v.state = on ? 'faded' : 'solid'; }); showAll(); }),
    v: toggle('voxels', on => { all.forEach(v => { v.asVoxels = on; }); showAll(); }),
    r: () => stage.home()
  };
  $('home').onclick = keys.r;
  showAll();
  const resize = () => { stage.resize(); stage.controls.update(); };
  new ResizeObserver(resize).observe($('stage'));
  resize();
  stage.home();
  const show = t => {
    motion.show(t);
    for (const view of all) showMass(view, t);
    let points = 0, patches = 0;
    for (const view of contacts) {
      const counts = view.show(record.live ? 0 : indexAt(view.take.figures.time, t));
      points += counts.points;
      patches += counts.patches;
    }
    write($('contact-words'), points + (points === 1 ? ' point in ' : ' points in ') + patches + (patches === 1 ? ' patch' : ' patches') +
      '. An arrow is the force on the moving body, friction with it; a disc is a patch, its pin the normal.');
    stage.changed = true;
  };
  const view = {show, keys, draw: () => { if (stage.draw()) placeLabels(); }};
  if (!record.live) return view;
  const live = wireLiveStage(player, built, {
    show, renewed: showBody, rescale: contacts => { followScale(scale, contacts); arrows(); },
    addView(added) {
      for (const list of [views[0], all]) list.push(added);
      stage.addSection(added.section);
      fillBody(added, showBody);
    }
  });
  return {...view, ...live, keys: {...keys, ...live.keys}, draw() {
    live.hand.tick();
    if (stage.changed) ++player.pictures;
    view.draw();
  }};
}

async function main() {
  document.documentElement.dataset.whole = '';
  $('message').hidden = true;
  const more = () => { const open = $('panel').classList.toggle('open'); $('more').setAttribute('aria-expanded', open); };
  $('more').onclick = more;
  $('view').addEventListener('pointerdown', () => { $('panel').classList.remove('open'); $('more').setAttribute('aria-expanded', false); });
  if (typeof DecompressionStream === 'undefined')
    return complain('This browser is too old for this page: it cannot unpack the replay. Any browser since 2023 can.');
  const record = readRecord(await inflated('replay-record'));
  fillStory(record);
  let view = {show() {}, draw() {}, keys: {}};
  if (record.live) document.documentElement.dataset.live = '';
  const player = record.live ? new Live(record) : new Player(record.seconds, t => {
    view.show(t);
    graphs.show(t);
    $('scrub').value = t;
    const digits = record.seconds < 10 ? 3 : 2;
    $('clock').textContent = t.toFixed(digits) + ' / ' + record.seconds.toFixed(digits) + ' s';
  });
  const graphs = new Graphs($('graphs'), record, t => player.seek(t));
  const keys = record.live ? wireLiveTimeline(player) : wireTimeline(player, record);
  if (document.createElement('canvas').getContext('webgl')) {
    view = wireStage(record, await buildStage(record), player);
  } else {
    for (const section of document.querySelectorAll('.drawn')) section.hidden = true;
    complain('<b>This browser draws no WebGL here.</b><br>The bodies cannot be shown; the figures below can. Turn on hardware ' +
      'acceleration, try another browser, or open the same motion as glTF (--replay OUT.glb) in Blender.');
  }
  if (record.live) Object.assign(player, {graphs, view: 'moment' in view ? view : null});
  wireKeys({...keys, ...view.keys});
  const resize = () => { graphs.draw(); graphs.show(player.time); };
  new ResizeObserver(resize).observe($('graphs'));
  resize();
  player.seek(0);
  let last = performance.now();
  const tick = now => {
    player.tick((now - last) / 1000);
    last = now;
    view.draw();
    requestAnimationFrame(tick);
  };
  view.draw();
  requestAnimationFrame(tick);
  document.documentElement.dataset.ready = Math.round(performance.now());
}

main().catch(error => {
  console.error(error);
  complain('This replay could not be opened: ' + String(error.message || error).replace(/</g, '&lt;'));
});
