// Browsers load no program from a file system: opened from there, the page says what to do.
if (location.protocol === "file:") {
  document.body.dataset.state = "failed";
  document.getElementById("message").textContent = "The viewer cannot start from a file: browsers load its program from a server alone. "
    + "In the folder of the book, run\n\npython3 -m http.server\n\nthen open http://localhost:8000/viewer/ in the browser.";
}
