// Values that the browser keeps for this page. Where it keeps none, they are gone with the page.

export function kept(key, storage = "localStorage") {
  try {
    return globalThis[storage].getItem(key);
  } catch {
    return null;
  }
}

// Keep a value; without one, the kept one is removed.
export function keep(key, value, storage = "localStorage") {
  try {
    if (value) globalThis[storage].setItem(key, value);
    else globalThis[storage].removeItem(key);
  } catch { /* nothing is kept */ }
}

const SESSION = ["woosh-session", "sessionStorage"];

// The session of this tab, through a reload, so that the page keeps its goals. It is not stored while the page is open, so that
// a copied tab gets a new session.
export function takeSession() {
  const session = kept(...SESSION);
  keepSession(null);
  return session;
}

export const keepSession = (session) => keep(SESSION[0], session, SESSION[1]);
