"""The page in a real browser: no request, no error, selection, filters, picture, print."""

from __future__ import annotations

import io
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from review_synthetic import record

from fabgeo.review.page import write_page

pytestmark = pytest.mark.browser
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
GL = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


@pytest.fixture(scope="module")
def page_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if CHROMIUM is None:
        pytest.skip("Chromium is not installed")
    return write_page(tmp_path_factory.mktemp("page") / "index.html", record(4, 5))


@pytest.fixture(scope="module")
def browser(page_file: Path) -> Iterator:
    sync_api = pytest.importorskip("playwright.sync_api")
    with sync_api.sync_playwright() as play:
        own = play.chromium.launch(executable_path=CHROMIUM, args=GL)
        yield own
        own.close()


@pytest.fixture
def opened(browser, page_file: Path) -> Iterator:
    page = browser.new_page(viewport={"width": 1400, "height": 900})
    page.requests, page.errors = [], []
    page.on("request", lambda request: page.requests.append(request.url))
    page.on("console", lambda m: page.errors.append(m.text) if m.type == "error" else None)
    page.on("pageerror", lambda error: page.errors.append(str(error)))
    page.goto(page_file.as_uri())
    page.wait_for_selector("body[data-ready]", timeout=60_000)
    yield page
    assert page.errors == []
    assert page.requests == [page_file.as_uri()]
    page.close()


def pixels(page, selector: str) -> np.ndarray:
    from PIL import Image

    shot = page.locator(selector).screenshot()
    return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB"), dtype=int)


def changed(page, before: np.ndarray, seconds: float = 5.0) -> np.ndarray:
    """The model's picture, once it is another one: drawn when the browser gets to it."""
    for _ in range(int(seconds / 0.2)):
        page.wait_for_timeout(200)
        image = pixels(page, "#view canvas")
        if np.abs(image - before).max() > 60:
            return image
    raise AssertionError("the picture did not change")


def test_the_model_is_drawn_in_the_colours_of_its_classes(opened) -> None:
    opened.wait_for_timeout(500)
    image = pixels(opened, "#view canvas")
    background = image[5, image.shape[1] // 2]
    drawn = np.abs(image - background).sum(axis=2) > 40
    assert 0.1 < drawn.mean() < 0.95
    assert len(np.unique(image[drawn] // 32, axis=0)) > 8


def test_a_row_selects_the_part_and_its_outline_and_sheet(opened) -> None:
    opened.locator('#grid tr[data-mark="P-01-02"]').click()
    assert opened.locator("body").get_attribute("data-selected") == "P-01-02"
    detail = opened.locator("#detail")
    assert "P-01-02" in detail.inner_text()
    assert detail.locator("svg.flat use").count() == 1
    assert detail.locator("figure.sheet use.on").get_attribute("data-mark") == "P-01-02"


def test_a_click_on_the_model_selects_its_row(opened) -> None:
    opened.wait_for_timeout(300)
    box = opened.locator("#view canvas").bounding_box()
    opened.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] * 0.45)
    mark = opened.locator("body").get_attribute("data-selected")
    assert mark is not None
    assert mark.startswith("P-")
    assert opened.locator("#grid tr.on").get_attribute("data-mark") == mark


def test_filters_verdicts_and_search(opened) -> None:
    opened.fill("#filter", "class=cone")
    rows = opened.locator("#grid tbody tr")
    assert 0 < rows.count() < 20
    assert set(opened.locator("#grid tbody td:nth-child(2)").all_inner_texts()) == {"cone"}
    opened.fill("#filter", "kink>1")
    values = opened.locator("#grid tbody td:nth-child(6)").all_inner_texts()
    assert values
    assert all(float(value) > 1.0 for value in values)
    opened.fill("#filter", "")
    opened.fill("#search", "p-03-04")
    assert opened.locator("body").get_attribute("data-selected") == "P-03-04"


def test_sorting_by_a_column_and_the_arrow_keys(opened) -> None:
    opened.locator("#grid th button", has_text="kink").click()
    values = [float(v) for v in opened.locator("#grid tbody td:nth-child(6)").all_inner_texts()]
    assert values == sorted(values)
    opened.locator("#grid tbody tr").first.click()
    opened.locator("#grid").focus()
    opened.keyboard.press("ArrowDown")
    second = opened.locator("#grid tbody tr").nth(1).get_attribute("data-mark")
    assert opened.locator("body").get_attribute("data-selected") == second


def test_section_explode_and_layers_change_the_picture(opened) -> None:
    opened.wait_for_timeout(300)
    before = pixels(opened, "#view canvas")
    opened.locator("#explode").fill("80")
    exploded = changed(opened, before)
    opened.select_option("#axis", "x")
    changed(opened, exploded)


def test_user_text_stays_text(opened) -> None:
    assert opened.locator("h1").inner_text() == "Barrel <b>roof</b>"
    assert opened.locator("h1 b").count() == 0


def test_the_print_holds_tables_and_the_still_picture(opened) -> None:
    pypdf = pytest.importorskip("pypdf")
    reader = pypdf.PdfReader(io.BytesIO(opened.pdf(prefer_css_page_size=True)))
    words = "\n".join(page.extract_text() for page in reader.pages)
    assert "P-03-04" in words
    assert "Figures against their limits" in words
    assert 2 <= len(reader.pages) <= 12


def test_without_webgl_the_still_picture_takes_its_place(page_file: Path, browser) -> None:
    page = browser.new_page()
    page.add_init_script(
        "HTMLCanvasElement.prototype.getContext = new Proxy("
        "HTMLCanvasElement.prototype.getContext, {apply: (f, own, args) =>"
        " String(args[0]).startsWith('webgl') ? null : Reflect.apply(f, own, args)})"
    )
    page.goto(page_file.as_uri())
    page.wait_for_selector("body[data-ready]")
    assert page.locator("#still").is_visible()
    page.locator('#still path[data-mark="P-00-00"]').dispatch_event("click")
    assert page.locator("body").get_attribute("data-selected") == "P-00-00"
    page.close()
