// The system of gyroscopic_system.py in JavaScript: vertical r and moment of the velocity K = r x v.
//
//   sinsbench score --command "node gyroscopic_system.js" --on gyro_systems
//
// The sensors come as CSV on standard input, the verticals and attitudes go as CSV to standard output.

const { readFileSync, writeSync } = require("node:fs");

/** Returns the Hamilton product. */
function product([a, b, c, d], [w, x, y, z]) {
  return [
    a * w - b * x - c * y - d * z,
    a * x + b * w + c * z - d * y,
    a * y - b * z + c * w + d * x,
    a * z + b * y - c * x + d * w,
  ];
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

const norm = (vector) => Math.hypot(...vector);
const moved = (state, slope, time) => state.map((x, i) => x + time * slope[i]);

const [header, ...rows] = readFileSync(0, "utf8").trimEnd().split("\n");
const names = header.split(",");
const table = rows.map((row) => row.split(",").map(Number));

/** Returns the numbers of a row in the columns of a vector. */
function vector(row, stem, axes = ["x", "y", "z"]) {
  return axes.map((axis) => table[row][names.indexOf(`${stem}_${axis}`)]);
}

const radius = table[0][names.indexOf("sphere_radius")];
const times = table.map((row) => row[names.indexOf("time")]);
const rates = times.map((_, row) => vector(row, "angular_rate"));
const forces = times.map((_, row) => vector(row, "specific_force"));

function slopes(state, row) {
  const [s, r, moment] = [state.slice(0, 4), state.slice(4, 7), state.slice(7)];
  const unit = s.map((x) => x / norm(s));
  const conjugate = [unit[0], -unit[1], -unit[2], -unit[3]];
  const force = product(product(unit, [0, ...forces[row]]), conjugate).slice(1);
  const rotation = product(s, [0, ...rates[row]]).map((x) => x / 2);
  return [...rotation, ...cross(moment, r).map((x) => x / radius), ...cross(r, force)];
}

const start = vector(0, "vertical0");
let state = [...vector(0, "attitude0", ["w", "x", "y", "z"]), ...start, ...cross(start, vector(0, "velocity0"))];
const lines = ["vertical_x,vertical_y,vertical_z,q_w,q_x,q_y,q_z,speed"];
for (let row = 0; ; row += 2) {
  const r = state.slice(4, 7);
  lines.push([...r.map((x) => x / norm(r)), ...state.slice(0, 4), norm(state.slice(7))].join(","));
  if (row + 2 >= times.length) break;
  const step = times[row + 2] - times[row];
  const first = slopes(state, row);
  const second = slopes(moved(state, first, step / 2), row + 1);
  const third = slopes(moved(state, second, step / 2), row + 1);
  const fourth = slopes(moved(state, third, step), row + 2);
  state = state.map((x, i) => x + (step / 6) * (first[i] + 2 * second[i] + 2 * third[i] + fourth[i]));
}
const bytes = Buffer.from(`${lines.join("\n")}\n`);
for (let written = 0; written < bytes.length; ) written += writeSync(1, bytes, written);
