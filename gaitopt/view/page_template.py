"""The frame around the viewer: layout, buttons and what they do."""

# @NAME@ is replaced by `page.page_text`.
PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>@TITLE@</title>
<style>
  html, body { margin: 0; height: 100%; overflow: hidden; color: #1d2730;
               font: 14px/1.45 system-ui, sans-serif; }
  #pane { width: 100vw; height: 100vh; overflow: hidden; }
  .card { position: absolute; background: rgba(255, 255, 255, .86); border-radius: 10px;
          box-shadow: 0 1px 6px rgba(20, 40, 60, .18); padding: 12px 16px; }
  #facts { left: 16px; top: 16px; max-width: 22em; }
  #facts h1 { font-size: 17px; margin: 0 0 6px; }
  #facts dl { display: grid; grid-template-columns: auto 1fr; gap: 1px 12px; margin: 0; }
  #facts dt { color: #5a6b7a; } #facts dd { margin: 0; }
  #facts p { margin: 8px 0 0; color: #5a6b7a; font-size: 12px; }
  #facts details { margin: 8px 0 0; font-size: 12px; max-height: 40vh; overflow: auto; }
  #facts ul { margin: 4px 0 0; padding-left: 1.4em; overflow-wrap: anywhere; }
  .mark { display: inline-block; width: .8em; height: .8em; border-radius: 2px;
          vertical-align: -1px; }
  #controls { left: 50%; bottom: 18px; transform: translateX(-50%); display: flex; gap: 8px;
              align-items: center; white-space: nowrap; }
  button { font: inherit; border: 1px solid #c3ccd4; background: #fff; border-radius: 6px;
           padding: 3px 10px; cursor: pointer; }
  button.on { background: #0072b2; border-color: #0072b2; color: #fff; }
  #play { min-width: 5.2em; } #scrub { width: 26vw; }
  #clock { font-variant-numeric: tabular-nums; min-width: 9.5em; text-align: right; }
  @media (max-width: 800px) {
    .card { padding: 8px 12px; font-size: 12px; }
    #facts { left: 8px; right: 8px; top: 8px; max-width: none; }
    #facts h1 { font-size: 14px; margin: 0 0 2px; }
    #facts p { margin: 4px 0 0; font-size: 11px; } #facts br, #help { display: none; }
    #controls { left: 8px; right: 8px; bottom: 8px; transform: none; flex-wrap: wrap;
                justify-content: center; gap: 6px; }
    #controls button { padding: 3px 7px; }
    #scrub { flex: 1 1 100%; order: -1; margin: 0; }
  }
</style>
</head>
<body>
<div id="pane"></div>
<div id="facts" class="card">
  <h1>@TITLE@</h1>
  <dl>@FACTS@</dl>
  <p><span class="mark" style="background:#e07a10"></span> ground force, 10 cm for @SCALE@ N<br>
     <span class="mark" style="background:#b00020"></span> centre of pressure<br>
     <span class="mark" style="background:#2e9e5b"></span> standing foot</p>
  <p id="help">space: play or pause; arrow keys: a moment<br>
     back or on; mouse: turn, shift, zoom</p>
  @NOTE@
  @ROBOT@
</div>
<div id="controls" class="card">
  <button id="play">pause</button>
  <button data-pace="1">1x</button>
  <button data-pace="0.5">0.5x</button>
  <button data-pace="0.1">0.1x</button>
  <input id="scrub" type="range" min="0" max="1" step="any" value="0" aria-label="time">
  <span id="clock"></span>
  <button id="scene">scene</button>
</div>
<script>const commands = @COMMANDS@;</script>
<script>@MESHCAT@</script>
<script>
"use strict";
const DURATION = @DURATION@, STEP = @STEP@, NUDGE = STEP / 30, PARTS = 5;
const viewer = new MeshCat.Viewer(document.getElementById("pane"));
for (const command of commands) {
  viewer.handle_command_bytearray(Uint8Array.from(atob(command), c => c.charCodeAt(0)));
}
@FIT@
const panel = viewer.gui.domElement.style;
panel.display = "none";
viewer.gui.open();
document.getElementById("scene").onclick = event => {
  panel.display = panel.display ? "" : "none";
  event.target.blur();
};
const animator = viewer.animator, mixer = animator.mixer;
const play = document.getElementById("play"), scrub = document.getElementById("scrub");
const clock = document.getElementById("clock");
const paces = [...document.querySelectorAll("[data-pace]")];
scrub.max = DURATION;

function setPlaying(on) { on ? animator.play() : animator.pause(); show(); }
function setPace(pace) {
  mixer.timeScale = pace;
  for (const b of paces) b.classList.toggle("on", Number(b.dataset.pace) === pace);
}
function seek(t) {
  animator.seek(Math.max(0, Math.min(DURATION, t)));
  animator.display_progress(animator.actions.length ? animator.actions[0].time : 0);
  show();
}
function show() {
  play.textContent = animator.playing ? "pause" : "play";
  if (document.activeElement !== scrub || animator.playing) scrub.value = animator.time;
  const step = Math.min(Math.floor(animator.time / STEP + 1e-9), Math.round(DURATION / STEP) - 1);
  clock.textContent = "step " + (step + 1) + "   t = " + animator.time.toFixed(3) + " s";
}
play.onclick = () => { setPlaying(!animator.playing); play.blur(); };
for (const b of paces) b.onclick = () => { setPace(Number(b.dataset.pace)); b.blur(); };
scrub.oninput = () => { setPlaying(false); seek(Number(scrub.value)); };
window.addEventListener("keydown", event => {
  const nudge = { ArrowLeft: -NUDGE, ArrowRight: NUDGE }[event.key];
  if (event.key === " ") { event.preventDefault(); setPlaying(!animator.playing); }
  else if (nudge) { event.preventDefault(); setPlaying(false); seek(animator.time + nudge); }
});
function openAt() {
  const wanted = new URLSearchParams(location.hash.slice(1));
  if (wanted.has("pace")) setPace(Number(wanted.get("pace")) || 1);
  if (wanted.has("t")) seek(Number(wanted.get("t")) || 0);
  if (wanted.has("paused")) setPlaying(false);
}
window.addEventListener("hashchange", openAt);
for (let part = 0; part < 2 * PARTS; part++) {  // both legs
  seek(Math.min(part * STEP / PARTS, DURATION));
  measure();
}
fit();
seek(0);
setPace(1);
openAt();
(function tick() { show(); requestAnimationFrame(tick); })();
</script>
</body>
</html>
"""
