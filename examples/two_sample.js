// A strapdown integrator of one's own in JavaScript: the two-sample coning algorithm, attitude only.
//
//   sinsbench score --command "node two_sample.js" --on dual_precession
//
// The increments come as CSV on standard input, the attitudes go as CSV to standard output.

const { readFileSync, writeSync } = require("node:fs");

/** Returns the quaternion, scalar first, of a rotation vector. */
function rotation(vector) {
  const angle = Math.hypot(...vector);
  const factor = angle > 0 ? Math.sin(angle / 2) / angle : 0.5;
  return [Math.cos(angle / 2), ...vector.map((x) => factor * x)];
}

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

const [header, ...rows] = readFileSync(0, "utf8").trimEnd().split("\n");
const names = header.split(",");
const places = (stem, axes) => axes.map((axis) => names.indexOf(`${stem}_${axis}`));
const angle = places("angle", ["x", "y", "z"]);
const start = places("attitude0", ["w", "x", "y", "z"]);

/** Returns the numbers in some places of a row, of which no more is taken apart than is needed. */
function numbers(row, places) {
  const cells = row.split(",", Math.max(...places) + 1);
  return places.map((place) => Number(cells[place]));
}

let attitude = numbers(rows[0], start);
const lines = ["q_w,q_x,q_y,q_z", attitude.join(",")];
for (let sample = 0; sample + 1 < rows.length; sample += 2) {
  const [first, second] = [numbers(rows[sample], angle), numbers(rows[sample + 1], angle)];
  const correction = cross(first, second);
  attitude = product(attitude, rotation(first.map((x, i) => x + second[i] + (2 / 3) * correction[i])));
  lines.push(attitude.join(","));
}
const bytes = Buffer.from(`${lines.join("\n")}\n`);
for (let written = 0; written < bytes.length; ) written += writeSync(1, bytes, written);
