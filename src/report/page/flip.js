(() => {
  const get = (id) => document.getElementById(id);
  const [below, above, bar, slider] = ['flip-a', 'flip-b', 'flip-bar', 'flip-slider'].map(get);
  const [first, second] = ['flip-first', 'flip-second'].map(get);
  const show = () => {
    below.src = get(first.value).src;
    above.src = get(second.value).src;
    below.alt = first.selectedOptions[0].text;
    above.alt = second.selectedOptions[0].text;
  };
  const move = () => {
    above.style.clipPath = `inset(0 0 0 ${slider.value}%)`;
    bar.style.left = `${slider.value}%`;
  };
  slider.addEventListener('input', move);
  [first, second].forEach((choice) => choice.addEventListener('change', show));
  get('flip-button').addEventListener('click', () => {
    slider.value = Number(slider.value) < 50 ? 100 : 0;
    move();
  });
  show();
  move();
})();
