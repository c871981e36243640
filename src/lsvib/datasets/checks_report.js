const rows = [...document.querySelectorAll("#every tbody tr")];
const [words, figure, failed] = ["words", "figure", "failed"].map(name => document.getElementById(name));
function filter() {
  const wanted = words.value.toLowerCase().split(/\s+/).filter(Boolean);
  let shown = 0;
  for (const row of rows) {
    const text = row.textContent.toLowerCase();
    row.hidden = !(wanted.every(word => text.includes(word)) && (!figure.value || row.dataset.figure === figure.value)
      && (!failed.checked || row.dataset.passed === "no"));
    shown += !row.hidden;
  }
  document.getElementById("shown").textContent = `${shown} of ${rows.length} checks are shown.`;
}
document.querySelector("form").addEventListener("input", filter);
document.querySelector("form").addEventListener("submit", event => event.preventDefault());
filter();
