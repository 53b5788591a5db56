// STOP before the rest of the page has come: over a slow link that takes seconds, and the button can be seen already.
// Loaded first and alone, so it imports nothing. When the page is there, stop.js takes over, asks once more and shows
// the answer: to stop twice does no harm.

const button = document.getElementById("stop");

function pressed(event) {
  if (!button.dataset.early || !(event.type === "click" ? event.detail === 0 : event.button === 0)) return;
  button.dataset.early = "pressed";
  const box = document.getElementById("stop-answer");
  box.textContent = navigator.language.startsWith("zh") ? "正在停止…" : "Stopping…";
  box.className = "answer info";
  fetch("api/v1/stop", { method: "POST" }).catch(() => {}); // stop.js asks again, and says what came of it
}

button.addEventListener("pointerdown", pressed);
button.addEventListener("click", pressed);
