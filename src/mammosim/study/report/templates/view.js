// Bodies of tetrahedra: choose one, colour it by a field, cut it, turn it. plotly.js draws the faces that are seen.
// Each woman's bodies come from a script of her own, view/NAME.js, which calls mammosim.show.
"use strict";
const FACES = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
const AXES = ["x", "y", "z"];
const NARROW = matchMedia("(max-width: 860px)").matches;
const AWAY = NARROW ? 1.5 : 1; // on a phone the whole body fits, too
const FRONT = { eye: { x: 0.7 * AWAY, y: -1.6 * AWAY, z: 0.35 * AWAY }, up: { x: 0, y: 0, z: 1 }, center: { x: 0, y: 0, z: 0 } };
const LIGHT = { ambient: 0.55, diffuse: 0.6, specular: 0.03, roughness: 0.9, facenormalsepsilon: 0 };
const FROM = { x: -30000, y: -100000, z: 60000 }; // before her, from above
const TISSUES = JSON.parse(document.getElementById("tissues").textContent);
const PLACE = new Map(TISSUES.map(([number], place) => [number, place]));
const control = (id) => document.getElementById(id);
const women = new Map();

// ---- From text to numbers.
function bytes(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer;
}

function readTopology({ bits, corners, tissue }) {
  const four = Uint32Array.from(new (bits === 16 ? Uint16Array : Uint32Array)(bytes(corners)));
  return { four, tissue: new Uint8Array(bytes(tissue)), beside: neighbours(four) };
}

function readBody(body) {
  const steps = new Uint16Array(bytes(body.points));
  const along = (axis) => Float32Array.from({ length: steps.length / 3 }, (_, i) =>
    body.low[axis] + (body.high[axis] - body.low[axis]) * steps[3 * i + axis] / 65535);
  return { ...body, points: AXES.map((_, axis) => along(axis)) };
}

// The tetrahedron beyond each face 4 t + f of tetrahedron t, or -1.
function neighbours(four) {
  const beside = new Int32Array(four.length).fill(-1);
  const open = new Map();
  for (let face = 0; face < four.length; face += 1) {
    const key = cornersOf(four, face).sort((a, b) => a - b).join();
    const other = open.get(key);
    if (other === undefined) open.set(key, face);
    else {
      beside[face] = other >> 2;
      beside[other] = face >> 2;
    }
  }
  return beside;
}

function cornersOf(four, face) {
  const start = face & ~3;
  return FACES[face & 3].map((corner) => four[start + corner]);
}

// ---- A cut keeps the tetrahedra whose middle is below it; what is drawn are the faces between kept and not kept.
function keptBelow({ four }, points, limit) {
  return Uint8Array.from({ length: four.length / 4 }, (_, t) =>
    (points[four[4 * t]] + points[four[4 * t + 1]] + points[four[4 * t + 2]] + points[four[4 * t + 3]]) / 4 <= limit);
}

function seenFaces({ four, beside }, kept) {
  const seen = [];
  for (let face = 0; face < four.length; face += 1) {
    if (kept[face >> 2] && (beside[face] < 0 || !kept[beside[face]])) seen.push(face);
  }
  return seen;
}

// ---- Fields: of each cell, of faces of the skin, or of the corners.
function valuesOf(body, name, seen, woman) {
  if (name === "tissue") return seen.map((face) => PLACE.get(woman.topologies[body.topology].tissue[face >> 2]) ?? 0);
  if (name === "displacement") return displacement(body, woman);
  const { values, faces, high } = body.fields[name];
  const steps = new Uint8Array(bytes(values));
  if (!faces) return seen.map((face) => steps[face >> 2] * high / 255);
  const at = new Map([...new Uint32Array(bytes(faces))].map((face, i) => [face, steps[i] * high / 255]));
  return seen.map((face) => at.get(face) ?? 0);
}

function measured(body, woman) {
  return woman.bodies.find((other) => other.topology === body.topology);
}

function displacement(body, woman) {
  const from = measured(body, woman).points;
  return [...body.points[0]].map((_, i) => Math.hypot(...AXES.map((__, axis) => body.points[axis][i] - from[axis][i])));
}

function fieldsOf(body, woman) {
  const own = Object.entries(body.fields).map(([name, { label }]) => [name, label]);
  const from = measured(body, woman);
  return [["tissue", "tissue"], ...own, ...(from === body ? [] : [["displacement", `displacement from ${from.name}`]])];
}

// One colour bar for all bodies of a group, so that they can be compared.
function colours(body, name, values, woman) {
  if (name === "tissue") return tissueColours();
  const alike = woman.bodies.filter((other) => other.group === body.group && other.fields[name]);
  const highest = name === "displacement" ? values : alike.map((other) => other.fields[name].high);
  const high = highest.reduce((a, b) => Math.max(a, b), 0);
  const { label, unit } = name === "displacement" ? { label: "displacement", unit: "mm" } : body.fields[name];
  const colorscale = name === "pressure_kpa" ? "YlOrRd" : "Viridis";
  return { cmin: 0, cmax: high, colorscale, reversescale: name === "pressure_kpa", colorbar: bar(unit ? `${label} (${unit})` : label) };
}

function bar(text) {
  if (NARROW) return { title: { text, side: "top" }, orientation: "h", y: -0.02, thickness: 12 };
  return { title: { text, side: "right" }, len: 0.8, thickness: 16 };
}

function tissueColours() {
  const share = (i) => i / TISSUES.length;
  const colorscale = TISSUES.flatMap(([, , colour], i) => [[share(i), colour], [share(i + 1), colour]]);
  const names = { tickvals: [...TISSUES.keys()], ticktext: TISSUES.map(([, name]) => name) };
  return { cmin: -0.5, cmax: TISSUES.length - 0.5, colorscale, colorbar: { ...bar("tissue"), ...names } };
}

// ---- Drawing.
function current() {
  const woman = women.get(control("volunteer").value);
  return { woman, body: woman?.bodies[control("body").value], field: control("field").value, axis: Number(control("axis").value) };
}

function limitOf(body, axis) {
  const part = Number(control("cut").value) / 100;
  return part === 1 ? Infinity : body.low[axis] + part * (body.high[axis] - body.low[axis]);
}

function draw() {
  const { woman, body, field, axis } = current();
  if (!body) return;
  const topology = woman.topologies[body.topology];
  const limit = limitOf(body, axis);
  const seen = seenFaces(topology, keptBelow(topology, body.points[axis], limit));
  const values = valuesOf(body, field, seen, woman);
  const scale = colours(body, field, values, woman);
  Plotly.react(control("plot"), [trace(topology, body, seen, values, scale, field)], layoutOf(body), { displaylogo: false, responsive: true });
  tell(body, field, axis, limit, seen.length, scale);
}

function trace({ four }, body, seen, values, scale, field) {
  const [i, j, k] = [0, 1, 2].map((corner) => seen.map((face) => cornersOf(four, face)[corner]));
  const [x, y, z] = body.points;
  const intensitymode = field === "displacement" ? "vertex" : "cell";
  const look = { flatshading: true, lighting: LIGHT, lightposition: FROM, hoverinfo: "skip" };
  return { type: "mesh3d", x, y, z, i, j, k, intensity: values, intensitymode, ...look, ...scale };
}

function layoutOf(body) {
  const ink = getComputedStyle(document.body).color;
  const side = (title, axis) => ({ title: { text: title }, range: padded(body.low[axis], body.high[axis]), backgroundcolor: "rgba(0,0,0,0)", gridcolor: "#8888", color: ink });
  const scene = { aspectmode: "data", camera: FRONT, xaxis: side("x (mm)", 0), yaxis: side("y (mm)", 1), zaxis: side("z (mm)", 2) };
  return { scene, uirevision: "same", margin: { l: 0, r: 0, t: 0, b: 0 }, paper_bgcolor: "rgba(0,0,0,0)", font: { color: ink, size: 12 } };
}

function padded(low, high) {
  return [low - 5, high + 5];
}

function tell(body, field, axis, limit, faces, scale) {
  const most = body.fields[field]?.most;
  const cut = Number.isFinite(limit) ? `${AXES[axis]} = ${limit.toFixed(0)} mm` : "not cut";
  control("where").textContent = cut;
  const range = most === undefined ? "" : `; at most ${most} ${body.fields[field].unit}`.trimEnd();
  control("told").textContent = `${control("volunteer").value}, ${body.name}: ${scale.colorbar.title.text}${range}; ${cut}; ${faces} faces.`;
}

// ---- Turning by buttons and keys.
function isDrawn() {
  return Boolean(control("plot")._fullLayout?.scene);
}

function turn(degrees, tilt) {
  const plot = control("plot");
  const camera = structuredClone(plot._fullLayout.scene._scene.getCamera());
  const { x, y, z } = camera.eye;
  const distance = Math.hypot(x, y, z);
  const around = Math.atan2(y, x) + degrees * Math.PI / 180;
  const up = Math.max(-1.5, Math.min(1.5, Math.asin(z / distance) + tilt * Math.PI / 180));
  camera.eye = { x: distance * Math.cos(up) * Math.cos(around), y: distance * Math.cos(up) * Math.sin(around), z: distance * Math.sin(up) };
  Plotly.relayout(plot, { "scene.camera": camera });
}

const KEYS = { ArrowLeft: [-10, 0], ArrowRight: [10, 0], ArrowUp: [0, 10], ArrowDown: [0, -10] };

function turnByKey(event) {
  if (!KEYS[event.key] || !isDrawn()) return;
  event.preventDefault();
  turn(...KEYS[event.key]);
}

function turnByButton({ target }) {
  const how = isDrawn() && target.dataset.turn;
  if (how === "reset") Plotly.relayout(control("plot"), { "scene.camera": FRONT });
  else if (how) turn(...how.split(" ").map(Number));
}

// ---- Choosing.
function fill(select, pairs, before) {
  select.replaceChildren(...pairs.map(([value, text]) => new Option(text, value)));
  if (pairs.some(([value]) => String(value) === before)) select.value = before;
}

function fillBodies(woman) {
  const groups = Map.groupBy ? Map.groupBy(woman.bodies.keys(), (i) => woman.bodies[i].group) : new Map([["", [...woman.bodies.keys()]]]);
  control("body").replaceChildren(...[...groups].map(([label, numbers]) => {
    const group = Object.assign(document.createElement("optgroup"), { label });
    group.append(...numbers.map((i) => new Option(woman.bodies[i].name, i)));
    return group;
  }));
}

function choose() {
  const { woman, body } = current();
  fill(control("field"), fieldsOf(body, woman), control("field").value);
  draw();
}

function showWoman(name) {
  const woman = women.get(name);
  control("absent").replaceChildren(...woman.absent.map((text) => Object.assign(document.createElement("p"), { textContent: text })));
  if (!woman.bodies.length) return say(`There is no body of ${name}.`);
  fillBodies(woman);
  choose();
}

// In the place of a body: nothing is left of the one before to choose or to turn.
function say(text) {
  control("told").textContent = text;
  for (const id of ["body", "field", "where"]) control(id).replaceChildren();
  Plotly.purge(control("plot"));
}

function sayOf(name, text) {
  if (control("volunteer").value === name) say(text);
}

function load(name) {
  if (women.has(name)) return showWoman(name);
  control("absent").replaceChildren();
  const script = document.createElement("script");
  script.src = `view/${encodeURIComponent(name)}.js`;
  script.onerror = () => sayOf(name, `view/${name}.js is not beside this page: copy the whole folder, or run snakemake again.`);
  script.onload = () => women.has(name) || sayOf(name, `view/${name}.js holds no bodies: its log in results/logs/view says why.`);
  document.head.append(script);
}

globalThis.mammosim = {
  show(name, data) {
    women.set(name, { ...data, topologies: data.topologies.map(readTopology), bodies: data.bodies.map(readBody) });
    if (control("volunteer").value === name) showWoman(name);
  },
};

addEventListener("DOMContentLoaded", () => {
  control("volunteer").addEventListener("change", ({ target }) => load(target.value));
  control("body").addEventListener("change", choose);
  for (const id of ["field", "axis"]) control(id).addEventListener("change", draw);
  control("cut").addEventListener("input", () => requestAnimationFrame(draw));
  control("controls").addEventListener("click", turnByButton);
  control("controls").addEventListener("submit", (event) => event.preventDefault());
  control("plot").addEventListener("keydown", turnByKey);
  load(control("volunteer").value);
});
