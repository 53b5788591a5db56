// The session of this tab, kept through a reload: whoever reloads stays who began the goal. It is taken out while the
// page lives, so that a copied tab becomes somebody else.

const KEY = "woosh-session";

export function keptSession() {
  try {
    const kept = sessionStorage.getItem(KEY);
    sessionStorage.removeItem(KEY);
    return kept;
  } catch {
    return null; // a browser that keeps nothing
  }
}

export function keepSession(session) {
  try {
    if (session) sessionStorage.setItem(KEY, session);
  } catch { /* somebody else after a reload */ }
}
