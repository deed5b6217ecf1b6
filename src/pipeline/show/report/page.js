"use strict";
(function () {
  const data = JSON.parse(document.getElementById("data").textContent);
  const element = (id) => document.getElementById(id);
  const drawing = "http://www.w3.org/2000/svg";

  // The chart follows the pointer and the slider: the nearest point of the history is told.
  const chart = document.querySelector(".chart > svg");
  let spot = null;
  if (chart && data.history.length > 0) {
    spot = document.createElementNS(drawing, "circle");
    spot.setAttribute("r", "12");
    spot.setAttribute("fill", "none");
    spot.setAttribute("stroke", "#d55e00");
    spot.setAttribute("stroke-width", "4");
    chart.appendChild(spot);
    chart.addEventListener("pointermove", (event) => {
      const box = chart.getBoundingClientRect();
      const [, , width, height] = chart.getAttribute("viewBox").split(" ").map(Number);
      const x = ((event.clientX - box.left) / box.width) * width;
      const y = ((event.clientY - box.top) / box.height) * height;
      let nearest = data.history[0];
      let least = Infinity;
      for (const point of data.history) {
        const distance = (point.x - x) ** 2 + (point.y - y) ** 2;
        if (distance < least) {
          least = distance;
          nearest = point;
        }
      }
      tell(nearest);
    });
  }
  function tell(point) {
    spot.setAttribute("cx", point.x);
    spot.setAttribute("cy", point.y);
    element("told").textContent = point.text;
  }

  // The slider: one picture of the damage for each frame.
  const slider = element("step");
  if (slider) {
    let timer = 0;
    const show = () => {
      const frame = data.frames[Number(slider.value)];
      element("frame").src = "data:image/png;base64," + frame.png;
      element("frame").alt = "damage at step " + frame.step;
      element("frame-text").textContent = frame.text;
      const point = data.history.find((point) => point.step === frame.step);
      if (spot && point) tell(point);
    };
    const stop = () => {
      window.clearInterval(timer);
      timer = 0;
      element("play").textContent = "Play";
    };
    slider.addEventListener("input", () => {
      stop();
      show();
    });
    element("play").addEventListener("click", () => {
      if (timer) return stop();
      if (slider.value === slider.max) slider.value = "0";
      show();
      element("play").textContent = "Stop";
      timer = window.setInterval(() => {
        if (slider.value === slider.max) return stop();
        slider.value = String(Number(slider.value) + 1);
        show();
      }, 250);
    });
    slider.value = slider.max;
    show();
  }
  document.documentElement.dataset.ready = "yes";
})();
