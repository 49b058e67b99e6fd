// The airfoil in a section: edges, chord, thickness and nose radius, as core/planform/section.hpp defines them, but that
// a trailing edge without corners is the aftmost point.

const nose = 0.04;  // share of the chord that the radius is fitted to
const corner = (35 * Math.PI) / 180;

/** Turning of a line at its points; open ends count as corners. */
function turnings(line) {
  const closed = line.length > 2 && Math.hypot(line[0][0] - line[line.length - 1][0], line[0][1] - line[line.length - 1][1]) < 1e-12;
  const n = closed ? line.length - 1 : line.length;
  return Array.from({ length: n }, (_, k) => {
    if (!closed && (k === 0 || k === n - 1)) return Math.PI;
    const a = line[(k + n - 1) % n], b = line[k], c = line[(k + 1) % n];
    const u = Math.atan2(b[1] - a[1], b[0] - a[0]), w = Math.atan2(c[1] - b[1], c[0] - b[0]);
    return Math.abs(Math.atan2(Math.sin(w - u), Math.cos(w - u)));
  });
}

function solve(a, b) {
  const n = b.length;
  for (let i = 0; i < n; ++i) {
    let best = i;
    for (let k = i + 1; k < n; ++k) if (Math.abs(a[k][i]) > Math.abs(a[best][i])) best = k;
    [a[i], a[best]] = [a[best], a[i]];
    [b[i], b[best]] = [b[best], b[i]];
    if (Math.abs(a[i][i]) < 1e-300) return null;
    for (let k = i + 1; k < n; ++k) {
      const f = a[k][i] / a[i][i];
      for (let j = i; j < n; ++j) a[k][j] -= f * a[i][j];
      b[k] -= f * b[i];
    }
  }
  const x = new Array(n);
  for (let i = n - 1; i >= 0; --i) x[i] = (b[i] - a[i].slice(i + 1).reduce((sum, v, k) => sum + v * x[i + 1 + k], 0)) / a[i][i];
  return x;
}

/** Points of closed lines without their repeated end. */
const pointsOf = (lines) => lines.flatMap((line) => {
  const closed = line.length > 2 && line[0][0] === line[line.length - 1][0] && line[0][1] === line[line.length - 1][1];
  return closed ? line.slice(0, -1) : line;
});

function trailingEdge(lines) {
  const all = pointsOf(lines), aft = Math.max(...all.map((p) => p[0])), fore = Math.min(...all.map((p) => p[0]));
  const line = lines.reduce((a, b) => (Math.max(...b.map((p) => p[0])) > Math.max(...a.map((p) => p[0])) ? b : a));
  const turn = turnings(line);
  const corners = turn.map((angle, k) => [angle, line[k]]).filter(([angle, p]) => angle > corner && p[0] > aft - 0.03 * (aft - fore)).sort((a, b) => b[0] - a[0]);
  if (corners.length === 0) return { at: all.reduce((a, b) => (b[0] > a[0] ? b : a)), thickness: 0 };
  if (corners.length === 1) return { at: corners[0][1], thickness: 0 };
  const [p, q] = [corners[0][1], corners[1][1]];
  return { at: [(p[0] + q[0]) / 2, (p[1] + q[1]) / 2], thickness: Math.hypot(p[0] - q[0], p[1] - q[1]) };
}

/** Heights of upper and lower side at x of the chord's frame, or null. */
function heights(lines, x) {
  let low = Infinity, high = -Infinity;
  for (const line of lines)
    for (let k = 0; k + 1 < line.length; ++k) {
      const [a, b] = [line[k], line[k + 1]];
      if (a[0] < x === b[0] < x) continue;
      const z = a[1] + ((x - a[0]) / (b[0] - a[0])) * (b[1] - a[1]);
      low = Math.min(low, z); high = Math.max(high, z);
    }
  return high >= low ? [low, high] : null;
}

/** lines: [[x, z], ...] with x downstream and z up. {leading, trailing, chord, twist (radians, nose up), thickness (over
 * the chord), at, camber, radius (over the chord; null: the nose has too few points), lines in the chord's frame}, or null. */
export function airfoilOf(lines) {
  const all = pointsOf(lines);
  if (all.length < 3) return null;
  const { at: trailing, thickness: blunt } = trailingEdge(lines);
  let leading = all.reduce((a, b) => (Math.hypot(b[0] - trailing[0], b[1] - trailing[1]) > Math.hypot(a[0] - trailing[0], a[1] - trailing[1]) ? b : a));
  const frame = () => {
    const chord = Math.hypot(trailing[0] - leading[0], trailing[1] - leading[1]), along = [(trailing[0] - leading[0]) / chord, (trailing[1] - leading[1]) / chord];
    const to = (p) => { const u = p[0] - leading[0], w = p[1] - leading[1]; return [(u * along[0] + w * along[1]) / chord, (w * along[0] - u * along[1]) / chord]; };
    return { chord, along, to };
  };
  /** x = sum a_k z^k, z in tenths of a chord. */
  const fit = () => {
    const { to } = frame(), a = Array.from({ length: 5 }, () => new Array(5).fill(0)), b = new Array(5).fill(0);
    let count = 0;
    for (const point of all) {
      const [x, h] = to(point), z = 10 * h;
      if (x > nose) continue;
      ++count;
      const weight = (1 - x / nose) ** 2, power = Array.from({ length: 9 }, (_, k) => weight * z ** k);
      for (let i = 0; i < 5; ++i) { for (let j = 0; j < 5; ++j) a[i][j] += power[i + j]; b[i] += power[i] * x; }
    }
    if (count < 7) return null;
    const found = solve(a, b);
    return found && found[2] > 0 ? found : null;
  };
  const first = fit();
  if (first) {
    const slope = (z) => first[1] + z * (2 * first[2] + z * (3 * first[3] + z * 4 * first[4])), bend = (z) => 2 * first[2] + z * (6 * first[3] + z * 12 * first[4]);
    let z = 0;
    for (let k = 0; k < 30 && bend(z) > 0; ++k) z -= slope(z) / bend(z);
    if (bend(z) > 0 && Math.abs(z) < 0.3 && Math.abs(slope(z)) < 1e-9) {
      const { chord, along } = frame(), x = first[0] + z * (first[1] + z * (first[2] + z * (first[3] + z * first[4])));
      leading = [leading[0] + chord * (x * along[0] - 0.1 * z * along[1]), leading[1] + chord * (x * along[1] + 0.1 * z * along[0])];
    }
  }
  const { chord, along, to } = frame(), scaled = lines.map((line) => line.map(to));
  let thickness = 0, at = 0.5, camber = 0;
  for (const [x] of pointsOf(scaled)) {
    if (x < 0.005 || x > 0.99) continue;
    const found = heights(scaled, x);
    if (!found) continue;
    if (found[1] - found[0] > thickness) { thickness = found[1] - found[0]; at = x; }
    if (Math.abs(found[1] + found[0]) / 2 > Math.abs(camber)) camber = (found[1] + found[0]) / 2;
  }
  const round = fit();
  const tilt = round ? 10 * round[1] : 0, radius = round ? (1 + tilt * tilt) ** 1.5 / (200 * round[2]) : null;
  return { leading, trailing, chord, blunt, twist: -Math.atan2(along[1], along[0]), thickness, at, camber, radius: radius > 0 && radius < 1 ? radius : null, lines: scaled };
}
