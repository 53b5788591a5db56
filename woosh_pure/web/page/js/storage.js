// Values that the browser keeps for this page. Where it keeps none, they are gone with the page.

export function kept(key, storage = "localStorage") {
  try {
    return globalThis[storage].getItem(key);
  } catch {
    return null;
  }
}

export function keep(key, value, storage = "localStorage") {
  try {
    globalThis[storage].setItem(key, value);
  } catch { /* nothing is kept */ }
}

// The session of this tab, through a reload, so that the page keeps its goals. It is not stored while the page is open, so that
// a copied tab gets a new session.
export function takeSession() {
  const session = kept("woosh-session", "sessionStorage");
  keep("woosh-session", "", "sessionStorage");
  return session || null;
}

export const keepSession = (session) => session && keep("woosh-session", session, "sessionStorage");
