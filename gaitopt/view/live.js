const sliders = document.getElementById("sliders"), told = document.getElementById("told");
const socket = new WebSocket(location.href.replace(/^http/, "ws").replace(/[#?].*/, "") + "socket");
const RESTS = 250;  // ms after which a slider that was moved is at rest
const asked = new Map(), live = { number: 0, seen: 0, delays: [], viewer, seek, curves };
let touched = -Infinity;
window.gaitoptLive = live;  // for whoever wants to know how fast it is, and what it shows
const inputs = [...sliders.querySelectorAll("input")], save = document.getElementById("save");
const verdict = document.getElementById("verdict");
const tab = String(Math.random());  // several may be open, whose sliders follow each other
function tell(input) {
  const value = `${brief(wanted(input))} ${input.dataset.unit}`.trim();
  input.nextElementSibling.textContent = value;
  input.setAttribute("aria-valuetext", value);
}
function wanted(input) {  // a slider stands at a step of its own, until it is moved for a value between
  return Number(input.dataset.value ?? input.value);
}
function wishes() { return Object.fromEntries(inputs.map(input => [input.name, wanted(input)])); }
live.walks = wishes();  // the settings of the walk that is shown
save.disabled = true;
socket.onopen = () => {
  save.disabled = false;
  if (live.early) wish();
};
function wish() {
  if (socket.readyState !== WebSocket.OPEN) {  // answered as soon as there is a line
    live.early = true;
    return;
  }
  const number = ++live.number;
  asked.set(number, touched = performance.now());
  socket.send(JSON.stringify({ number, tab, settings: wishes() }));
  told.textContent = "…";
}
for (const input of inputs) {
  input.oninput = () => {
    delete input.dataset.value;
    tell(input);
    wish();
  };
  tell(input);
}
function move_to(settings) {
  asked.clear();  // what another tab wished later has taken its place
  for (const input of inputs) {
    input.value = input.dataset.value = settings[input.name];
    tell(input);
  }
}
function walk(message) {  // its curves at once; the picture and the tables follow
  live.shown = message.number;
  live.walks = message.settings;
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
  const { kind, number, settings } = message;
  if (settings && message.tab !== tab) move_to(settings);
  if (kind === "walk") walk(message);
  if (kind === "motion") return follow(message);
  if (kind === "proof") return say(message.words);
  if (kind === "none" && !refused()) {
    live.proof = proven();
    verdict.innerHTML = `the walk before these settings: ${live.proof}`;
  }
  if (message.text !== undefined) told.textContent = message.text;
  if (kind !== "saved") document.body.classList.toggle("none", kind === "none");
  if (message.tab === tab && asked.has(number)) {
    live.delays.push(performance.now() - asked.get(number));
    if (live.delays.length > 1000) live.delays.shift();
    for (const old of [...asked.keys()]) if (old <= number) asked.delete(old);
  }
  live.seen = Math.max(live.seen, number || 0);
  live.kind = kind;
}
viewer.held = now => asked.size > 0 || now - touched < RESTS;
function refused() { return document.body.classList.contains("none"); }
function proven() {  // what is known of the walk that is shown: no certificate follows any more
  return verdict.innerHTML.replace("; its certificate follows", ", not certified");
}
socket.onclose = () => {
  for (const control of [...inputs, save]) control.disabled = true;
  verdict.innerHTML = refused() ? live.proof : proven();
  move_to(live.walks);
  told.textContent = "gaitopt has ended; this page shows its last walk.";
};
save.onclick = event => {
  socket.send(JSON.stringify({ save: true }));
  release(event);
};
