// What the page asks of the server; paths are relative to the address with its token.

/** @param seconds after which a connection that says nothing counts as lost: a tunnel may die without a word. */
export async function get(path, seconds) {
  const answer = await fetch(path, seconds ? { signal: AbortSignal.timeout(1000 * seconds) } : {});
  if (!answer.ok) throw new Error((await answer.text()).trim() || `status ${answer.status}`);
  return answer.json();
}

export async function bytes(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error((await answer.text()).trim() || `status ${answer.status}`);
  return answer.arrayBuffer();
}

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
