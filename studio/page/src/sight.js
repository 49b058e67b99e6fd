// What is seen of a surface along one direction, by rays, not by pixels: triangles smaller than a pixel count alike.

/** Those of the triangles whose middle no other triangle hides. `view`: per vertex x, y and height towards the eye, a
 * parallel projection; `triangles`: three vertices each; `wanted`: numbers of triangles. What is nearer by at most
 * `slack` hides nothing, so that neighbours and doubled surfaces do not. */
export function unhidden(view, triangles, wanted, slack) {
  const count = wanted.length, middle = new Float64Array(3 * count);
  let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
  for (let i = 0; i < count; ++i) {
    for (let k = 0; k < 3; ++k) for (let c = 0; c < 3; ++c) middle[3 * i + c] += view[3 * triangles[3 * wanted[i] + k] + c] / 3;
    left = Math.min(left, middle[3 * i]); right = Math.max(right, middle[3 * i]);
    low = Math.min(low, middle[3 * i + 1]); high = Math.max(high, middle[3 * i + 1]);
  }
  // Cells of about one middle each; a triangle asks those that it covers.
  const side = Math.max(1, Math.floor(Math.sqrt(count))), dx = (right - left) / side || 1, dy = (high - low) / side || 1;
  const column = (x) => Math.min(side - 1, Math.max(0, Math.floor((x - left) / dx))), row = (y) => Math.min(side - 1, Math.max(0, Math.floor((y - low) / dy)));
  const begin = new Uint32Array(side * side + 1), cell = new Uint32Array(count), list = new Uint32Array(count);
  for (let i = 0; i < count; ++i) { cell[i] = row(middle[3 * i + 1]) * side + column(middle[3 * i]); ++begin[cell[i] + 1]; }
  for (let k = 0; k < side * side; ++k) begin[k + 1] += begin[k];
  const next = begin.slice();
  for (let i = 0; i < count; ++i) list[next[cell[i]]++] = i;

  const round = 1e-9;  // of a cell, or of a triangle: places on its lines
  const hidden = new Uint8Array(count), x = [0, 0, 0], y = [0, 0, 0], z = [0, 0, 0];
  for (let t = 0; 3 * t < triangles.length; ++t) {
    for (let k = 0; k < 3; ++k) { const at = 3 * triangles[3 * t + k]; x[k] = view[at]; y[k] = view[at + 1]; z[k] = view[at + 2]; }
    const whole = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
    const top = Math.max(y[0], y[1], y[2]), bottom = Math.min(y[0], y[1], y[2]);
    if (whole === 0 || top < low || bottom > high || Math.max(x[0], x[1], x[2]) < left || Math.min(x[0], x[1], x[2]) > right) continue;
    for (let r = row(bottom), last = row(top); r <= last; ++r) {
      // The triangle between the two lines of the row, so that a long thin one does not ask all cells of its box.
      const from = Math.max(bottom, r === 0 ? bottom : low + (r - round) * dy), to = Math.min(top, r === side - 1 ? top : low + (r + 1 + round) * dy);
      let first = Infinity, end = -Infinity;
      for (let k = 0; k < 3; ++k) {
        const j = (k + 1) % 3, rise = y[j] - y[k];
        if (y[k] >= from && y[k] <= to) { first = Math.min(first, x[k]); end = Math.max(end, x[k]); }
        for (const level of [from, to]) {
          if ((y[k] - level) * (y[j] - level) >= 0) continue;
          const at = x[k] + ((level - y[k]) / rise) * (x[j] - x[k]);
          first = Math.min(first, at); end = Math.max(end, at);
        }
      }
      if (first > end) continue;
      for (let i = begin[r * side + column(first - round * dx)], stop = begin[r * side + column(end + round * dx) + 1]; i < stop; ++i) {
        const m = list[i];
        if (hidden[m] || wanted[m] === t) continue;
        const px = middle[3 * m], py = middle[3 * m + 1];
        const u = ((x[1] - px) * (y[2] - py) - (x[2] - px) * (y[1] - py)) / whole, v = ((x[2] - px) * (y[0] - py) - (x[0] - px) * (y[2] - py)) / whole, w = 1 - u - v;
        // Its lines belong to it: on those between two triangles one would see through both.
        if (u > -round && v > -round && w > -round && u * z[0] + v * z[1] + w * z[2] > middle[3 * m + 2] + slack) hidden[m] = 1;
      }
    }
  }
  return wanted.filter((_, i) => !hidden[i]);
}
