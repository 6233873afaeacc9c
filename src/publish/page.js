// Takes clouds from the run, shows its settings and statistics, and follows buttons and gestures.
function redraw() {
  if (drawing) return;
  drawing = true;
  requestAnimationFrame(() => {
    drawing = false;
    if (taken && rays) {
      take(taken);
      taken = null;
      seen.push(performance.now());
      ask();
    }
    draw();
  });
}

function ask() {
  if (pressed('pause') || !socket || socket.readyState !== 1) return;
  socket.send(pressed('phase') ? 'next phase' : 'next');
}

async function connect() {
  let why = 'no connection; trying again';
  rays = null;
  socket = new WebSocket(location.origin.replace('http', 'ws') + '/clouds' + query);
  socket.binaryType = 'arraybuffer';
  socket.onopen = () => { cloud = taken = null; say('waiting for the first cloud'); ask(); };
  socket.onmessage = ({ data }) => { say(''); taken = data; redraw(); };
  socket.onclose = () => { say(why); asked = null; setTimeout(connect, 1000); };
  try {
    const told = await (asked || fetch('/rays' + query));
    if (!told.ok) throw Error(await told.text());
    rays = new Float32Array(await told.arrayBuffer());
    redraw();
  } catch (error) {
    if (!(error instanceof TypeError)) why = error.message;
    socket.close();
  }
}

// Control characters in names of files and cameras, as the program prints them.
const printable = text => text.replace(/[\x00-\x1f\x7f-\x9f]/g,
  c => '\\x' + c.charCodeAt(0).toString(16).padStart(2, '0'));

async function tell() {
  showSettings(await (await fetch('/settings' + query)).json());
  const told = await (await fetch('/statistics' + query)).json();
  frame = told.frame ?? null;
  const now = performance.now(), table = at('statistics');
  const row = (name, value) => {
    const line = table.insertRow();
    for (const text of [name, value.toLocaleString('en')]) line.insertCell().textContent = text;
  };
  seen = seen.filter(time => time > now - 2000);
  [at('name').textContent, at('source').textContent] = [told.source, told.source_state].map(printable);
  if (cloud) drawHistogram();
  table.replaceChildren();
  if (cloud && cloud.hasDepth) row('points', cloud.count);
  for (const { name, rate } of told.stages) if (name === 'show') row('clouds per second', rate);
  row('on this page', seen.length / 2);
  row('latency, 99th percentile', told.latency_ms.p99.toFixed(1) + ' ms');
  for (const [name, count] of Object.entries(told.frames)) row('frames ' + name, count);
  for (const { name, dropped } of told.sinks) row('dropped by ' + name.split(':')[0], dropped);
  const lasting = told.findings.filter(finding => finding.end === null);
  at('findings').replaceChildren(...lasting.map(finding => {
    const item = document.createElement('li'), why = document.createElement('small');
    why.textContent = printable(` ${finding.likely} ${finding.try}`);
    item.append(printable(finding.what), why);
    return item;
  }), lasting.length ? '' : 'none');
}

const post = (path, body) => fetch(path + query, { method: 'POST', body });

// Restores refused values and shows changes made elsewhere, except in a field being edited.
function showSettings(settings, all) {
  for (const { name, help, unit, value, choices, least, most, state } of settings) {
    if (name === 'record') {
      press('record', value === 'on');
      if (state) answer(`recording: ${printable(state)}`);
      continue;
    }
    if (choices.length === 1) continue;
    let input = at(`set ${name}`);
    if (!input) {
      const label = document.createElement('label'), words = document.createElement('span');
      input = document.createElement(choices.length ? 'select' : 'input');
      input.append(...choices.map(choice => new Option(choice)));
      if (!choices.length) Object.assign(input, { type: 'number', step: 'any' });
      input.id = `set ${name}`;
      input.onchange = () => change(name, input.value);
      words.textContent = unit ? `${name}, ${unit}` : name;
      label.title = help;
      label.append(words, input);
      at('settings').append(label);
    }
    [input.min, input.max] = [least, most];
    if (all || document.activeElement !== input) input.value = value;
  }
  for (const input of document.querySelectorAll('#settings input, #settings select')) {
    if (!settings.some(({ name }) => input.id === `set ${name}`)) input.parentNode.remove();
  }
}

async function change(name, value) {
  try {
    const told = await post('/settings', `${name}=${value}`);
    answer(told.ok ? '' : await told.text());
    showSettings(await (told.ok ? told : await fetch('/settings' + query)).json(), true);
  } catch { answer('no connection'); }
}

const press = (id, on) => at(id).setAttribute('aria-pressed', String(on));
at('record').onclick = () => change('record', pressed('record') ? 'off' : 'on');
at('pause').onclick = () => {
  press('pause', !pressed('pause'));
  ask();
};
at('modes').onclick = ({ target }) => {
  if (!target.id || target.id === 'modes') return;
  for (const button of at('modes').children) press(button.id, button === target);
  redraw();
};
for (const [id, turn, tilt] of [['front', 0, 0], ['side', -Math.PI / 2, 0], ['top', 0, -1.5]]) {
  at(id).onclick = () => {
    Object.assign(view, { turn, tilt, x: 0, y: 0 });
    redraw();
  };
}
function useLight(on) {
  document.documentElement.classList.toggle('light', on);
  press('light', on);
  localStorage.setItem('light', on ? 'on' : '');
  redraw();
}
at('light').onclick = () => useLight(!pressed('light'));
useLight(localStorage.getItem('light') === 'on');
at('save').onclick = async () => {
  answer('saving');
  try {
    const told = await post('/save');
    answer((told.ok ? 'saved: ' : '') + await told.text());
  } catch { answer('no connection'); }
};

// One finger or button turns; two fingers, or Shift, move and zoom.
const fingers = new Map();
at('stage').onpointerdown = event => fingers.set(event.pointerId, event);
window.onpointerup = window.onpointercancel = event => fingers.delete(event.pointerId);
window.onpointermove = event => {
  const before = fingers.get(event.pointerId);
  if (!before) return;
  const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
  const between = ([a, b]) => Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
  const was = fingers.size === 2 ? between([...fingers.values()]) : 0;
  fingers.set(event.pointerId, event);
  if (was) view.distance *= was / Math.max(between([...fingers.values()]), 1);
  if (was || event.shiftKey) {
    view.x += dx * view.distance / canvas.clientHeight / 2;
    view.y += dy * view.distance / canvas.clientHeight / 2;
  } else {
    view.turn += dx / 200;
    view.tilt = Math.max(-1.5, Math.min(1.5, view.tilt - dy / 200));
  }
  redraw();
};
at('stage').onwheel = event => {
  event.preventDefault();
  view.distance *= Math.exp(event.deltaY / 800);
  redraw();
};
at('stage').ondblclick = () => {
  view = { ...start };
  pivot = cloud && cloud.hasDepth ? middle(cloud) : null;
  redraw();
};
window.onresize = redraw;
connect();
setInterval(() => tell().catch(() => {}), 500);  // a lost connection is reported above
