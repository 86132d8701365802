const choices = [...document.querySelectorAll("#replays button")];
function choose(index) {  // the posture at the same time, as far as there is one
  const film = data.films[index], { time, playing } = animator;
  move(viewer, film.motion);
  data.duration = film.duration;
  stand();
  curves.replace(film.curves);
  say(film.words);
  choices.forEach((button, k) => press(button, k === index));
  seek(time);
  setPlaying(playing);
}
choices.forEach((button, k) => {
  button.onclick = event => { choose(k); release(event); };
});
if (choices.length) choose(0);
