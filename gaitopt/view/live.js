const sliders = document.getElementById("sliders"), told = document.getElementById("told");
const socket = new WebSocket(location.href.replace(/^http/, "ws").replace(/[#?].*/, "") + "socket");
const RESTS = 250;  // ms after which a slider that was moved is at rest
const asked = new Map(), live = { number: 0, seen: 0, delays: [], viewer, seek, curves };
let touched = -Infinity;
window.gaitoptLive = live;  // for whoever wants to know how fast it is, and what it shows
function wishes() {
  const settings = {};
  for (const input of sliders.querySelectorAll("input")) settings[input.name] = Number(input.value);
  return settings;
}
socket.onopen = () => { if (live.early) wish(); };
function wish() {
  if (socket.readyState !== WebSocket.OPEN) {  // answered as soon as there is a line
    live.early = true;
    return;
  }
  const number = ++live.number;
  asked.set(number, touched = performance.now());
  socket.send(JSON.stringify({ number, settings: wishes() }));
  told.textContent = "…";
}
for (const input of sliders.querySelectorAll("input")) {
  const value = input.nextElementSibling;
  const show = () => { value.textContent = `${brief(Number(input.value))} ${input.dataset.unit}`; };
  input.oninput = () => { show(); wish(); };
  show();
}
function walk(message) {  // its curves at once; the picture and the tables follow
  live.shown = message.number;
  curves.replace(message.curves);
  say(message.words);
  document.body.classList.add("behind");
}
async function follow(message) {
  const { playing } = animator, share = animator.time / data.step;
  await draw(viewer, message.commands);
  move(viewer, message.motion);
  data = message.data;
  stand();
  say(message.words);
  seek(share * data.step);  // the same posture of the step
  setPlaying(playing);
  document.body.classList.remove("behind");
}
let turn = Promise.resolve();  // answers are shown in the order in which they come
socket.onmessage = event => {
  const message = JSON.parse(event.data);
  turn = turn.then(() => answer(message));
};
async function answer(message) {
  const { kind, number } = message;
  if (kind === "walk") walk(message);
  if (kind === "motion") return follow(message);
  if (kind === "proof") return say(message.words);
  if (kind === "none") document.getElementById("verdict").textContent =
    "the walk before these settings";
  if (message.text !== undefined) told.textContent = message.text;
  document.body.classList.toggle("none", kind === "none");
  if (asked.has(number)) {
    live.delays.push(performance.now() - asked.get(number));
    if (live.delays.length > 1000) live.delays.shift();
    for (const old of [...asked.keys()]) if (old <= number) asked.delete(old);
  }
  live.seen = Math.max(live.seen, number || 0);
  live.kind = kind;
}
viewer.held = now => asked.size > 0 || now - touched < RESTS;
socket.onclose = () => { told.textContent = "gaitopt has ended; this page shows its last walk."; };
document.getElementById("save").onclick = event => {
  socket.send(JSON.stringify({ save: true }));
  release(event);
};
