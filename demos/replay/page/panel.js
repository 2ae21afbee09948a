// The side panel: story, outcome, bodies, legend.

function element(tag, text, parent, className) {
  const e = document.createElement(tag);
  if (text !== undefined) e.textContent = text;
  if (className) e.className = className;
  if (parent) parent.append(e);
  return e;
}

// Sets a text if it is another: a page without a GPU draws again whatever is set.
function write(e, text) {
  if (e.textContent !== text) e.textContent = text;
}

function fillStory(record) {
  document.getElementById('title').textContent = record.title;
  document.getElementById('setup').textContent = record.setup;
  const story = document.getElementById('story');
  if (record.story) element('p', record.story, story);
  if (record.watch) {
    element('h2', 'What to look for', story);
    element('p', record.watch, story);
  }
  if (record.checks.length) {
    element('h2', 'What should happen, and what did', story);
    const list = element('ul', undefined, story);
    for (const check of record.checks) {
      const item = element('li', undefined, list, check.holds ? 'held' : 'failed');
      element('b', check.expected, item);
      element('span', check.found, item);
    }
  }
  if (record.facts.length) {
    element('h2', 'What happened', story);
    const list = element('dl', undefined, story);
    for (const [name, figure] of record.facts) {
      element('dt', name, list);
      element('dd', figure, list);
    }
  }
}

// A body's mass at a time, or what is more to know. `masses` of a body that is cut are pairs [s], [kg], from its
// beginning on.
function massWords({fixed, mass, masses}, t) {
  const known = masses.filter(([from]) => from <= t), now = known.length ? known[known.length - 1][1] : mass;
  if (masses.length && !known.length) return 'not yet';
  if (now === null) return 'gone';
  return fixed ? 'fixed' : now > 0 ? withUnit(1000 * now, 'g') : 'driven';
}

// `views` are the BodyViews of all takes; `changed` is called after each press of a button.
function fillBodies(record, views, changed) {
  const list = document.getElementById('bodies');
  record.takes.forEach((take, t) => {
    if (record.takes.length > 1) element('li', take.label, list, 'take').style.color = takeColors[t % 6];
    for (const view of views[t]) fillBody(view, changed);
  });
}

function showMass(view, t) {
  const words = massWords(view.body, t);
  write(view.massWords, words);
  view.massWords.closest('li').classList.toggle('away', words === 'gone' || words === 'not yet');
}

function fillBody(view, changed) {
  const {body} = view, item = element('li', undefined, document.getElementById('bodies'));
  element('i', undefined, item).style.background = body.color;
  const name = element('span', undefined, item, 'name');
  element('span', body.name, name).title = body.name;
  view.massWords = element('small', '', name);
  view.voxelButton = body.clouds.length ? element('button', 'mesh', item) : element('span', '', item);
  view.stateButton = element('button', 'solid', item);
  view.stateButton.setAttribute('aria-label', 'Display of ' + body.name);
  view.voxelButton.onclick = () => { view.asVoxels = !view.asVoxels; changed(view); };
  view.stateButton.onclick = () => {
    view.state = showStates[(showStates.indexOf(view.state) + 1) % showStates.length];
    changed(view);
  };
}

function fillLegend(record, scale) {
  const css = depthColors.map(c => '#' + c.clone().convertLinearToSRGB().getHexString()).join(',');
  const legend = document.getElementById('legend');
  legend.innerHTML = '<div><svg width="34" height="10"><path d="M1 5h22" stroke="#dc3b32" stroke-width="3"/>' +
    '<path d="M22 0l11 5-11 5z" fill="#dc3b32"/></svg><span></span></div>' +
    '<div class="bar"><span>depth 0</span><i></i><span></span></div>';
  legend.querySelector('i').style.background = 'linear-gradient(90deg,' + css + ')';
  return () => {
    write(legend.querySelector('div span'), withUnit(scale.force, 'N'));
    write(legend.querySelector('.bar span:last-child'), withUnit(scale.depth, 'm') + (record.voxel ? ' (' + Number((scale.depth / record.voxel).toPrecision(2)) + ' voxel)' : ''));
  };
}
