// A page that shows a world while it runs (demos/view): what it hears, and what it asks for.

class Feed {
  constructor(heard, closed) {
    const address = new URL('feed', location.href);
    address.protocol = 'ws:';
    this.socket = new WebSocket(address);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onmessage = event => heard(readRecord(event.data));
    this.socket.onclose = closed;
  }
  ask(command) { if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(command)); }
}

// The figures of the graphs: all of a run, thinned as it grows.
class Figures {
  constructor(take) {
    this.keys = ['time', 'kinetic', 'potential', 'spring', 'deepest', 'narrowPhase'];
    for (const key of this.keys) take.figures[key] = [];
    this.of = take.figures;
    this.every = this.turn = 0;
  }
  add(moment) {
    const {time} = this.of;
    if (!moment.steps || (time.length && moment.time <= time[time.length - 1]) || ++this.turn < this.every) return;
    this.turn = 0;
    for (const key of this.keys) this.of[key].push(key === 'narrowPhase' ? moment.narrowPhase / moment.steps : moment[key]);
    if (time.length < 2000) return;
    for (const key of this.keys) this.of[key] = this.of[key].filter((_, i) => i % 2 === 0);
    this.every = 2 * Math.max(1, this.every);
  }
}

// In the place of Player: the simulation is what plays.
class Live {
  constructor(record) {
    Object.assign(this, {record, time: 0, running: true, ended: false, sayings: null, pictures: 0, moment: null, pending: new Map()});
    this.figures = new Figures(record.takes[0]);
    this.view = null;  // wireStage()'s
    this.graphs = null;
    this.drawn = this.counted = performance.now();
    this.counting = this.turns = this.worded = 0;
    this.stale = false;  // the words are older than the moment
    this.feed = new Feed(message => this.hear(message), () => this.end());
  }

  ask(command) { this.feed.ask(command); }
  play(on) { this.ask({do: on ? 'run' : 'pause'}); }
  seek() { if (this.view && this.moment) this.view.show(this.time); }

  end() {
    if (this.ended) return;
    const told = this.moment && this.moment.ended, why = told && this.moment.why;
    const words = why ? 'The simulation has failed: ' + why + '.' : told ? 'The simulation has ended.' : 'The connection to the simulation is lost.';
    this.ended = true;
    this.running = false;
    if (pressed('carve')) $('carve').click();
    for (const id of ['play', 'step', 'speed', 'carve']) $(id).disabled = true;
    this.showPlay(told ? 'ended' : 'not connected');
    write($('live-words'), words);
    this.say(words, Infinity);
  }

  showPlay(word) {
    $('play').setAttribute('aria-pressed', this.running);
    $('play').setAttribute('aria-label', this.running ? 'Pause' : 'Play');
    write($('play'), this.running ? '\u275a\u275a' : '\u25b6');
    write($('pace'), word);
  }

  say(words, seconds) {
    $('hint').textContent = words;
    $('hint').hidden = false;
    clearTimeout(this.hiding);
    if (seconds < Infinity) this.hiding = setTimeout(() => { $('hint').hidden = true; }, 1000 * seconds);
  }

  // Of several messages between two pictures the latest counts.
  hear(message) {
    if ('surface' in message) {
      this.pending.set(message.surface, message);
      return;
    }
    this.figures.add(message);
    this.moment = message;
    this.isNew = true;
  }

  tick() {
    if (this.view) for (const [body, message] of this.pending) this.view.surface(body, message);
    if (this.view) this.pending.clear();
    if (this.isNew) this.tell(this.moment);
    const now = performance.now();
    if (this.graphs && this.isNew && now - this.drawn > 250) {
      this.graphs.renew(this.record);
      this.graphs.show(this.time);
      this.drawn = now;
    }
    if (this.stale && now - this.worded > 100) this.words(this.moment);
    this.isNew = false;
    ++this.turns;
    this.count(now);
  }

  tell(moment) {
    this.time = moment.time;
    if (!this.ended) this.running = moment.running;
    this.record.takes[0].contacts = moment.contacts;
    if (this.view) this.view.moment(moment);
    this.stale = true;
    if (this.sayings !== null && moment.sayings > this.sayings) this.say(moment.said, 5);
    this.sayings = moment.sayings;
    if (moment.ended) this.end();
  }

  // As often as one can read.
  words(moment) {
    this.stale = false;
    this.worded = performance.now();
    if (!this.ended) this.showPlay(moment.running ? moment.factor.toFixed(2) + '\u00d7 real time' : 'paused');
    if (document.activeElement !== $('speed')) showSpeed(moment.speed);
    write($('clock'), moment.time.toFixed(3) + ' s');
    write($('pull-words'), moment.pulls.map(pull => withUnit(pull.force, 'N') + ' by a spring of ' + withUnit(pull.stiffness, 'N/m')).join('; '));
  }

  count(now) {
    if (now - this.counted < 1000) return;
    const rate = 1000 * (this.pictures - this.counting) / (now - this.counted), counted = (n, word) => n + ' ' + word + (n === 1 ? '' : 's');
    if (!this.ended)
      write($('live-words'), counted(Math.round(rate), 'picture') + ' a second, ' + counted(this.moment ? this.moment.pages : 1, 'page') + ' open.');
    document.documentElement.dataset.pictures = this.pictures;
    // Where a new moment waits for nearly every picture, drawing is what is slow.
    if (this.view && rate < 28 && this.pictures - this.counting > 0.8 * this.turns && this.isBusy) this.view.simplify();
    this.isBusy = this.moment && this.moment.running;
    this.turns = 0;
    this.counting = this.pictures;
    this.counted = now;
  }
}

// One that is not in the list, as of --speed, gets a line in it.
function showSpeed(times) {
  const box = $('speed'), lines = [...box.options];
  if (!lines.some(line => Number(line.value) === times)) {
    const own = element('option', times + '\u00d7');
    own.value = times;
    box.insertBefore(own, lines.find(line => Number(line.value) > times) || box.lastElementChild);
  }
  if (box.value !== String(times)) box.value = times;
}

function wireLiveTimeline(live) {
  for (const s of speeds) element('option', s + '\u00d7', $('speed')).value = s;
  element('option', 'as fast as it can', $('speed')).value = 0;
  $('speed').value = 1;
  $('speed').onchange = () => {
    live.ask({do: 'speed', times: Number($('speed').value)});
    $('speed').blur();
  };
  const faster = way => live.ask({do: 'speed', times: nextSpeed(Number($('speed').value), way)});
  const step = () => live.ask({do: 'step'});
  $('play').onclick = () => live.play(!live.running);
  $('step').onclick = step;
  return {' ': () => live.play(!live.running), ArrowRight: step, ArrowUp: () => faster(1), ArrowDown: () => faster(-1)};
}

// Bodies, contacts and the hand of a live view, beside what a replay has. `show` draws the contacts.
function wireLiveStage(live, {stage, views, contacts, scale, upright, takeNodes}, {addView, renewed, rescale, show}) {
  const bodies = views[0], hand = new Hand(stage, upright, bodies, live);
  const pulls = new PullView(upright, scale.length);
  const words = () => { $('carve-words').textContent = withUnit(hand.radius, 'm'); };
  $('carve-radius').oninput = words;
  words();
  const carve = toggle('carve', on => {
    $('carving').hidden = !on;
    stage.changed = true;
  });
  const offerCarving = () => { if (bodies.some(view => view.body.cuttable)) $('carve').hidden = false; };
  offerCarving();
  // For tests, and for scripts of a notebook: where the bodies are, in the world [m] and in the window [css px].
  window.cloudcontact = {stage,
    positions: () => bodies.map(view => view.node.position.toArray()),
    inWindow: body => {
      const box = stage.canvas.getBoundingClientRect(), [x, y] = stage.onScreen(live.record.takes[0], bodies[body].node.position.toArray());
      return [x + box.left, y + box.top];
    }
  };
  const simplify = () => {
    if (!stage.simplify()) return;
    for (const view of bodies) {
      if (view.skin.isMeshStandardMaterial) view.simplify();
      renewed(view);
    }
    for (const view of contacts) view.make(true);
  };
  if (Stage.isSlow()) {
    simplify();
    simplify();
  }
  return {
    simplify, show, hand, keys: {k: () => { if (!$('carve').hidden && !$('carve').disabled) carve(); }},
    surface(body, message) {
      while (bodies.length <= body) {
        if (bodies.length < body) return;  // its turn comes
        const node = new THREE.Group();
        takeNodes[0].add(node);
        addView(new BodyView({...message, clouds: [], plane: false, masses: []}, node, stage.planes));
        offerCarving();
      }
      bodies[body].renew(message);
      renewed(bodies[body]);
      showMass(bodies[body], live.time);  // a run that is paused tells of no other moment
      stage.changed = true;
    },
    moment(moment) {
      bodies.forEach((view, b) => { if (7 * b < moment.poses.length) placeAt(view.node, moment.poses, 7 * b); });
      rescale(moment.contacts);
      show(moment.time);
      pulls.show(moment.pulls, bodies);
    }
  };
}
