// A page of your own for the robot, without a library: fetch, Server-Sent Events, STOP. In two terminals:
//
//   woosh --sim web --origin http://127.0.0.1:8001
//   python -m http.server 8001 --bind 127.0.0.1 --directory examples/web
//
// Then open http://127.0.0.1:8001/. Another server: ?server=http://robot.example:8080; a server with a token: #token=...
// Nothing here is an emergency stop: STOP goes through the network, so the red button stays within reach.

const server = new URLSearchParams(location.search).get("server") ?? "http://127.0.0.1:8080";
const token = new URLSearchParams(location.hash.slice(1)).get("token");
const SILENT_MS = 2000; // the robot sends its pose several times a second: longer silence is shown
const element = (id) => document.getElementById(id);

/** The answer to a request; an Error with the server's sentence if it is refused. */
async function ask(method, path, body, options = {}) {
  const headers = token ? { authorization: `Bearer ${token}` } : {};
  if (body) headers["content-type"] = "application/json";
  const sent = { method, headers, body: body && JSON.stringify(body), signal: AbortSignal.timeout(5000), ...options };
  const answer = await fetch(`${server}/api/v1/${path}`, sent);
  if (!answer.ok) throw new Error((await answer.json()).detail);
  return answer;
}

const asJson = async (...request) => (await ask(...request)).json();
const pause = (ms) => new Promise((resolve) => { setTimeout(resolve, ms); });

/** The values of a feed. fetch reads them, and not EventSource, which cannot send the token. */
async function* events(path, signal) {
  const { body } = await ask("GET", path, undefined, { signal });
  const reader = body.pipeThrough(new TextDecoderStream()).getReader();
  let text = "";
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    const parts = (text + value).split("\n\n");
    text = parts.pop();
    for (const part of parts) {
      const data = part.match(/^data: (.*)$/m);
      if (data) yield JSON.parse(data[1]);
    }
  }
}

// -- STOP: bound before anything else, waits for nothing, and says what is known -------------------------------

let stops = 0;
element("stop").addEventListener("click", async () => {
  const number = ++stops;
  const say = (text) => { if (number === stops) element("stopped").textContent = text; };
  say("stopping ...");
  const end = performance.now() + 4000;
  while (performance.now() < end) { // again and again until an answer comes: a stop is never refused or limited
    try {
      const answer = await asJson("POST", "stop", undefined, { signal: AbortSignal.timeout(2000), keepalive: true });
      if (answer.stands_still) return say(`stopped: ${answer.text}`);
      say(`NOT confirmed: ${answer.text} Use the red button.`);
    } catch (error) {
      say(`NOT confirmed (${error.message}). Use the red button.`);
    }
    await pause(200);
  }
});

// -- the connection: a pose that does not come is shown, and asked for again ------------------------------------

let heard = -Infinity; // when the last pose came
let facts = null, picture = null, marks = [], pose = null;

async function follow() {
  for (;;) {
    const silence = new AbortController(), begun = performance.now();
    const tooLong = () => performance.now() - Math.max(heard, begun) > 2 * SILENT_MS;
    const timer = setInterval(() => { if (tooLong()) silence.abort(); }, 500);
    try {
      if (!picture) await load();
      for await (const event of events("feeds/pose/stream?rate=5", silence.signal)) {
        [heard, pose] = [performance.now(), event.value];
        element("lost").hidden = true;
        draw();
      }
    } catch (error) {
      lost(error.message);
    } finally {
      clearInterval(timer);
    }
    await pause(500);
  }
}

function lost(why) {
  element("lost").textContent = `No connection to the robot: ${why}. What is shown is out of date; the robot may still be driving.`;
  element("lost").hidden = false;
}

async function load() {
  facts = await asJson("GET", "map");
  picture = await createImageBitmap(await (await ask("GET", "map.png")).blob());
  marks = (await asJson("GET", "marks")).filter((mark) => mark.x !== null);
  element("marks").replaceChildren(...marks.map((mark) => {
    const button = document.createElement("button");
    button.textContent = mark.name;
    button.addEventListener("click", () => go(mark.name));
    return button;
  }));
}

async function watch() {
  for (;; await pause(1000)) {
    try {
      const status = await asJson("GET", "status");
      element("state").textContent = `${status.battery_percent ?? "?"} % charged. ${status.text}`;
    } catch (error) {
      lost(error.message);
    }
    const old = performance.now() - heard > SILENT_MS;
    if (old) lost("it has sent nothing for two seconds");
    element("state").classList.toggle("old", old);
    for (const button of element("marks").children) button.disabled = old; // STOP is never disabled
  }
}

// -- going to a mark --------------------------------------------------------------------------------------------

async function go(mark) {
  const say = (text) => { element("goal").textContent = text; };
  try {
    let goal = await asJson("POST", "goals", { kind: "mark", mark, replace: true });
    while (!goal.done) {
      say(`${goal.description}: ${goal.progress}`);
      goal = await asJson("GET", `goals/${goal.id}/wait?timeout=1`);
    }
    say(goal.text);
  } catch (error) {
    say(`${mark}: ${error.message}`);
  }
}

// -- the map: the picture is north up, its lower left corner is the origin ---------------------------------------

function draw() {
  const canvas = element("map"), context = canvas.getContext("2d");
  [canvas.width, canvas.height] = [picture.width, picture.height];
  const at = ({ x, y }) => [(x - facts.origin.x) / facts.resolution, picture.height - (y - facts.origin.y) / facts.resolution];
  context.drawImage(picture, 0, 0);
  context.font = "10px sans-serif";
  for (const mark of marks) context.fillText(mark.name, ...at(mark));
  if (!pose) return;
  context.translate(...at(pose));
  context.rotate(-pose.yaw); // y points down on the canvas
  context.fillStyle = "#0a58ca";
  context.beginPath();
  for (const [x, y] of [[8, 0], [-6, 5], [-6, -5]]) context.lineTo(x, y);
  context.fill();
  context.resetTransform();
}

follow();
watch();
