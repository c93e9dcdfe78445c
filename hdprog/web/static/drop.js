// Files may be dropped onto the upload form; without this script its button does the same.
"use strict";
for (const form of document.querySelectorAll("[data-drop]")) {
  const input = form.querySelector("input[type=file]");
  const hint = form.querySelector("[data-hint]");
  hint.textContent = "Drop files here, or choose them. You see what was read before anything counts.";
  const over = (on) => (event) => { event.preventDefault(); form.classList.toggle("over", on); };
  form.addEventListener("dragover", over(true));
  form.addEventListener("dragleave", over(false));
  form.addEventListener("drop", (event) => {
    over(false)(event);
    if (event.dataTransfer.files.length) { input.files = event.dataTransfer.files; tell(); }
  });
  const tell = () => { hint.textContent = [...input.files].map((file) => file.name).join(", "); };
  input.addEventListener("change", tell);
  form.addEventListener("submit", () => { hint.textContent = "Reading …"; });
}
