// Decodes what report/packed_array.cpp writes.

async function inflated(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; ++i) bytes[i] = letters.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Type is Uint16Array or Uint32Array. */
export async function unpacked(name, Type, columns) {
  const holder = document.getElementById(`blob-${name}`);
  if (!holder) throw new Error(`the page holds no array ${name}`);
  const planes = await inflated(holder.textContent);
  const width = Type.BYTES_PER_ELEMENT;
  const count = planes.length / width;
  const values = new Type(count);
  for (let i = 0; i < count; ++i) {
    let difference = 0;
    for (let b = 0; b < width; ++b) difference |= planes[b * count + i] << (8 * b);
    values[i] = i >= columns ? values[i - columns] + difference : difference;  // wraps, as it was packed
  }
  return values;
}
