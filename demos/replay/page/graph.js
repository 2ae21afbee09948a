// The graphs under the view, with the playhead: energy, depth, narrow phase.

const takeColors = ['#1f5fa8', '#c2571a', '#15803d', '#8b3fb0', '#606773', '#b3164a'];

function graphRows(record) {
  const lines = key => record.takes.map((take, i) => ({values: take.figures[key], time: take.figures.time, color: takeColors[i % 6]}));
  const energy = record.takes.map((take, i) => ({
    values: take.figures.kinetic.map((k, f) => k + take.figures.potential[f]), time: take.figures.time, color: takeColors[i % 6]
  }));
  const single = record.takes.length === 1;
  if (single) energy.push({...lines('kinetic')[0], color: '#c2571a', shift: true}, {...lines('spring')[0], color: '#15803d', shift: true});
  return [
    {name: 'Energy of the bodies', note: single ? [['all', '#1f5fa8'], ['kinetic', '#c2571a'], ['springs', '#15803d']] : 'kinetic and of gravity', unit: 'J', lines: energy},
    {name: 'Deepest contact', note: 'by the method itself', unit: 'm', lines: lines('deepest'), fromZero: true},
    {name: 'Narrow phase', note: 'per step', unit: 's', lines: lines('narrowPhase'), fromZero: true, calm: true}
  ];
}

class Graphs {
  constructor(element, record, seek) {
    this.element = element;
    this.from = 0;
    this.seconds = record.seconds || 1;
    this.rows = graphRows(record);
    for (const row of this.rows) this.addRow(row);
    this.head = document.createElement('div');
    this.head.id = 'playhead';
    element.append(this.head);
    const move = event => {
      const box = this.rows[0].canvas.getBoundingClientRect();
      seek(Math.min(1, Math.max(0, (event.clientX - box.left) / box.width)) * this.seconds);
    };
    element.addEventListener('pointerdown', event => { element.setPointerCapture(event.pointerId); move(event); });
    element.addEventListener('pointermove', event => { if (event.buttons) move(event); });
  }

  addRow(row) {
    const box = document.createElement('div');
    box.className = 'row';
    box.innerHTML = '<span class="name"></span><canvas></canvas><span class="value"></span>';
    box.querySelector('.name').textContent = row.name;
    const note = document.createElement('small');
    if (typeof row.note === 'string') note.textContent = row.note;
    else
      for (const [word, color] of row.note) {
        const span = document.createElement('span');
        span.textContent = word + ' ';
        span.style.color = color;
        note.append(span);
      }
    box.querySelector('.name').append(note);
    row.canvas = box.querySelector('canvas');
    row.value = box.querySelector('.value');
    row.canvas.setAttribute('role', 'img');
    row.canvas.setAttribute('aria-label', row.name + ' over time');
    this.element.append(box);
    this.scale(row);
  }

  // Kinetic and spring energy start at the bottom of the scale: compare their size, not their zero.
  scale(row) {
    let low = row.fromZero ? 0 : Infinity, high = -Infinity;
    for (const line of row.lines) {
      if (line.shift) continue;
      const top = row.calm ? 1.15 * quantile(line.values, 0.99) : line.values.reduce((a, v) => Math.max(a, v), -Infinity);
      if (!row.fromZero) low = line.values.reduce((a, v) => Math.min(a, v), low);
      high = Math.max(high, top);
    }
    for (const line of row.lines)
      if (line.shift) high = Math.max(high, low + line.values.reduce((a, v) => Math.max(a, v), 0));
    if (!(Math.abs(low) < Infinity)) low = 0;  // without values
    if (!(high > low)) high = low + (Math.abs(low) || 1);
    row.low = low;
    row.high = high;
  }

  // Of a record that has grown.
  renew(record) {
    const times = record.takes[0].figures.time;
    this.from = times[0] || 0;
    this.seconds = times[times.length - 1] - this.from || 1;
    graphRows(record).forEach((row, i) => {
      this.rows[i].lines = row.lines;
      this.scale(this.rows[i]);
    });
    this.draw();
  }

  draw() {
    for (const row of this.rows) {
      const ratio = window.devicePixelRatio || 1, {canvas} = row;
      const width = canvas.clientWidth, height = canvas.clientHeight;
      canvas.width = Math.max(1, width * ratio);
      canvas.height = Math.max(1, height * ratio);
      // Drawn by the processor: long lines are slow on a GPU, and slower where the processor stands in for one.
      const pen = canvas.getContext('2d', {willReadFrequently: true});
      pen.scale(ratio, ratio);
      pen.fillStyle = '#f4f5f8';
      pen.fillRect(0, 0, width, height);
      for (const line of row.lines) this.drawLine(pen, row, line, width, height);
    }
  }

  drawLine(pen, row, line, width, height) {
    const y = v => height - 3 - (height - 6) * Math.min(1.05, ((line.shift ? v + row.low : v) - row.low) / (row.high - row.low));
    pen.strokeStyle = line.color;
    pen.lineWidth = 1.4;
    pen.lineJoin = 'round';
    pen.beginPath();
    // With more values than pixels, each column of pixels shows its lowest and highest.
    const step = Math.max(1, Math.floor(line.values.length / (2 * width)));
    for (let i = 0; i < line.values.length; i += step) {
      let low = Infinity, high = -Infinity;
      for (let k = i; k < Math.min(line.values.length, i + step); ++k) {
        low = Math.min(low, line.values[k]);
        high = Math.max(high, line.values[k]);
      }
      const x = width * (line.time[i] - this.from) / this.seconds;
      pen.lineTo(x, y(low));
      if (high > low) pen.lineTo(x, y(high));
    }
    pen.stroke();
  }

  show(t) {
    const box = this.rows[0].canvas.getBoundingClientRect(), own = this.element.getBoundingClientRect();
    this.head.style.left = box.left - own.left + box.width * Math.min(1, (t - this.from) / this.seconds) + 'px';
    for (const row of this.rows) {
      const values = row.lines.filter(line => !line.shift).map(line => line.values[indexAt(line.time, t)]);
      const most = values.reduce((a, v) => Math.max(a, v), -Infinity);
      const top = row.lines[0].values.reduce((a, v) => Math.max(a, v), -Infinity);
      row.value.textContent = withUnit(most, row.unit);
      const small = document.createElement('small');
      small.textContent = values.length > 1 ? 'the most of ' + values.length : 'most ' + withUnit(top, row.unit);
      row.value.append(small);
    }
  }
}
