// Draws the clouds, with WebGL or without it. page.js continues this script.
'use strict';
const at = id => document.getElementById(id), query = location.search;
let asked = fetch('/rays' + query);
let palette = new Uint8Array(768);  // red, green, blue from near to far
fetch('/palette' + query).then(told => told.arrayBuffer()).then(usePalette);
let canvas = document.querySelector('canvas'), plain = canvas.getContext('2d', { alpha: false });
let gl = null, textures = null, raysOnCard = null, cardAsked = null;
const pressed = id => at(id).getAttribute('aria-pressed') === 'true';
let rays = null, cloud = null, taken = null, socket = null, seen = [], drawing = false, draws = 0;
const start = { turn: 0, tilt: 0, distance: 0, x: 0, y: 0 };
let view = { ...start }, pivot = null, frame = null;  // whose axes are drawn; null: the camera's

const say = text => { at('state').textContent = text; };
const answer = text => { at('answer').textContent = text; };

function program(vertex, fragment) {
  const made = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, '#version 300 es\nprecision highp float;\n' + source);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);  // errors show on first use: asking now would wait for the compiler
  return made;
}

// A pixel's point lies at its depth along its ray.
const points = () => points.made ??= program(`
  uniform highp usampler2D depths; uniform highp sampler2D rays; uniform sampler2D greys;
  uniform sampler2D palette;
  uniform mat4 view; uniform vec4 depth; uniform float size; uniform bool inColours;
  uniform vec2 tone;
  out vec3 colour;
  vec3 place(ivec2 at) {
    uint steps = texelFetch(depths, min(at, textureSize(depths, 0) - 1), 0).r;
    float z = depth.x + float(steps - 1u) * depth.y;
    return steps == 0u ? vec3(0.0) : vec3(texelFetch(rays, at, 0).rg * z, z);
  }
  void main() {
    int width = textureSize(depths, 0).x;
    ivec2 at = ivec2(gl_VertexID % width, gl_VertexID / width);
    vec3 here = place(at), right = place(at + ivec2(2, 0)), below = place(at + ivec2(0, 2));
    gl_PointSize = 1.0;
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    if (here.z == 0.0) return;
    float z = here.z, shade = 0.8;
    if (right.z * below.z > 0.0 && abs(right.z - z) + abs(below.z - z) < 0.03 * z) {
      vec3 normal = normalize(cross(right - here, below - here));
      shade = 0.25 + 0.75 * abs(dot(normal, normalize(here)));
    }
    gl_Position = view * vec4(here, 1.0);
    gl_PointSize = clamp(size * z / gl_Position.w, 1.0, 40.0);
    float far = clamp((z - depth.z) / depth.w, 0.0, 1.0);
    vec3 grey = clamp((texelFetch(greys, at, 0).rgb - tone.x) * tone.y, 0.0, 1.0);
    colour = inColours ? texture(palette, vec2(far, 0.5)).rgb * (0.6 + 0.4 * grey.g) : grey;
    colour *= shade;
  }`, 'in vec3 colour; out vec4 shown; void main() { shown = vec4(colour, 1.0); }');
const pictures = () => pictures.made ??= program(`
  uniform vec2 scale; out vec2 place;
  void main() {
    place = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4((place * 2.0 - 1.0) * scale * vec2(1.0, -1.0), 0.0, 1.0);
  }`, `uniform sampler2D greys; uniform bool isPhase; uniform vec3 ground; uniform vec2 tone;
  in vec2 place; out vec4 shown;
  void main() {
    vec3 levels = texture(greys, place).rgb;
    float level = levels.r, turn = 6.0 * (level - 1.0 / 255.0);
    vec3 hue = clamp(abs(mod(turn + vec3(0.0, 4.0, 2.0), 6.0) - 3.0) - 1.0, 0.0, 1.0);
    vec3 picture = clamp((levels - tone.x) * tone.y, 0.0, 1.0);
    shown = vec4(!isPhase ? picture : level == 0.0 ? ground : hue, 1.0);
  }`);

// Called once the first cloud is visible, as the page freezes until WebGL answers. Drawing on the
// canvas is faster than WebGL in software.
function useCard() {
  const fresh = canvas.cloneNode();
  const tried = fresh.getContext(
      'webgl2', { antialias: false, alpha: false, failIfMajorPerformanceCaveat: true });
  const told = tried && tried.getExtension('WEBGL_debug_renderer_info');
  if (!tried || /swiftshader|llvmpipe|softpipe|software|basic render/i.test(
      tried.getParameter(told ? told.UNMASKED_RENDERER_WEBGL : tried.RENDERER))) return;
  canvas.replaceWith(fresh);
  [canvas, gl, plain] = [fresh, tried, null];
  textures = [0, 1, 2, 3].map(() => gl.createTexture());
  redraw();
}

function texture(unit, inner, width, height, format, type, data) {
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, textures[unit]);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  gl.texImage2D(gl.TEXTURE_2D, 0, inner, width, height, 0, format, type, data);
}

function take(message) {
  const [width, height, contents, count] = new Int32Array(message, 0, 4);
  const hasDepth = contents & 1, hasColour = contents & 2;
  const [nearest, step] = new Float32Array(message, 16, 2), all = width * height;
  cloud = { width, height, hasDepth, count, nearest, step,
            depths: new Uint16Array(message, 24, all),
            greys: new Uint8Array(message, 24 + 2 * all, all),
            colours: hasColour ? new Uint8Array(message, 24 + 3 * all, 3 * all) : null,
            phases: new Uint8Array(message, 24 + (hasColour ? 6 : 3) * all) };
  tone = hasColour ? [0, 1] : toneOf(cloud.greys);  // colours are shown as they are
  tints = hasColour ? tintsOf(cloud.colours) : null;
  at('grey').textContent = hasColour ? 'Colour' : 'Grey';
  greyColours.forEach((_, n) => {
    greyColours[n] = opaque(Array(3).fill(Math.max(0, Math.min(255, (n - tone[0]) * tone[1]))));
  });
  cardAsked ??= new Promise(done => setTimeout(() => done(useCard()), 100));
  if (hasDepth && !pivot && count) pivot = middle(cloud);
}

// Black and contrast: black shows the darkest 1 % of grey levels, white the brightest 1 %.
function toneOf(greys) {
  const counts = new Uint32Array(256);
  for (let i = 0; i < greys.length; i += 7) ++counts[greys[i]];
  const level = share => {
    let left = share * counts.reduce((sum, count) => sum + count, 0);
    return counts.findIndex(count => (left -= count) <= 0);
  };
  const dark = level(.01), bright = Math.max(level(.99), dark + 8);
  return [dark, 255 / (bright - dark)];
}

// Depth range of most points; of an object alone before a background far behind it, as
// range_of_object in src/base/object_range.h.
function rangeOfObject(depths) {
  depths.sort((a, b) => a - b);
  const part = share => depths[Math.floor(share * (depths.length - 1))];
  const near = part(.01), far = part(.99);
  for (let share = .1; share + .02 < .99; share += .02) {
    const end = part(share), isFlat = 20 * (end - near) <= far - near;
    if (3 * (part(share + .02) - end) > far - near && !isFlat) return [near, end];
  }
  return [near, far];
}

// Centre of a few thousand points, and the depth range of the object.
function middle({ depths, nearest, step }) {
  const some = [], sum = [0, 0, 0];
  for (let i = 0; i < depths.length; i += 1 + (depths.length >> 12)) {
    if (!depths[i]) continue;
    const z = nearest + (depths[i] - 1) * step;
    some.push(z);
    [rays[2 * i] * z, rays[2 * i + 1] * z, z].forEach((value, k) => { sum[k] += value; });
  }
  if (!some.length) return null;
  const [near, far] = rangeOfObject(some);
  view.distance = sum[2] / some.length;
  return { centre: sum.map(value => value / some.length), near, far };
}

// Turns about the centre, `distance` ahead; Z is forward and Y down, as for the camera.
function turned() {
  const [c, s, k, t] = [Math.cos(view.turn), Math.sin(view.turn), Math.cos(view.tilt),
                        Math.sin(view.tilt)];
  return [[c, 0, s], [t * s, k, -t * c], [-k * s, t, k * c]];
}

function viewMatrix(zoom, aspect) {
  const rows = turned();
  const moved = rows.map((row, i) => [view.x, view.y, view.distance][i] -
                         row.reduce((sum, value, j) => sum + value * pivot.centre[j], 0));
  const near = view.distance / 100, far = view.distance * 20;
  const scale = [zoom / aspect, -zoom, (far + near) / (far - near), 1];
  const columns = [0, 1, 2].map(j => scale.map((f, i) => f * rows[Math.min(i, 2)][j]));
  columns.push(scale.map((f, i) => f * moved[Math.min(i, 2)]));
  columns[3][2] -= 2 * far * near / (far - near);
  return columns.flat();
}

// The visible share of the rays' width and height, and the spacing of neighbours.
function lens() {
  const { width } = cloud, last = rays.length - 2, aspect = canvas.width / canvas.height;
  const row = 2 * width * (last / 4 / width | 0);
  const wide = Math.max(Math.abs(rays[row]), Math.abs(rays[row + 2 * width - 2]));
  const high = Math.max(Math.abs(rays[1]), Math.abs(rays[last + 1]));
  const zoom = .95 * Math.min(1 / high, aspect / wide);
  const spacing = Math.abs(rays[last] - rays[last + 2 - 2 * width]) / width;
  return { view: viewMatrix(zoom, aspect), zoom, size: 1.3 * spacing * zoom * canvas.height / 2 };
}

function draw() {
  const { clientWidth: wide, clientHeight: high } = canvas;
  const most = plain ? Math.sqrt(1e6 / (wide * high)) : 2;
  const ratio = Math.min(devicePixelRatio, 2, most);
  for (const [side, shown] of [['width', wide], ['height', high]]) {
    const pixels = Math.max(1, Math.round(shown * ratio));
    if (canvas[side] !== pixels) canvas[side] = pixels;
  }
  const ground = getComputedStyle(document.body).backgroundColor.match(/\d+/g).map(Number);
  const isPhase = pressed('phase') && cloud && cloud.phases.length > 0;
  const asPicture = isPhase || pressed('picture') || !pivot || !rays;
  (plain ? drawPlain : drawFast)(ground, asPicture, isPhase, pressed('depth'));
  drawAround(!asPicture && cloud !== null, high);
}

// Axes, scale and legend.
function drawAround(hasPoints, high) {
  at('legend').hidden = !hasPoints || !pressed('depth');
  at('scale').hidden = !hasPoints;
  at('axes').style.visibility = hasPoints ? '' : 'hidden';
  if (!hasPoints) return;
  const [right, down] = turned(), colours = ['#ff5a50', '#58c76a', '#5a9bff'];
  // Row k of a frame's rotation is its axis k, as the camera sees it.
  const along = (row, k) => frame
    ? row.reduce((sum, part, i) => sum + part * frame.matrix_mm[k][i], 0) : row[k];
  at('axes').innerHTML = colours.map((colour, k) => {
    const [x, y] = [along(right, k), along(down, k)].map(part => part.toFixed(3));
    return `<line x2="${x}" y2="${y}" stroke="${colour}" stroke-width=".08"/>` +
      `<text x="${1.2 * x}" y="${1.2 * y + .13}" fill="${colour}" font-size=".4"` +
      ` text-anchor="middle">${'XYZ'[k]}</text>`;
  }).join('');
  const pixelsPerMm = lens().zoom * high / 2 / view.distance, wanted = 120 / pixelsPerMm;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const length = [5, 2, 1].map(factor => factor * power).find(value => value <= wanted);
  at('scale').style.width = length * pixelsPerMm + 'px';
  at('scale').textContent = `${+length.toPrecision(1)} mm`;
  const [near, far] = at('legend').querySelectorAll('span');
  [near.textContent, far.textContent] = [pivot.near, pivot.far].map(z => z.toFixed(0) + ' mm');
}

function usePalette(colours) {
  palette = new Uint8Array(colours);
  const stops = [...Array(16).keys()].map(n => `rgb(${palette.slice(51 * n, 51 * n + 3)})`);
  at('legend').querySelector('i').style.background = `linear-gradient(${stops})`;
  redraw();
}

function drawFast(ground, asPicture, isPhase, inColours) {
  const behind = ground.slice(0, 3).map(level => level / 255);
  gl.viewport(0, 0, canvas.width, canvas.height);
  gl.clearColor(...behind, 1);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  if (!cloud) return;
  const { width, height, depths, greys, colours, phases } = cloud;
  if (!asPicture) {
    texture(0, gl.R16UI, width, height, gl.RED_INTEGER, gl.UNSIGNED_SHORT, depths);
    if (raysOnCard !== rays) texture(1, gl.RG32F, width, height, gl.RG, gl.FLOAT, rays);
    raysOnCard = rays;
    texture(3, gl.RGB8, 256, 1, gl.RGB, gl.UNSIGNED_BYTE, palette);
  }
  if (colours && !isPhase) {
    texture(2, gl.RGB8, width, height, gl.RGB, gl.UNSIGNED_BYTE, colours);
  } else {  // the same level in red, green and blue
    const levels = isPhase ? phases : greys;
    texture(2, gl.LUMINANCE, width, height, gl.LUMINANCE, gl.UNSIGNED_BYTE, levels);
  }
  const used = (asPicture ? pictures : points)();
  const set = (kind, name, ...values) => gl[kind](gl.getUniformLocation(used, name), ...values);
  if (!draws++ && !gl.getProgramParameter(used, gl.LINK_STATUS)) say(gl.getProgramInfoLog(used));
  gl.useProgram(used);
  set('uniform1i', 'greys', 2);
  set('uniform2f', 'tone', tone[0] / 255, tone[1]);
  if (asPicture) {
    const wider = width / height / (canvas.width / canvas.height);
    gl.disable(gl.DEPTH_TEST);
    set('uniform1i', 'isPhase', isPhase);
    set('uniform3f', 'ground', ...behind);
    set('uniform2f', 'scale', Math.min(1, wider), Math.min(1, 1 / wider));
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    return;
  }
  const { view, size } = lens();
  gl.enable(gl.DEPTH_TEST);
  set('uniform1i', 'depths', 0);
  set('uniform1i', 'rays', 1);
  set('uniform1i', 'palette', 3);
  set('uniformMatrix4fv', 'view', false, view);
  set('uniform4f', 'depth', cloud.nearest, cloud.step, pivot.near, pivot.far - pivot.near || 1);
  set('uniform1f', 'size', size);
  set('uniform1i', 'inColours', inColours);
  gl.drawArrays(gl.POINTS, 0, width * height);
}

let shown = null, pixels = null, behind = null;  // the canvas's buffers: picture, pixels, distances
let every = 2;  // step in rows and columns that keeps drawing fast
const opaque = ([red, green, blue]) => 0xff000000 | blue << 16 | green << 8 | red;
// Red, green and blue, as in the shaders.
const hue = turn => [0, 4, 2].map(
    part => 255 * Math.max(0, Math.min(1, Math.abs((6 * turn + part) % 6 - 3) - 1)));
let tone = [0, 1], tints = null;  // the pixels' colours, if known
const tintsOf = colours => Uint32Array.from(
    { length: colours.length / 3 }, (_, n) => opaque(colours.subarray(3 * n, 3 * n + 3)));
const greyColours = new Uint32Array(256);
const phaseColours = Uint32Array.from({ length: 256 }, (_, n) => opaque(hue((n - 1) / 255)));
// Draws without WebGL.
function drawPlain(ground, asPicture, isPhase, inColours) {
  const wide = canvas.width, high = canvas.height;
  if (!shown || shown.width !== wide || shown.height !== high) {
    shown = plain.createImageData(wide, high);
    pixels = new Uint32Array(shown.data.buffer);
    behind = new Float32Array(wide * high);
  }
  pixels.fill(opaque(ground));
  phaseColours[0] = pixels[0];
  if (cloud && asPicture) drawPicture(wide, high, isPhase);
  if (cloud && !asPicture) drawPoints(wide, high, inColours);
  plain.putImageData(shown, 0, 0);
}

function drawPicture(wide, high, isPhase) {
  const { width, height } = cloud, scale = Math.min(wide / width, high / height);
  const levels = isPhase ? cloud.phases : cloud.greys;
  const colours = isPhase ? phaseColours : greyColours, own = isPhase ? null : tints;
  const left = (wide - width * scale) / 2, top = (high - height * scale) / 2;
  for (let y = Math.ceil(top); y < high - top; ++y) {
    const row = width * Math.min(height - 1, (y - top) / scale | 0);
    for (let x = Math.ceil(left); x < wide - left; ++x) {
      const n = row + Math.min(width - 1, (x - left) / scale | 0);
      pixels[y * wide + x] = own ? own[n] : colours[levels[n]];
    }
  }
}

function drawPoints(wide, high, inColours) {
  const { width, height, depths, greys, nearest, step } = cloud, { view, size } = lens();
  const [a, b, , c, d, e, , f, g, h, , i, j, k, , l] = view, [right, down] = [wide / 2, high / 2];
  const far = 255.99 / (pivot.far - pivot.near || 1), begun = performance.now();
  const ray = rays, nearer = behind, colours = pixels, between = every, side = between * size;
  nearer.fill(Infinity);
  for (let first = 0; first < width * height; first += between * width) {
    for (let n = first; n < first + width; n += between) {
      const steps = depths[n];
      if (steps === 0) continue;
      const z = nearest + (steps - 1) * step, x = ray[2 * n] * z, y = ray[2 * n + 1] * z;
      const w = c * x + f * y + i * z + l, part = 1 / w;
      const edge = Math.ceil(Math.max(1, Math.min(40, side * z * part)));
      const left = ((a * x + d * y + g * z + j) * part + 1) * right - edge / 2 | 0;
      const top = (1 - (b * x + e * y + h * z + k) * part) * down - edge / 2 | 0;
      if (w <= 0 || left < 0 || top < 0 || left + edge > wide || top + edge > high) continue;
      let colour = tints ? tints[n] : greyColours[greys[n]];
      if (inColours) {
        const tint = 3 * Math.max(0, Math.min(255, (z - pivot.near) * far | 0));
        const lit = .6 + .4 * (greyColours[greys[n]] & 255) / 255;
        colour = 0xff000000 | palette[tint + 2] * lit << 16 | palette[tint + 1] * lit << 8 |
                 palette[tint] * lit;
      }
      for (let row = top * wide + left; row < (top + edge) * wide; row += wide) {
        for (let at = row; at < row + edge; ++at) {
          if (w >= nearer[at]) continue;
          nearer[at] = w;
          colours[at] = colour;
        }
      }
    }
  }
  const took = performance.now() - begun;
  every = Math.max(1, Math.min(8, every + (took > 25) - (took < 10)));
}

// Histogram of grey levels; the most frequent fills the height.
function drawHistogram() {
  const chart = at('histogram'), pen = chart.getContext('2d'), counts = new Uint32Array(256);
  for (const grey of cloud.greys) ++counts[grey];
  const most = counts.slice(1, 255).reduce((a, b) => Math.max(a, b), 1);
  pen.clearRect(0, 0, 256, 64);
  pen.fillStyle = getComputedStyle(chart).color;
  counts.forEach((count, grey) => pen.fillRect(grey, 64, 1, -64 * Math.min(1, count / most)));
}

