// What the page asks of the server; paths are relative to the address with its token.

export const silence = 20;  // seconds

/** @return a Blob. A connection that says nothing for so long counts as lost, and is an error: a tunnel may die without a word.
 * What the server refuses has `isAnswer`. @param seconds 0: the answer may take its time */
async function fetched(path, seconds) {
  const control = new AbortController();
  let timer = 0;
  const wait = () => { clearTimeout(timer); if (seconds) timer = setTimeout(() => control.abort(new Error('the connection is lost')), 1000 * seconds); };
  try {
    wait();
    const answer = await fetch(path, { signal: control.signal });
    if (!answer.ok) throw Object.assign(new Error((await answer.text()).trim() || `status ${answer.status}`), { isAnswer: true });
    const parts = [], reader = answer.body.getReader();
    for (let piece = await reader.read(); !piece.done; piece = await reader.read()) { parts.push(piece.value); wait(); }
    return new Blob(parts);
  } finally { clearTimeout(timer); }
}

export async function get(path, seconds = silence) { return JSON.parse(await (await fetched(path, seconds)).text()); }

export async function bytes(path, seconds = 0) { return (await fetched(path, seconds)).arrayBuffer(); }

export async function post(what, more = {}) {
  const answer = await fetch('api', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ do: what, ...more }) });
  const found = answer.headers.get('Content-Type').startsWith('application/json') ? await answer.json() : { error: (await answer.text()).trim() };
  if (found.error) throw new Error(found.error);
  return found;
}

/** Marks of triangles from base64, one bit each. */
export function marksOf(text, count) {
  const letters = atob(text), marks = new Uint8Array(count);
  for (let t = 0; t < count; ++t) marks[t] = (letters.charCodeAt(t >> 3) >> (t & 7)) & 1;
  return marks;
}

/** Only the newest of several calls counts: those in between are skipped while one is under way. */
export function newest(work) {
  let isBusy = false, waiting = null;
  return async function call(...what) {
    if (isBusy) { waiting = what; return; }
    isBusy = true;
    try { await work(...what); } finally {
      isBusy = false;
      if (waiting) { const next = waiting; waiting = null; call(...next); }
    }
  };
}
