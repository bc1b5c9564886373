// The viewer of grains: grains with all of their spheres, forces, force chains, bonds and cracks in three dimensions, by WebGL 2, without anything
// from elsewhere. `stage(title)` makes the elements that it fills, and `show(root, data)` fills them; `granum_report::viewer` makes the data.

const bytes = text => Uint8Array.from(atob(text || ""), c => c.charCodeAt(0)).buffer;

// Vectors and matrices, by columns.
const sub = (a, b) => a.map((x, k) => x - b[k]), dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => { const l = Math.hypot(...a) || 1; return a.map(x => x / l); };
function lookAt(eye, target, up) {
  const z = unit(sub(eye, target)), x = unit(cross(up, z)), y = cross(z, x);
  return [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, -dot(x, eye), -dot(y, eye), -dot(z, eye), 1];
}
function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2), d = near - far;
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / d, -1, 0, 0, 2 * far * near / d, 0];
}

const COLOURS = `vec3 colour(float t) {
  const vec3 c[5] = vec3[5](vec3(.267,.005,.329), vec3(.229,.322,.546), vec3(.128,.567,.551), vec3(.369,.789,.383), vec3(.993,.906,.144));
  float s = clamp(t, 0., 1.) * 4.; int k = min(int(s), 3); return mix(c[k], c[k + 1], s - float(k)); }`;
const LIGHT = `vec3 lit(vec3 c, vec3 n) { float d = max(dot(n, normalize(vec3(.35, .6, .75))), 0.); return c * (.42 + .58 * d) + vec3(.12) * pow(d, 24.); }`;
const HEAD = "#version 300 es\nprecision highp float;\n";
const SHADERS = {
  // A sphere is a square that faces the eye; its fragments find where their ray meets the sphere.
  grains: [HEAD + `layout(location=0) in vec2 corner; layout(location=1) in vec3 place; layout(location=2) in vec2 form;
uniform mat4 view, projection; uniform vec3 box, origin; uniform float largest, size, cut; out vec3 ray; flat out vec4 ball; flat out float value;
void main() { vec3 p = origin + place * box; vec3 c = (view * vec4(p, 1.)).xyz; float r = form.x * largest * size; ball = vec4(c, r); value = form.y;
  float d2 = dot(c, c); vec3 w = normalize(-c), x = normalize(cross(vec3(0., 1., 0.), w)), y = cross(w, x);
  ray = c + (corner.x * x + corner.y * y) * r * sqrt(d2 / max(d2 - r * r, 1e-3 * d2));
  gl_Position = place.y < cut ? vec4(2., 2., 2., 1.) : projection * vec4(ray, 1.); }`,
  HEAD + COLOURS + LIGHT + `in vec3 ray; flat in vec4 ball; flat in float value; uniform mat4 projection; uniform float opacity; out vec4 ink;
void main() { vec3 d = normalize(ray); float b = dot(d, ball.xyz), q = b * b - dot(ball.xyz, ball.xyz) + ball.w * ball.w; if (q < 0.) discard;
  vec3 p = d * (b - sqrt(q)); vec4 z = projection * vec4(p, 1.); gl_FragDepth = .5 * z.z / z.w + .5;
  ink = vec4(lit(colour(value), (p - ball.xyz) / ball.w), opacity); }`],
  // A force is a tube along the branch.
  forces: [HEAD + `layout(location=0) in vec3 ring; layout(location=1) in vec3 place; layout(location=2) in vec3 branch; layout(location=3) in vec2 force;
uniform mat4 view, projection; uniform vec3 box, origin; uniform float longest, width, cut, only; out vec3 normal; flat out vec2 about;
void main() { vec3 a = origin + place * box, l = branch * longest, w = normalize(l), x = normalize(cross(w, abs(w.z) < .9 ? vec3(0., 0., 1.) : vec3(1., 0., 0.))), y = cross(w, x);
  vec3 n = ring.x * x + ring.y * y; about = force; normal = (view * vec4(n, 0.)).xyz;
  gl_Position = (only > .5 && force.y < .5) || place.y < cut ? vec4(2., 2., 2., 1.) : projection * view * vec4(a + l * ring.z + n * width * abs(force.x), 1.); }`,
  HEAD + LIGHT + `in vec3 normal; flat in vec2 about; uniform vec3 tint; out vec4 ink;
void main() { vec3 weak = vec3(.55, .6, .66), strong = vec3(.80, .18, .15), pull = vec3(.15, .35, .80), chain = vec3(.96, .58, .08);
  vec3 c = about.x < 0. ? pull : mix(weak, strong, smoothstep(.05, .5, about.x)); ink = vec4(lit(tint.x > 0. ? tint : about.y > .5 ? chain : c, normalize(normal)), 1.); }`],
  // A crack is a disc across the bond that ruptured.
  cracks: [HEAD + `layout(location=0) in vec2 ring; layout(location=1) in vec3 place; layout(location=2) in vec3 across; layout(location=3) in vec2 form;
uniform mat4 view, projection; uniform vec3 box, origin; uniform float largest, cut; out vec3 normal; flat out float shear;
void main() { vec3 w = normalize(across), x = normalize(cross(w, abs(w.z) < .9 ? vec3(0., 0., 1.) : vec3(1., 0., 0.))), y = cross(w, x);
  normal = (view * vec4(w, 0.)).xyz; shear = form.y; vec3 p = origin + place * box + (ring.x * x + ring.y * y) * form.x * largest;
  gl_Position = place.y < cut ? vec4(2., 2., 2., 1.) : projection * view * vec4(p, 1.); }`,
  HEAD + LIGHT + `in vec3 normal; flat in float shear; out vec4 ink;
void main() { vec3 n = normalize(normal); ink = vec4(lit(shear > .5 ? vec3(.48, .25, .70) : vec3(.90, .30, .12), n.z < 0. ? -n : n), 1.); }`],
  lines: [HEAD + `layout(location=0) in vec3 place; uniform mat4 view, projection; void main() { gl_Position = projection * view * vec4(place, 1.); }`,
  HEAD + `uniform vec3 line; out vec4 ink; void main() { ink = vec4(line, 1.); }`],
};

function program(gl, [vertex, fragment]) {
  const made = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source); gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  const places = {};
  for (let k = 0; k < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); k++) {
    const name = gl.getActiveUniform(made, k).name;
    places[name] = gl.getUniformLocation(made, name);
  }
  return { made, places };
}
// An array of vertices: attributes as [location, numbers, type, scaled, stride, offset, each instance].
function vertices(gl, content, attributes) {
  const buffer = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer); gl.bufferData(gl.ARRAY_BUFFER, content, gl.STATIC_DRAW);
  for (const [location, numbers, type, scaled, stride, offset, each] of attributes) {
    gl.enableVertexAttribArray(location); gl.vertexAttribPointer(location, numbers, type, scaled, stride, offset);
    gl.vertexAttribDivisor(location, each ? 1 : 0);
  }
  return buffer;
}
function start(root, by, first, canvas, gl) {
  const programs = Object.fromEntries(Object.entries(SHADERS).map(([name, sources]) => [name, program(gl, sources)]));
  const arrays = {}, U = gl.UNSIGNED_SHORT, I = gl.SHORT, F = gl.FLOAT, SIDES = 10, ROUND = 20;
  const tube = [], disc = [0, 0];
  for (let k = 0; k <= SIDES; k++) { const a = 2 * Math.PI * k / SIDES; for (const z of [0, 1]) tube.push(Math.cos(a), Math.sin(a), z); }
  for (let k = 0; k <= ROUND; k++) { const a = 2 * Math.PI * k / ROUND; disc.push(Math.cos(a), Math.sin(a)); }
  // Each array has its own buffers, which go with it when other data come in its place.
  const array = (name, ...parts) => {
    if (arrays[name]) { gl.deleteVertexArray(arrays[name].made); arrays[name].buffers.forEach(buffer => gl.deleteBuffer(buffer)); }
    const made = gl.createVertexArray();
    gl.bindVertexArray(made);
    arrays[name] = { made, buffers: parts.map(([content, attributes]) => vertices(gl, content, attributes)) };
  };
  const lines = [[1, 3, U, true, 16, 0, true], [2, 3, I, true, 16, 6, true], [3, 2, I, true, 16, 12, true]];
  let data, middle, extent;
  function fill(next) {
    data = next;
    array("grains", [new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]), [[0, 2, F, false, 8, 0, false]]],
      [bytes(data.grains), [[1, 3, U, true, 10, 0, true], [2, 2, U, true, 10, 6, true]]]);
    array("forces", [new Float32Array(tube), [[0, 3, F, false, 12, 0, false]]], [bytes(data.forces), lines]);
    array("bonds", [new Float32Array(tube), [[0, 3, F, false, 12, 0, false]]], [bytes(data.bonds), lines]);
    array("cracks", [new Float32Array(disc), [[0, 2, F, false, 8, 0, false]]], [bytes(data.cracks), lines]);
    const [a, b, c] = data.cell, corner = (i, j, k) => a.map((x, n) => data.start[n] + i * x + j * b[n] + k * c[n]), ends = [];
    for (let edge = 0; edge < 3; edge++) for (const [i, j] of [[0, 0], [0, 1], [1, 0], [1, 1]]) for (const k of [0, 1]) {
      const at = [i, j];
      at.splice(edge, 0, k);
      ends.push(...corner(...at));
    }
    array("lines", [new Float32Array(ends), [[0, 3, F, false, 12, 0, false]]]);
    middle = corner(.5, .5, .5); extent = Math.hypot(...a.map((x, n) => x + b[n] + c[n]));
  }
  fill(first);
  const eye = { turn: .65, tilt: .35, far: 1.45 * extent };
  function draw() {
    const ratio = window.devicePixelRatio || 1, w = Math.max(1, Math.round(canvas.clientWidth * ratio)), h = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
    const dark = matchMedia("(prefers-color-scheme: dark)").matches, back = dark ? [.086, .098, .114] : [1, 1, 1];
    gl.viewport(0, 0, w, h); gl.clearColor(...back, 1); gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT); gl.enable(gl.DEPTH_TEST);
    const { turn, tilt, far } = eye;
    const from = [middle[0] + far * Math.cos(tilt) * Math.sin(turn), middle[1] - far * Math.cos(tilt) * Math.cos(turn), middle[2] + far * Math.sin(tilt)];
    const common = { view: lookAt(from, middle, [0, 0, 1]), projection: perspective(.7, w / h, .02 * extent, far + 2 * extent) };
    const use = (name, more, shown = name) => {
      const { made, places } = programs[name];
      gl.useProgram(made); gl.bindVertexArray(arrays[shown].made);
      for (const [key, value] of Object.entries({ ...common, ...more })) {
        const at = places[key];
        if (at === undefined) continue;
        if (value.length === 16) gl.uniformMatrix4fv(at, false, value); else if (value.length === 3) gl.uniform3fv(at, value); else gl.uniform1f(at, value);
      }
    };
    const cut = Number(by("cut").value);
    use("lines", { line: dark ? [.45, .5, .55] : [.6, .64, .7] }); gl.drawArrays(gl.LINES, 0, 24);
    if (by("forces").checked && data.contacts) {
      use("forces", { box: data.box, origin: data.origin, longest: data.longest, width: data.width, cut, only: by("chains").checked ? 1 : 0, tint: [0, 0, 0] });
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 2 * SIDES + 2, data.contacts);
    }
    if (by("bonds").checked && data.bonds_shown) {
      use("forces", { box: data.box, origin: data.origin, longest: data.longest_bond, width: data.widest_bond, cut, only: 0, tint: dark ? [.45, .62, .58] : [.36, .54, .50] }, "bonds");
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 2 * SIDES + 2, data.bonds_shown);
    }
    if (by("cracks").checked && data.cracks_shown) {
      use("cracks", { box: data.box, origin: data.origin, largest: data.largest_crack, cut });
      gl.drawArraysInstanced(gl.TRIANGLE_FAN, 0, ROUND + 2, data.cracks_shown);
    }
    const opacity = Number(by("opacity").value);
    if (by("grains").checked && data.count && opacity > 0) {
      use("grains", { box: data.box, origin: data.origin, largest: data.largest, size: Number(by("size").value), opacity, cut });
      const grains = () => gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, data.count);
      if (opacity < 1) {
        // What is behind shows through the foremost grains: their depths first, then their colours.
        gl.colorMask(false, false, false, false); grains(); gl.colorMask(true, true, true, true);
        gl.enable(gl.BLEND); gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ZERO, gl.ONE); gl.depthFunc(gl.LEQUAL);
      }
      grains(); gl.disable(gl.BLEND); gl.depthFunc(gl.LESS);
    }
    canvas.dataset.drawn = String(Number(canvas.dataset.drawn || 0) + 1);
  }
  let due = false;
  const soon = () => { if (!due) { due = true; requestAnimationFrame(() => { due = false; draw(); }); } };
  const move = (turn, tilt, nearer) => {
    eye.turn += turn; eye.tilt = Math.max(-1.55, Math.min(1.55, eye.tilt + tilt));
    eye.far = Math.max(.3 * extent, Math.min(6 * extent, eye.far * nearer)); soon();
  };
  const touched = new Map();
  canvas.addEventListener("pointerdown", e => { canvas.setPointerCapture(e.pointerId); touched.set(e.pointerId, [e.clientX, e.clientY]); });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, e => touched.delete(e.pointerId));
  canvas.addEventListener("pointermove", e => {
    const before = touched.get(e.pointerId);
    if (!before) return;
    const spread = () => { const [p, q] = [...touched.values()]; return Math.hypot(p[0] - q[0], p[1] - q[1]) || 1; };
    const old = touched.size === 2 ? spread() : 0;
    touched.set(e.pointerId, [e.clientX, e.clientY]);
    if (touched.size === 2) move(0, 0, old / spread()); else move((before[0] - e.clientX) * .008, (e.clientY - before[1]) * .008, 1);
  });
  canvas.addEventListener("wheel", e => { e.preventDefault(); move(0, 0, Math.exp(.001 * e.deltaY)); }, { passive: false });
  const keys = { ArrowLeft: [.1, 0, 1], ArrowRight: [-.1, 0, 1], ArrowUp: [0, .1, 1], ArrowDown: [0, -.1, 1], "+": [0, 0, .9], "-": [0, 0, 1.1] };
  canvas.addEventListener("keydown", e => { if (keys[e.key]) { e.preventDefault(); move(...keys[e.key]); } });
  for (const input of root.querySelectorAll("#panel input")) input.addEventListener("input", soon);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", soon);
  // At once, before a page of another size is shown: the picture would be stretched.
  new ResizeObserver(draw).observe(canvas);
  draw();
  return next => { fill(next); soon(); };
}
// The elements: a canvas, and a panel with what can be switched, a scale of colours and a note. Texts become text.
export function stage(title) {
  const made = (name, attributes, ...children) => {
    const element = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) if (value !== false) element.setAttribute(key, value === true ? "" : value);
    element.append(...children);
    return element;
  };
  const box = (id, text, checked) => made("label", {}, made("input", { type: "checkbox", id, checked }), text);
  const slider = (id, min, value) => made("label", {}, id, made("input", { type: "range", id, min, max: 1, step: 0.01, value }));
  const help = "turn with the mouse or the arrow keys, nearer and farther with the wheel or plus and minus";
  return made("div", { id: "stage" },
    made("canvas", { id: "view", tabindex: "0", role: "img", "aria-label": `${title}: ${help}` }),
    made("div", { id: "panel" },
      box("grains", "grains", true), slider("opacity", 0, 0.25), slider("size", 0.1, 1), slider("cut", 0, 0),
      box("forces", "forces", true), box("chains", "force chains alone", false), box("bonds", "bonds", true), box("cracks", "cracks", true),
      made("div", { class: "scale" }, made("div", { id: "scale" }),
        made("div", { id: "ends" }, made("span", { id: "low" }), made("span", { id: "name" }), made("span", { id: "high" }))),
      made("p", { id: "note" })));
}
// Shows what `data` holds in the elements of a page: `view` is the canvas, and the inputs of the panel have the names below. What it returns shows other
// data in its place, as of a run under way; the eye and what is switched on stay.
export function show(root, data) {
  const by = id => root.querySelector(`#${id}`), say = text => { by("note").textContent = text; };
  const label = data => {
    by("bonds").parentElement.hidden = !data.bonds_shown; by("cracks").parentElement.hidden = !data.cracks_shown;
    by("low").textContent = data.low; by("high").textContent = data.high; by("name").textContent = data.colour;
    say(data.note);
  };
  by("opacity").value = data.opacity; by("forces").checked = data.forces_shown; by("chains").checked = data.chains_alone; by("cracks").checked = data.cracks_first;
  by("scale").style.background = "linear-gradient(90deg, rgb(68,1,84), rgb(58,82,139), rgb(33,145,140), rgb(94,201,98), rgb(253,231,37))";
  label(data);
  const canvas = by("view"), gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) { say("This browser has no WebGL 2, which the view needs."); return () => {}; }
  try {
    const update = start(root, by, data, canvas, gl);
    return next => { label(next); update(next); };
  } catch (error) { say(String(error)); return () => {}; }
}
