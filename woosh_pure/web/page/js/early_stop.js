// STOP before the other modules are loaded, which takes seconds over a slow link. Loaded first, so it imports nothing.
// stop_button.js then stops once more, which does no harm, and shows the answer.

const button = document.getElementById("stop");
const SECONDS = 0.9; // without an answer, then show the hint to the red button
let language = navigator.language;
try {
  language = localStorage.getItem("woosh-language") ?? language;
} catch { /* no storage */ }
const WORDS = language.startsWith("zh")
  ? ["正在停止…", "机器人已停稳。", "还没有响应。请按机器人上的红色按钮。"]
  : ["Stopping…", "The robot stands still.", "No answer yet. Use the red button on the robot."];

function say(number, kind) {
  if (!button.dataset.early) return; // stop_button.js shows it now
  const box = document.getElementById("stop-answer");
  box.textContent = WORDS[number];
  box.className = `answer ${kind}`;
}

function pressed(event) {
  if (!button.dataset.early || !(event.type === "click" ? event.detail === 0 : event.button === 0)) return;
  button.dataset.early = "pressed";
  say(0, "info");
  const alarm = setTimeout(() => say(2, "bad"), SECONDS * 1000);
  fetch("api/v1/stop", { method: "POST" }).then(async (answer) => {
    const stands = (await answer.json()).stands_still === true;
    clearTimeout(alarm);
    say(stands ? 1 : 2, stands ? "ok" : "bad");
  }).catch(() => say(2, "bad"));
  navigator.sendBeacon?.("api/v1/stop");
}

button.addEventListener("pointerdown", pressed);
button.addEventListener("click", pressed);
