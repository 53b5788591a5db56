// Makes the parts of the page and connects them. Addresses are relative, so that the page can be mounted anywhere.

import { CameraTab } from "./camera_tab.js";
import { el } from "./dom.js";
import { DriveTab } from "./drive_tab.js";
import { CostmapParts } from "./binary_frames.js";
import { Ages } from "./freshness.js";
import { GoTab } from "./go_tab.js";
import { Header } from "./header.js";
import { HealthTab } from "./health_tab.js";
import { choose, t, use } from "./i18n.js";
import { Lease } from "./lease.js";
import { LiveConnection, seconds } from "./live_connection.js";
import { LogTab } from "./log_tab.js";
import { MapView } from "./map_view.js";
import { take, takeBinary } from "./server_messages.js";
import { SimulatorTab } from "./simulator_tab.js";
import { MissionsTab } from "./missions_tab.js";
import { ReadinessNotice } from "./readiness_notice.js";
import { Plots } from "./plots.js";
import { Rest } from "./rest.js";
import { StopButton } from "./stop_button.js";
import { keepSession, kept, takeSession } from "./storage.js";
import { Store } from "./store.js";
import { Tabs } from "./tabs.js";
import { TaskCard } from "./task_card.js";
import { toast } from "./toast.js";
import { TokenDialog } from "./token_dialog.js";

const base = new URL("api/v1/", location.href.split(/[?#]/)[0]).href;
const given = new URLSearchParams(location.hash.slice(1)).get("token");
const store = new Store();
const ages = new Ages();
const parts = new CostmapParts();
const rest = new Rest(base, { onToken: () => token.ask() });
const token = new TokenDialog(rest, () => link.hurry());
rest.session = takeSession();
addEventListener("pagehide", () => keepSession(rest.session));
addEventListener("pageshow", () => takeSession()); // the browser restores a page from its cache
let before = false; // was connected before

// With its session, a page keeps its name and lease through a break.
const address = () => `${base.replace(/^http/, "ws")}live${rest.session ? `?session=${encodeURIComponent(rest.session)}` : ""}`;
const link = new LiveConnection(address, {
  text: (message) => take(store, ages, message, seconds()),
  binary: (buffer) => takeBinary(store, ages, buffer, seconds(), parts),
  state: (state, code) => {
    store.set("link", state);
    if (state === "open" && before) toast(t("lost.back"));
    if (state === "open") before = true;
    if (state === "closed") closed(code);
  },
});

// A browser does not always report why a WebSocket was refused. A REST call does, and opens the token dialog at 401.
function closed(code) {
  if (code === 4409) rest.session = null; // another tab has this session
  if (!token.open) rest.call("GET", "status", null, { timeout: 3 }).catch(() => {});
}

// A new session: the server was restarted, or this page's session has expired.
store.on("hello", (hello) => {
  const anew = rest.session !== null && rest.session !== hello.session;
  rest.session = hello.session;
  if (anew) store.set("anew", true);
});
const leaseBox = el("section", { class: "card lease", "aria-live": "polite" });
const lease = new Lease({ store, link, rest, box: leaseBox });
const tabs = new Tabs(store);
const map = new MapView({ store, ages, rest });
new Header({ store, ages, link, tabs });
new StopButton({ store, rest, link });
new GoTab({ store, rest, map, lease });
new MissionsTab({ store, rest, map });
new TaskCard({ store, rest });
new ReadinessNotice({ store, lease });
new HealthTab({ store, ages });
new Plots({ store });
new CameraTab({ store, link });
new LogTab({ store, rest, token: given });
new DriveTab({ store, link, lease, leaseBox });
new SimulatorTab({ store, rest, map });

use(choose([kept("woosh-language"), ...navigator.languages].filter(Boolean)));

// A token in the address is used once and removed, because addresses are visible, stored and shared.
if (given) {
  history.replaceState(null, "", location.pathname + location.search);
  token.refusal = await rest.login(given);
}
link.connect();
