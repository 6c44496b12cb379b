'use strict';
// Draws the recordings of the report: one at a time in full, all of them small; drag, buttons or keys zoom in time.
(() => {
  const holder = document.getElementById('data');
  for (const button of document.querySelectorAll('button[data-copies]')) {
    button.hidden = false;
    button.addEventListener('click', () => copy(button));
  }
  if (!holder) return;
  const data = JSON.parse(holder.textContent);
  const plot = document.getElementById('plot');
  const choice = document.getElementById('choice');
  const small = document.getElementById('all');
  const told = document.getElementById('told');
  const every = document.getElementById('every');
  let at = data.start, from = 0, to = 1, all = false;

  function copy(button) {
    const text = button.parentElement.querySelector('code').textContent;
    const done = () => { button.textContent = 'copied'; setTimeout(() => { button.textContent = 'copy'; }, 1500); };
    const select = () => {
      const range = document.createRange();
      range.selectNodeContents(button.parentElement.querySelector('code'));
      getSelection().removeAllRanges();
      getSelection().addRange(range);
    };
    if (navigator.clipboard) navigator.clipboard.writeText(text).then(done, select); else select();
  }

  function numbers(packed) {
    const bytes = Uint8Array.from(atob(packed), (c) => c.charCodeAt(0));
    return new Float32Array(bytes.buffer);
  }

  function unpack(recording) {
    if (recording.ready) return recording;
    for (const c of recording.channels) {
      c.time = numbers(c.time);
      c.recorded = numbers(c.recorded);
      c.models = c.models.map(numbers);
      c.left = c.models.map((m) => m.map((value, k) => c.recorded[k] - value));
    }
    if (recording.drive) {
      recording.drive.time = numbers(recording.drive.time);
      recording.drive.value = numbers(recording.drive.value);
    }
    const times = [...recording.channels, recording.drive].filter((c) => c && c.time.length).map((c) => c.time);
    recording.start = Math.min(...times.map((t) => t[0]));
    recording.end = Math.max(...times.map((t) => t[t.length - 1]));
    recording.ready = true;
    return recording;
  }

  function make(name, attributes, parent, text) {
    const node = document.createElementNS('http://www.w3.org/2000/svg', name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    if (text !== undefined) node.textContent = text;
    parent.appendChild(node);
    return node;
  }

  function range(lists, time, start, end, least) {
    let low = Infinity, high = -Infinity;
    lists.forEach((list) => list.forEach((value, k) => {
      if ((time === null || (time[k] >= start && time[k] <= end)) && Number.isFinite(value)) {
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    }));
    if (low > high) return [0, 1];
    low = Math.min(low, least ?? low);
    high = Math.max(high, least === undefined ? high : -least);
    const room = 0.06 * (high - low) || 0.5;
    return [low - room, high + room];
  }

  function ticks(low, high, most) {
    const rough = (high - low) / most, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= rough);
    const found = [];
    for (let value = Math.ceil(low / step) * step; value <= high + 1e-9 * step; value += step) {
      found.push(Math.abs(value) < 1e-9 * step ? 0 : value);
    }
    return [found, Math.max(0, -Math.floor(Math.log10(step) + 1e-9))];
  }

  function line(time, value, x, y, start, end, stairs) {
    const gaps = Array.from(time).slice(1).map((t, k) => t - time[k]).sort((a, b) => a - b);
    const gap = stairs ? Infinity : 5 * (gaps[Math.floor(gaps.length / 2)] || Infinity);
    let path = '', before = -1;
    for (let k = 0; k < time.length; k++) {
      const near = time[k] >= start && time[k] <= end;
      const beside = (k + 1 < time.length && time[k + 1] >= start && time[k] < start)
        || (k > 0 && time[k - 1] <= end && time[k] > end);
      if (!near && !beside) continue;
      const [a, b] = [x(time[k]).toFixed(1), y(value[k]).toFixed(1)];
      if (before !== k - 1 || before < 0 || time[k] - time[before] > gap) path += `M${a} ${b}`;
      else path += stairs ? `H${a}V${b}` : `L${a} ${b}`;
      before = k;
    }
    return path;
  }

  function panel(top, height, label, unit, low, high, width, start, end) {
    const left = 58, right = width - 8;
    const x = (t) => left + (right - left) * (t - start) / (end - start);
    const y = (v) => top + height - height * (v - low) / (high - low);
    const [found, digits] = ticks(low, high, Math.max(3, Math.round(height / 32)));
    for (const value of found) {
      make('line', { x1: left, x2: right, y1: y(value), y2: y(value), class: 'grid' }, plot);
      make('text', { x: left - 5, y: y(value) + 4, 'text-anchor': 'end' }, plot, value.toFixed(digits));
    }
    const clip = `clip${top}`;
    make('rect', { x: left, y: top, width: right - left, height }, make('clipPath', { id: clip }, plot));
    const inside = make('g', { 'clip-path': `url(#${clip})` }, plot);
    make('rect', { x: left, y: top, width: right - left, height, class: 'frame' }, plot);
    make('text', { x: left + 4, y: top - 4, class: unit ? '' : 'name' }, plot, label);
    return { x, y, inside, left, right, top, height };
  }

  function draw() {
    const recording = unpack(data.recordings[at]);
    const span = recording.end - recording.start || 1;
    const start = recording.start + from * span, end = recording.start + to * span;
    const width = Math.max(plot.clientWidth, 280);
    plot.replaceChildren();
    let top = 18, last;
    if (recording.drive) {
      const d = recording.drive;
      const [low, high] = range([d.value], d.time, -Infinity, Infinity, 0);
      last = panel(top, 46, d.label, '', low, high, width, start, end);
      make('path', { d: line(d.time, d.value, last.x, last.y, start, end, true), class: 'drive' }, last.inside);
      top += 46 + 24;
    }
    const drawn = all ? recording.channels : recording.channels.slice(0, 1);
    drawn.forEach((c, place) => {
      const [tall, flat] = place ? [64, 40] : [130, 64];  // what shows most has most room
      const [low, high] = range([c.recorded, ...c.models], c.time, start, end);
      last = panel(top, tall, c.label, '', low, high, width, start, end);
      if (c.channel === recording.shadedChannel) shade(recording, last);
      make('path', { d: line(c.time, c.recorded, last.x, last.y, start, end), class: 'recorded' }, last.inside);
      c.models.forEach((m, k) => make('path', { d: line(c.time, m, last.x, last.y, start, end), class: ['first', 'second'][k] }, last.inside));
      top += tall + 20;
      const band = c.noise === null ? 0 : 2 * c.noise;
      const [less, more] = range(c.left, c.time, start, end, -band);
      last = panel(top, flat, `recorded - model (${c.unit})`, c.unit, less, more, width, start, end);
      if (band) make('rect', { x: last.left, width: last.right - last.left, y: last.y(band), height: last.y(-band) - last.y(band), class: 'noise' }, last.inside);
      if (c.channel === recording.shadedChannel) shade(recording, last);
      c.left.forEach((m, k) => make('path', { d: line(c.time, m, last.x, last.y, start, end), class: ['first', 'second'][k] }, last.inside));
      top += flat + 26;
    });
    const [found, digits] = ticks(start, end, Math.max(2, Math.round(width / 110)));
    for (const value of found) make('text', { x: last.x(value), y: top - 10, 'text-anchor': 'middle' }, plot, value.toFixed(digits));
    make('text', { x: last.right, y: top + 5, 'text-anchor': 'end' }, plot, 'time (s)');
    const height = top + 12;
    plot.setAttribute('viewBox', `0 0 ${width} ${height}`);
    plot.setAttribute('height', height);
    const names = drawn.map((c) => c.channel).join(', ');
    const marked = recording.shaded.some(([a, b]) => a < end && b > start);
    document.getElementById('shaded').hidden = !marked;
    const text = `Recording ${at + 1} of ${data.recordings.length}, ${recording.name}, ${start.toFixed(1)} s to ${end.toFixed(1)} s: ${names}`;
    told.textContent = `${text}.`;
    plot.setAttribute('aria-label', `${text}, as recorded, ${data.models.join(' and ')}; below each what is left`);
    plot.view = { left: last.left, right: last.right, start, end, height };
    choice.value = String(at);
    small.querySelectorAll('button').forEach((button, k) => button.setAttribute('aria-pressed', String(k === at)));
  }

  function shade(recording, where) {
    for (const [a, b] of recording.shaded) {
      make('rect', { x: where.x(a), width: Math.max(where.x(b) - where.x(a), 1), y: where.top, height: where.height, class: 'shade' }, where.inside);
    }
  }

  function zoom(factor, middle = (from + to) / 2) {
    const half = Math.min(Math.max((to - from) * factor, 1e-4), 1) / 2;
    middle = Math.min(Math.max(middle, half), 1 - half);
    [from, to] = [middle - half, middle + half];
    draw();
  }

  function show(k) {
    at = (k + data.recordings.length) % data.recordings.length;
    [from, to] = [0, 1];
    draw();
  }

  const actions = {
    earlier: () => zoom(1, (from + to) / 2 - (to - from) / 4),
    later: () => zoom(1, (from + to) / 2 + (to - from) / 4),
    in: () => zoom(0.5),
    out: () => zoom(2),
    whole: () => { [from, to] = [0, 1]; draw(); },
  };
  for (const button of document.querySelectorAll('[data-zoom]')) button.addEventListener('click', actions[button.dataset.zoom]);
  const keys = { ArrowLeft: 'earlier', ArrowRight: 'later', '+': 'in', '-': 'out', 0: 'whole' };
  plot.addEventListener('keydown', (event) => {
    if (keys[event.key]) { actions[keys[event.key]](); event.preventDefault(); }
  });
  plot.addEventListener('dblclick', actions.whole);

  let pressed = null, box = null;
  const inView = (event) => {
    const bounds = plot.getBoundingClientRect(), v = plot.view;
    const x = (event.clientX - bounds.left) * Math.max(plot.clientWidth, 280) / bounds.width;
    return Math.min(Math.max((x - v.left) / (v.right - v.left), 0), 1);
  };
  plot.addEventListener('pointerdown', (event) => { pressed = inView(event); });
  plot.addEventListener('pointermove', (event) => {
    if (pressed === null) return;
    const v = plot.view, [a, b] = [pressed, inView(event)].sort((p, q) => p - q);
    box ??= make('rect', { y: 0, height: v.height, class: 'chosen' }, plot);
    box.setAttribute('x', v.left + a * (v.right - v.left));
    box.setAttribute('width', (b - a) * (v.right - v.left));
  });
  addEventListener('pointerup', (event) => {
    if (pressed === null) return;
    const [a, b] = [pressed, inView(event)].sort((p, q) => p - q), span = to - from;
    [pressed, box] = [null, null];
    if (b - a > 0.01) [from, to] = [from + a * span, from + b * span];
    draw();
  });
  addEventListener('pointercancel', () => { [pressed, box] = [null, null]; draw(); });

  data.recordings.forEach(unpack);
  const firsts = data.recordings.map((recording) => recording.channels[0]).filter(Boolean);
  const same = firsts.filter((c) => c.channel === firsts[0].channel);
  const [least, most] = range(same.flatMap((c) => c.left), null);
  data.recordings.forEach((recording, k) => {
    choice.add(new Option(`${k + 1}. ${recording.name}`, String(k)));
    const button = document.createElement('button');
    button.type = 'button';
    button.title = recording.name;
    const c = recording.channels[0];
    if (c) {
      const picture = make('svg', { viewBox: '0 0 100 30', preserveAspectRatio: 'none', 'aria-hidden': 'true' }, button);
      const x = (t) => 100 * (t - recording.start) / (recording.end - recording.start || 1);
      const y = (v) => 30 - 30 * (v - least) / (most - least);
      c.left.forEach((m, n) => make('path', { d: line(c.time, m, x, y, -Infinity, Infinity), class: ['first', 'second'][n] }, picture));
    }
    button.append(`${k + 1}. ${recording.name}`);
    button.addEventListener('click', () => show(k));
    small.appendChild(button);
  });
  small.hidden = choice.hidden = data.recordings.length < 2;
  every.hidden = data.recordings.every((recording) => recording.channels.length < 2);
  every.addEventListener('click', () => { all = !all; every.setAttribute('aria-pressed', String(all)); draw(); });
  choice.addEventListener('change', () => show(Number(choice.value)));
  addEventListener('resize', draw);
  draw();
})();
