// SPDX-License-Identifier: BSD-2-Clause
// The report without its 3D view: the cursor of all charts over time follows the view's slider.
"use strict";
document.addEventListener("facet-time", (event) => {
  const section = document.querySelector(`[data-sequence="${event.detail.sequence}"]`);
  for (const line of section ? section.querySelectorAll("line.now") : []) {
    const { x0, x1, t0, t1 } = line.dataset;
    const share = (event.detail.time - t0) / (t1 - t0 || 1);
    const x = share < 0 || share > 1 ? -9 : Number(x0) + share * (x1 - x0);
    line.setAttribute("x1", x);
    line.setAttribute("x2", x);
  }
});
