//! The page in a browser: `cargo test --release --test report -- --ignored chromium` (CHROMIUM names another program).
//! What the normal tests cannot see: that style and script are understood, and that nothing is said on the console.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use scraper::{Html, Selector};

use crate::sample;

/// Asks the page, after its own script, for what a reader would see; the answers are left in the document.
const QUESTIONS: &str = r##"<script>
addEventListener("load", () => {
  const answer = (name, value) => { document.body.dataset[name] = String(value); };
  const seen = (selector) => [...document.querySelectorAll(selector)].filter((e) => e.getBoundingClientRect().width > 0);
  answer("marks", seen(".mark").length);
  answer("pictures", seen(".tile img").filter((image) => image.complete && image.naturalWidth > 0).length);
  answer("stages", seen(".stage").length);
  const boxes = (element) => [...element.querySelectorAll("text")].filter((t) => t.textContent.trim()).map((t) => t.getBoundingClientRect());
  const meet = (a, b) => a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1;
  const overprinted = [...document.querySelectorAll("figure > svg")].flatMap((drawing) => {
    const all = boxes(drawing), page = drawing.getBoundingClientRect();
    const cut = all.filter((box) => box.left < page.left - 1 || box.right > page.right + 1);
    return cut.concat(all.filter((box, i) => all.some((other, j) => j > i && meet(box, other))));
  });
  answer("overprinted", overprinted.length);
  answer("own", seen(".tile img").every((image) => image.getBoundingClientRect().width === image.naturalWidth));
  answer("stage", document.querySelector(".pane img").getBoundingClientRect().width);
  answer("wide", document.documentElement.scrollWidth > innerWidth);
  const page = () => getComputedStyle(document.body).backgroundColor;
  const before = page();
  document.getElementById("theme").click();
  answer("toggles", before !== page());
  seen(".mark")[3].dispatchEvent(new PointerEvent("pointerover", { bubbles: true }));
  answer("tip", document.getElementById("tip").textContent);
  const stage = document.querySelector(".stage");
  const [left, right, mode, zoom] = stage.parentElement.querySelectorAll("select");
  const widths = () => [...stage.querySelectorAll("img")].map((image) => image.getBoundingClientRect().width);
  const once = widths();
  zoom.value = "4"; zoom.dispatchEvent(new Event("change"));
  answer("zoom", widths().map((width, i) => Math.round(width / once[i])).join());
  const cut = stage.parentElement.querySelector("input");
  cut.value = "25"; cut.dispatchEvent(new Event("input"));
  answer("cut", getComputedStyle(stage.lastChild).clipPath);
  mode.value = "side"; mode.dispatchEvent(new Event("change"));
  const [a, b] = [...stage.children].map((pane) => pane.getBoundingClientRect());
  answer("side", a.right <= b.left || a.bottom <= b.top);
  right.value = "3"; right.dispatchEvent(new Event("change"));
  answer("difference", stage.lastChild.querySelector("span").textContent);
});
</script>"##;

#[test]
#[ignore = "needs Chromium"]
fn chromium_shows_every_point_and_says_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("report.html");
    let html = sample::report().to_html().replace("</body>", &format!("{QUESTIONS}</body>"));
    fs::write(&file, html).expect("the page can be written");
    let program = std::env::var_os("CHROMIUM").unwrap_or_else(|| "chromium".into());
    for width in [1200, 500, 400] {
        let profile = tempfile::tempdir().expect("a temporary folder");
        let output = Command::new(&program)
            .args("--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-sync".split(' '))
            .args(["--disable-background-networking", "--disable-component-update", "--enable-logging=stderr"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg(format!("--window-size={width},900"))
            .args(["--virtual-time-budget=5000", "--dump-dom"])
            .arg(&file)
            .output()
            .expect("Chromium starts");
        let log = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && !log.contains("CONSOLE"), "{log}");
        let page = Html::parse_document(&String::from_utf8_lossy(&output.stdout));
        let body = page.select(&Selector::parse("body").expect("a selector")).next().expect("a body");
        let answer = |name: &str| body.value().attr(&format!("data-{name}")).unwrap_or("nothing").to_owned();
        assert_eq!(answer("marks"), (sample::POINTS + sample::BARS).to_string());
        assert_eq!(answer("pictures"), sample::PICTURES.to_string());
        assert_eq!((answer("stages"), answer("wide"), answer("toggles")), ("1".into(), "false".into(), "true".into()));
        assert_eq!((answer("overprinted"), answer("own"), answer("stage")), ("0".into(), "true".into(), "96".into()));
        assert!(answer("tip").starts_with("independent\nsamples a pixel: 64.00\nrelative RMSE: "), "{}", answer("tip"));
        assert_eq!((answer("zoom"), answer("cut")), ("4,4".into(), "inset(0px 0px 0px 25%)".into()));
        assert_eq!((answer("side"), answer("difference")), ("true".into(), "1 spp against 1000 spp".into()));
    }
}

/// Writes the sample's page, for looking at: to the file that REPORT names, or into the build's folder for tests.
#[test]
#[ignore = "writes a page to look at"]
fn the_sample_is_written() {
    let named = std::env::var_os("REPORT").map(PathBuf::from);
    let path = named.unwrap_or_else(|| Path::new(env!("CARGO_TARGET_TMPDIR")).join("report.html"));
    fs::write(&path, sample::report().to_html()).expect("the page can be written");
    println!("{}", path.display());
}
