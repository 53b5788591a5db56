// Keeps the session of this tab through a reload, so that the page keeps its goals. It is not stored while the page is open, so
// that a copied tab gets a new session.

const KEY = "woosh-session";

export function keptSession() {
  try {
    const kept = sessionStorage.getItem(KEY);
    sessionStorage.removeItem(KEY);
    return kept;
  } catch {
    return null; // no storage
  }
}

export function keepSession(session) {
  try {
    if (session) sessionStorage.setItem(KEY, session);
  } catch { /* no storage: a new session after a reload */ }
}
