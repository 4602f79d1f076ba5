// One picture at a time on the stage, keys, exposure, and the values under the pointer.
const get = (id) => document.getElementById(id);
const [stage, readout] = ['stage', 'readout'].map(get);
const frame = stage.querySelector('.view');
const pictures = [...document.querySelectorAll('img[data-values]')];
const [reference, ...others] = pictures;
const rows = [...new Set(pictures.map((image) => image.dataset.row))];
const ofRow = (row) => others.filter((image) => image.dataset.row === row);
const names = [reference, ...ofRow(rows[0])].map((image) => image.dataset.name);
// The picture of a number in a row, where the reference is the first of each; it may be missing.
const at = (row, number) => number === 0 ? reference
  : ofRow(row).find((image) => image.dataset.name === names[number]);
const first = Math.min(settings.first, names.length - 1);
const state = { number: first, before: 0, row: rows[0], stops: 0, against: -1 };

// A frame shows its image as the page has it, or a canvas above it with what is asked for.
const draw = async (frame, image, stops, against) => {
  const turn = frame.turn = (frame.turn ?? 0) + 1;
  let canvas = null;
  if (stops !== 0 || against) {
    const radiance = await radianceOf(image);
    const from = against && await radianceOf(against);
    canvas = document.createElement('canvas');
    paint(canvas, image, from ? difference(radiance, from) : exposed(radiance, stops));
  }
  if (turn !== frame.turn) return;
  frame.querySelector('canvas')?.remove();
  if (canvas) frame.append(canvas);
};
const buttons = names.map((name, number) => {
  const button = document.createElement('button');
  button.type = 'button';
  button.textContent = number < 9 ? `${number + 1} ${name}` : name;
  // A second click flips back.
  button.addEventListener('click', () => {
    change({ number: number === state.number ? state.before : number });
  });
  return button;
});
// Changes the state, and what is seen of it.
const change = (changes) => {
  const { number, stops } = state;
  Object.assign(state, changes);
  if (!at(state.row, state.number)) state.number = 0;
  if (state.number !== number) state.before = number;
  state.stops = clamp(state.stops, -12, 12);
  const image = at(state.row, state.number);
  buttons.forEach((button, i) => {
    button.setAttribute('aria-pressed', i === state.number);
    button.disabled = !at(state.row, i);
  });
  get('row').value = state.row;
  get('against').value = state.against;
  get('stops').value = state.stops;
  get('stops-text').textContent = (state.stops > 0 ? '+' : '') + state.stops;
  const caption = image.closest('figure').querySelector('figcaption');
  get('caption').innerHTML = caption.innerHTML.replaceAll('<br>', ', ');
  frame.setAttribute('aria-label', image.alt);
  const shown = frame.querySelector('img');
  shown.alt = image.alt;
  frame.style.aspectRatio = image.parentElement.style.aspectRatio;
  if (shown.src !== image.src) shown.src = image.src;
  draw(frame, image, state.stops, at(state.row, state.against));
  if (state.stops !== stops) {
    pictures.forEach((image) => draw(image.parentElement, image, state.stops));
  }
};
const reset = () => {
  Object.assign(part, { zoom: 1, left: 0, top: 0 });
  show();
  change({ stops: 0, against: -1 });
};

// Shows the values of all pictures of a row at a place of the picture, or nothing.
let asked = 0;
const look = async (view, x, y) => {
  const turn = ++asked;
  root.classList.toggle('pointed', x !== undefined);
  readout.hidden = x === undefined;
  if (readout.hidden) return;
  const { naturalWidth: width, naturalHeight: height } = reference;
  const column = clamp(Math.floor(x * width), 0, width - 1);
  const line = clamp(Math.floor(y * height), 0, height - 1);
  const marks = { x: column / width, y: line / height, width: 1 / width, height: 1 / height };
  Object.entries(marks).forEach(([name, value]) => {
    root.style.setProperty(`--pixel-${name}`, value);
  });
  const own = view.querySelector('img');
  const images = [reference, ...ofRow(others.includes(own) ? own.dataset.row : state.row)];
  const values = await Promise.all(images.map(radianceOf));
  if (turn !== asked) return;
  const i = 3 * (line * width + column);
  const floor = floorOf(values[0]);
  const cells = (row, texts) => texts.forEach((text, k) => {
    const tag = k === 0 || !row.parentElement.matches('tbody') ? 'th' : 'td';
    row.append(Object.assign(document.createElement(tag), { textContent: text }));
  });
  const table = document.createElement('table');
  const place = `pixel (${column * settings.factor}, ${line * settings.factor})`;
  cells(table.createTHead().insertRow(), [place, 'R', 'G', 'B', 'error']);
  table.createTBody();
  images.forEach((image, k) => {
    const error = 100 * errorAt(values[k], values[0], floor, i);
    const rgb = [0, 1, 2].map((c) => values[k][i + c])
      .map((x) => (x >= largest ? '≥ ' : '') + number(x));
    const text = k > 0 ? `${error > 0 ? '+' : ''}${number(error)} %` : '';
    cells(table.tBodies[0].insertRow(), [image.dataset.name, ...rgb, text]);
  });
  readout.replaceChildren(table);
};

// The item some steps away, of those that there are.
const step = (list, item, steps) => list[(list.indexOf(item) + steps + list.length) % list.length];
const flip = (steps) => {
  const present = names.map((_, number) => number).filter((number) => at(state.row, number));
  change({ number: step(present, state.number, steps) });
};
const actions = {
  ArrowLeft: () => flip(-1),
  ArrowRight: () => flip(1),
  ArrowUp: () => change({ row: step(rows, state.row, -1) }),
  ArrowDown: () => change({ row: step(rows, state.row, 1) }),
  ' ': () => change({ number: state.before }),
  d: () => change({ against: state.against < 0 ? 0 : -1 }),
  e: () => change({ stops: state.stops + 0.5 }),
  E: () => change({ stops: state.stops - 0.5 }),
  0: reset,
};
const press = (event, action) => {
  if (!action || event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented) return;
  event.preventDefault();
  action();
};
stage.addEventListener('keydown', (event) => {
  // Controls have keys of their own.
  const isPress = event.key === ' ' || event.key === 'Enter';
  if (event.target.matches('select, input') || (event.target.matches('button, a') && isPress)) {
    return;
  }
  const number = Number(event.key) - 1;
  const isNumber = /^[1-9]$/.test(event.key) && at(state.row, number);
  press(event, isNumber ? () => change({ number }) : actions[event.key]);
});
document.querySelectorAll('.view').forEach((view) => {
  watch(view, look);
  if (view === frame) return;
  const image = view.querySelector('img');
  view.tabIndex = 0;
  view.setAttribute('role', 'group');
  view.setAttribute('aria-label', image.alt);
  view.addEventListener('keydown', (event) => {
    const bring = () => {
      const number = image === reference ? 0 : names.indexOf(image.dataset.name, 1);
      change({ row: image.dataset.row, number });
      stage.scrollIntoView();
      frame.focus();
    };
    const isKnown = event.key === 'Enter' && pictures.includes(image);
    press(event, isKnown ? bring : 'eE0'.includes(event.key) && actions[event.key]);
  });
});

get('choices').append(...buttons);
get('row').append(...rows.map((row) => new Option(row, row)));
get('against').append(...names.map((name, number) => new Option(name, number)));
get('row').addEventListener('change', (event) => change({ row: event.target.value }));
get('against').addEventListener('change', (event) => {
  change({ against: Number(event.target.value) });
});
get('stops').addEventListener('input', (event) => change({ stops: Number(event.target.value) }));
get('whole').addEventListener('click', reset);
stage.hidden = false;
// What is seen stays when the page is loaded again, perhaps with more pictures in it.
const kept = history.state ?? {};
const [shown, against] = [kept.shown, kept.against].map((name) => names.indexOf(name));
Object.assign(part, kept.part);
show();
change({
  number: shown < 0 ? first : shown,
  row: rows.includes(kept.row) ? kept.row : rows[0],
  stops: kept.stops ?? 0,
  against,
});
if (kept.isActive) frame.focus({ preventScroll: true });
addEventListener('beforeunload', () => {
  const { number, row, stops, against } = state;
  const isActive = document.activeElement === frame;
  const [shown, from] = [names[number], names[against]];
  history.replaceState({ shown, against: from, row, stops, part, isActive }, '');
});
