// Colours that are distinguishable with any colour vision: light and dark, blue and orange.

const hex = (word) => [1, 3, 5].map((k) => parseInt(word.slice(k, k + 2), 16));
// cividis (Nunez, Anderton, Renslow 2018), and blue - white - brown after ColorBrewer's PuOr and RdBu.
const sequential = ['#00224e', '#123570', '#3b496c', '#575d6d', '#707173', '#8a8678', '#a59c74', '#c3b369', '#e1cc55', '#fee838'].map(hex);
const diverging = ['#053061', '#2166ac', '#6aacd0', '#bfd7e6', '#e8e8e5', '#efcda6', '#e0924a', '#b35806', '#6f2f05'].map(hex);
// Okabe and Ito 2008, without black.
export const categories = ['#56b4e9', '#e69f00', '#009e73', '#f0e442', '#0072b2', '#d55e00', '#cc79a7', '#bbbbbb'].map(hex);
export const plain = [196, 200, 206];

function sample(map, at) {
  const x = Math.min(1, Math.max(0, at)) * (map.length - 1);
  const k = Math.min(map.length - 2, Math.floor(x));
  return [0, 1, 2].map((c) => map[k][c] + (x - k) * (map[k + 1][c] - map[k][c]));
}

const tableOf = (map) => {
  const table = new Uint8Array(256 * 3);
  for (let i = 0; i < 256; ++i) sample(map, i / 255).forEach((v, c) => { table[3 * i + c] = Math.round(v); });
  return table;
};
const tables = { sequential: tableOf(sequential), diverging: tableOf(diverging) };

/** The range of a colour scale: {low, high, map}. Signed values are centred on zero. */
export function scaleOf(values, signed, robust) {
  let low = Infinity, high = -Infinity;
  let seen = values;
  if (robust && values.length > 50) {  // a few extreme vertices would leave the rest without contrast
    const sorted = Float32Array.from(values).sort();
    seen = [sorted[Math.floor(0.01 * (sorted.length - 1))], sorted[Math.ceil(0.99 * (sorted.length - 1))]];
  }
  for (const v of seen) { low = Math.min(low, v); high = Math.max(high, v); }
  if (!(high >= low)) return { low: 0, high: 1, map: 'sequential' };
  if (!signed) return { low, high: high > low ? high : low + (Math.abs(low) || 1) * 1e-9, map: 'sequential' };
  const most = Math.max(Math.abs(low), Math.abs(high)) || 1e-300;
  return { low: -most, high: most, map: 'diverging' };
}

export function colorAt(scale, value, out, at) {
  const i = Math.min(255, Math.max(0, Math.round((255 * (value - scale.low)) / (scale.high - scale.low)))) || 0;
  const table = tables[scale.map];
  out[at] = table[3 * i]; out[at + 1] = table[3 * i + 1]; out[at + 2] = table[3 * i + 2];
}

export const gradient = (map) =>
  `linear-gradient(to right, ${(map === 'sequential' ? sequential : diverging).map((c) => `rgb(${c.join(',')})`).join(', ')})`;

export const css = (color) => `rgb(${color.map(Math.round).join(',')})`;

/** A category per patch such that neighbours differ, as far as eight colours allow. */
export function patchColors(label, patches, triangles) {
  const beside = Array.from({ length: patches }, () => new Set());
  const owner = new Map();
  let many = 1;  // vertices: keys of edges stay whole numbers
  for (const v of triangles) many = Math.max(many, v + 1);
  for (let t = 0; t < label.length; ++t)
    for (let k = 0; k < 3; ++k) {
      const a = triangles[3 * t + k], b = triangles[3 * t + ((k + 1) % 3)];
      const edge = Math.min(a, b) * many + Math.max(a, b);
      const other = owner.get(edge);
      if (other === undefined) owner.set(edge, label[t]);
      else if (other !== label[t]) { beside[other].add(label[t]); beside[label[t]].add(other); }
    }
  const chosen = new Array(patches).fill(-1);
  for (let p = 0; p < patches; ++p) {
    const taken = new Set([...beside[p]].map((q) => chosen[q]));
    let c = p % categories.length;
    for (let k = 0; k < categories.length && taken.has(c); ++k) c = (c + 1) % categories.length;
    chosen[p] = c;
  }
  return chosen.map((c) => categories[c]);
}
