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
  const tell = () => {
    const files = [...input.files];
    const names = files.map((file) => file.name).join(", ");
    const megabytes = files.reduce((sum, file) => sum + file.size, 0) / 1e6;
    const most = Number(form.dataset.most);
    input.setCustomValidity(megabytes > most
      ? `These files have ${megabytes.toFixed(0)} MB; the server takes ${most} MB at a time.` : "");
    hint.textContent = input.validationMessage || names;
  };
  input.addEventListener("change", tell);
  form.addEventListener("submit", () => { hint.textContent = "Reading …"; });
}
