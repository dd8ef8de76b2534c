"""The report as people see it: in a real headless Chromium, on a desk and on a phone."""

import html
import json
import re
import shutil
import subprocess

import numpy as np
import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --hide-scrollbars --enable-logging=stderr --v=0"
)
WITHOUT = "LOUD: no Chromium (apt install chromium): the report was not looked at in a browser"
needs_browser = pytest.mark.skipif(CHROMIUM is None, reason=WITHOUT)

#: Asks the page, in the browser, what is on it; appended to a copy of the report.
QUESTION = """
<script>
addEventListener("load", () => {
  const box = e => { const b = e.getBoundingClientRect(); return [b.width, b.height]; };
  // The most pixels in which nothing stands in one half of the page.
  const rects = [...document.querySelectorAll("h1, h2, li, p, table, svg, img, figcaption, .key div")]
    .map(e => e.getBoundingClientRect()).sort((a, b) => a.top - b.top);
  const empty = inside => rects.filter(inside).reduce(
    ([most, last], r) => [Math.max(most, r.top - last), Math.max(last, r.bottom)], [0, 0])[0];
  const told = {
    empty: [empty(r => r.left < innerWidth / 2 - 50), empty(r => r.right > innerWidth / 2 + 50)],
    first: document.querySelector("figure").getBoundingClientRect().bottom, screen: innerHeight,
    width: innerWidth, page: document.documentElement.scrollWidth, height:
    document.documentElement.scrollHeight, images: [...document.images].map(i => [i.complete, i.naturalWidth,
    i.naturalHeight]), figures: [...document.querySelectorAll("figure svg")].map(box),
    captions: [...document.querySelectorAll("figcaption")].map(c => c.innerText.length),
    spoken: [...document.querySelectorAll("figure svg, figure img")].map(
      e => (e.ariaLabel || e.alt || "").length),
    tables: document.querySelectorAll("table").length,
    shadows: [...document.querySelectorAll("table")].filter(
      t => getComputedStyle(t.parentElement).backgroundImage.includes("gradient")).length,
    numbered: [...document.querySelectorAll("figcaption b")].map(b => parseInt(b.innerText.slice(7))),
    text: parseFloat(getComputedStyle(document.querySelector("li")).fontSize),
    outside: [...document.querySelectorAll("[src],link[href]")].map(e => e.src || e.href)
  };
  const view = document.querySelector("dialog.zoom"), figure = document.querySelector("figure svg");
  const shown = () => view.querySelector("svg").getAttribute("viewBox").split(" ").map(Number);
  figure.dispatchEvent(new MouseEvent("click"));
  // baseVal would round to single precision.
  const all = Number(figure.getAttribute("viewBox").split(" ")[2]);
  told.zoom = [view.open, shown()[2] === all, view.getBoundingClientRect().width / innerWidth];
  view.dispatchEvent(new WheelEvent("wheel", { deltaY: -1, clientX: innerWidth / 2, clientY: 300 }));
  told.zoom.push(shown()[2] / all);
  view.close();
  const answer = document.createElement("pre");
  answer.id = "answer"; answer.textContent = JSON.stringify(told); document.body.append(answer);
});
</script>
"""


def browse(page, folder, *, width, height, screenshot=None):
    """Open a page in a fresh browser; return its log and what it printed."""
    command = [CHROMIUM, *FLAGS.split(), f"--user-data-dir={folder}", f"--window-size={width},{height}"]
    command += [f"--screenshot={screenshot}"] if screenshot else ["--dump-dom"]
    done = subprocess.run([*command, page.as_uri()], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return done.stderr, done.stdout


@pytest.fixture(scope="module")
def pages(small_run, tmp_path_factory, left):
    folder = tmp_path_factory.mktemp("pages")
    shutil.copytree(small_run.folder, folder / "run")
    left("area", folder / "study")
    return {name: folder / name / "report.html" for name in ("run", "study")}


@needs_browser
@pytest.mark.parametrize(
    ("name", "width"),
    [
        ("run", 1280),
        ("study", 1400),
        *(pytest.param("run", width, marks=pytest.mark.nightly) for width in (1920, 1400, 500)),
        *(pytest.param("study", width, marks=pytest.mark.nightly) for width in (1920, 1280, 500)),
    ],
)
def test_the_report_is_whole_in_a_browser(pages, tmp_path, name, width):
    copy = pages[name].with_name(f"asked-{width}.html")
    page = pages[name].read_text(encoding="utf-8")
    asking, count = re.subn(r"script-src 'sha256-[^']*'", "script-src 'unsafe-inline'", page)
    assert count == 1
    copy.write_text(asking + QUESTION, encoding="utf-8")
    log, dom = browse(copy, tmp_path / "profile", width=width, height=1000)
    assert "CONSOLE" not in log, log
    told = json.loads(re.search(r'<pre id="answer">(.*?)</pre>', dom, re.DOTALL)[1].replace("&amp;", "&"))
    assert told["width"] == width
    assert told["page"] <= width, "the page scrolls sideways"
    if width == 1400:
        assert max(told["empty"]) < 300, "half a page is empty"
        assert told["first"] < told["screen"] <= 900, "the first screen cuts the figure"
    assert all(complete and w > 0 and h > 0 for complete, w, h in told["images"])
    assert len(told["figures"]) == {"run": 5, "study": 2}[name]
    assert all(w > 250 and h > 150 for w, h in told["figures"])
    assert min(told["spoken"]) > 40, "figures and pictures are said in words"
    # A table that goes on beyond the screen shows so, and its first column stays in sight.
    assert told["shadows"] == told["tables"] > 0
    assert told["numbered"] == list(range(1, 1 + len(told["captions"])))
    assert len(told["captions"]) == len(told["figures"]) + len(told["images"])
    assert min(told["captions"]) > 40
    assert told["text"] >= 15
    # A click shows a figure over the window, whole; the wheel comes closer.
    opened, whole, share, closer = told["zoom"]
    assert opened
    assert whole
    assert share > 0.9
    assert closer == pytest.approx(0.8)
    assert all(link.startswith("data:") for link in told["outside"]), "not self-contained"


#: A page as on a telephone: no window of Chromium is narrower than 500 pixels, a frame may be.
PHONE = """
<iframe width="390" height="844" style="border: 0" srcdoc="{page}"></iframe><pre id="answer"></pre>
<script>
onload = () => {{
  const inside = document.querySelector("iframe").contentDocument;
  const cut = [...inside.querySelectorAll(".scroll")].filter(e => e.scrollWidth > e.clientWidth + 1);
  document.querySelector("pre").textContent = JSON.stringify({{
    page: inside.documentElement.scrollWidth, text: parseFloat(getComputedStyle(inside.body).fontSize),
    cut: cut.map(e => e.nextElementSibling.innerText)
  }});
}};
</script>
"""


@needs_browser
@pytest.mark.parametrize("name", ["run", pytest.param("study", marks=pytest.mark.nightly)])
def test_on_a_telephone_the_page_stays_and_what_goes_on_sideways_says_so(pages, tmp_path, name):
    phone = tmp_path / "phone.html"
    page = html.escape(pages[name].read_text(encoding="utf-8"))
    phone.write_text(PHONE.format(page=page), encoding="utf-8")
    _, dom = browse(phone, tmp_path / "profile", width=800, height=1000)
    told = json.loads(html.unescape(re.search(r'<pre id="answer">(.*?)</pre>', dom, re.DOTALL)[1]))
    assert (told["page"], told["text"]) == (390, 16)
    assert any(words.startswith("Figure") for words in told["cut"]) == (name == "run")
    assert [words for words in told["cut"] if "scrolls sideways" not in words] == []


@needs_browser
@pytest.mark.nightly
def test_the_policy_of_the_page_lets_its_own_script_run_and_no_other(pages, tmp_path):
    log, dom = browse(pages["run"], tmp_path / "profile", width=1280, height=900)
    assert "CONSOLE" not in log, log
    assert '<dialog class="zoom"' in dom
    foreign = pages["run"].with_name("foreign.html")
    foreign.write_text(pages["run"].read_text(encoding="utf-8") + "<script>document.title = 'x'</script>")
    log, dom = browse(foreign, tmp_path / "profile", width=1280, height=900)
    assert "Content Security Policy" in log
    assert "<title>x</title>" not in dom


@needs_browser
@pytest.mark.nightly
@pytest.mark.parametrize(("width", "height"), [(1280, 3600), (500, 5200)], ids=["desk", "phone"])
def test_a_screenshot_of_the_report_is_not_blank(pages, tmp_path, width, height):
    from matplotlib.image import imread

    picture = tmp_path / "report.png"
    browse(pages["run"], tmp_path / "profile", width=width, height=height, screenshot=picture)
    pixels = imread(picture)[..., :3]
    assert pixels.shape[:2] == (height, width)
    ink = np.any(pixels < 0.9, axis=-1)
    # Something in every tenth of the page down to where it ends, and more than text can be.
    rows = np.flatnonzero(ink.any(axis=1))
    bands = ink[: rows[-1]].reshape(-1)[: 10 * (rows[-1] * width // 10)].reshape(10, -1)
    assert rows[-1] > 1500
    assert np.all(bands.mean(axis=1) > 0.003)
    coloured = np.ptp(pixels, axis=-1) > 0.3
    assert coloured.mean() > 0.002


def test_the_report_names_papers_seeds_versions_and_answers_first(pages):
    page = pages["run"].read_text()
    for words in ("Persson, Surf. Sci. Rep.", "scikit-fem", "Seeds: 77", "numpy 2", "fem-contact 1"):
        assert words in page, words
    first = [page.index(words) for words in ("How large", "How sure", "How far from", "What did it cost")]
    assert first == sorted(first)
    assert first[-1] < page.index("What was found") < page.index("<figure id") < page.index("Every grid")
