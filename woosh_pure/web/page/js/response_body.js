// Reads the body of a response with progress. A body that stalls ends in an error.

const PIECE_BYTES = 8e6; // bytes collected before they become a Blob, which the browser may store on disk

// onProgress(part 0..1, size, total); total is 0 if unknown. stalled() returns the error to throw.
export async function collect(answer, onProgress, { seconds = 20, stalled, signal = null } = {}) {
  const type = answer.headers.get("content-type") ?? "";
  const total = Number(answer.headers.get("content-length")) || 0;
  const reader = answer.body.getReader();
  const pieces = [];
  let parts = [];
  let [size, kept] = [0, 0];
  const end = () => reader.cancel().catch(() => {});
  signal?.addEventListener("abort", end);
  try {
    for (;;) {
      const { done, value } = await within(reader.read(), seconds, stalled);
      if (signal?.aborted) throw new Error("aborted");
      if (done) break;
      parts.push(value);
      size += value.length;
      if (size - kept > PIECE_BYTES) {
        pieces.push(new Blob(parts));
        [parts, kept] = [[], size];
      }
      onProgress(total ? Math.min(1, size / total) : 0, size, total);
    }
  } catch (error) {
    end();
    throw error;
  } finally {
    signal?.removeEventListener("abort", end);
  }
  if (total && size < total) throw stalled();
  return new Blob([...pieces, ...parts], { type });
}

async function within(work, seconds, late) {
  let timer = null;
  const limit = new Promise((_, fail) => {
    timer = setTimeout(() => fail(late()), seconds * 1000);
  });
  try {
    return await Promise.race([work, limit]);
  } finally {
    clearTimeout(timer);
  }
}
