const sliders = document.getElementById("sliders"), told = document.getElementById("told");
const socket = new WebSocket(location.href.replace(/^http/, "ws").replace(/[#?].*/, "") + "socket");
const asked = new Map(), live = { number: 0, seen: 0, delays: [] };
window.gaitoptLive = live;  // for whoever wants to know how fast it is
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
  asked.set(number, performance.now());
  socket.send(JSON.stringify({ number, settings: wishes() }));
  told.textContent = "…";
}
for (const input of sliders.querySelectorAll("input")) {
  const value = input.nextElementSibling;
  const show = () => { value.textContent = `${brief(Number(input.value))} ${input.dataset.unit}`; };
  input.oninput = () => { show(); wish(); };
  show();
}
function say(words) {
  for (const [name, text] of Object.entries(words)) {
    document.getElementById(name).innerHTML = text;
  }
}
async function walk(message) {
  const { time, playing } = animator, share = time / data.step;
  await draw(viewer, message.commands);
  data = message.data;
  stand();
  curves.replace(data.curves);
  say(message.words);
  seek(share * data.step);  // the same posture of the step, as near as there is one
  setPlaying(playing);
}
let turn = Promise.resolve();  // answers are shown in the order in which they come
socket.onmessage = event => { turn = turn.then(() => answer(JSON.parse(event.data))); };
async function answer(message) {
  if (message.kind === "walk") await walk(message);
  if (message.kind === "proof") say(message.words);
  if (message.kind === "none") document.getElementById("verdict").textContent =
    "the walk before these settings";
  if (message.text !== undefined) told.textContent = message.text;
  document.body.classList.toggle("none", message.kind === "none");
  if (message.number && message.kind !== "proof" && asked.has(message.number)) {
    live.delays.push(performance.now() - asked.get(message.number));
    for (const number of [...asked.keys()]) if (number <= message.number) asked.delete(number);
  }
  live.seen = Math.max(live.seen, message.number || 0);
  live.kind = message.kind;
}
socket.onclose = () => { told.textContent = "gaitopt has ended; this page shows its last walk."; };
document.getElementById("save").onclick = event => {
  socket.send(JSON.stringify({ save: true }));
  event.target.blur();
};
