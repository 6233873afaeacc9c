// Debian's furo leaves out the rules by which a reader's own choice of dark takes effect, and its
// script, which is a module, is not loaded as one.
document.documentElement.classList.remove("no-js");
const show = (theme) => { document.body.dataset.theme = theme; };
if (document.body.dataset.theme === "auto") {
  show(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
}
for (const button of document.getElementsByClassName("theme-toggle")) {
  button.addEventListener("click", () => {
    show(document.body.dataset.theme === "dark" ? "light" : "dark");
    localStorage.setItem("theme", document.body.dataset.theme);
  });
}
