"""The widget in JupyterLab and Notebook 7, driven through headless Chromium; skipped where one of them is missing."""

from __future__ import annotations

import base64
import contextlib
import json
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from splatvol import _browser

CHROMIUM = os.environ.get("SPLATVOL_CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
if CHROMIUM is None:
    pytest.skip("no Chromium is here, nor named by SPLATVOL_CHROMIUM (Debian: chromium)", allow_module_level=True)
playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
pytest.importorskip("jupyterlab", reason="JupyterLab is not installed")

CODE = 'import splatvol as sv\nwidget = sv.show("sample:head:64", size=(320, 240))\nwidget'
#: Where pictures of the screen go, if anybody wants to look at them.
SCREENS = os.environ.get("SPLATVOL_SCREENSHOTS")
CANVAS = ".splatvol-widget canvas.splatvol-picture"


def cell(code: str) -> dict[str, Any]:
    return {"cell_type": "code", "execution_count": None, "id": "one", "metadata": {}, "outputs": [], "source": code}


def notebook(*cells: dict[str, Any]) -> str:
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    return json.dumps({"cells": cells, "metadata": kernel, "nbformat": 4, "nbformat_minor": 5})


def surroundings(folder: Path) -> dict[str, str]:
    """Jupyter's settings are the test's own."""
    names = ("JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR")
    return {**os.environ, **{name: str(folder / ".jupyter") for name in names}}


@contextlib.contextmanager
def lab(folder: Path, *more: str, program: str = "jupyterlab") -> Iterator[str]:
    """A server of JupyterLab, or of Notebook, on a folder; its address."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    start = [sys.executable, "-m", program, "--no-browser", "--allow-root", f"--ServerApp.port={port}"]
    start += ["--IdentityProvider.token=", "--ServerApp.ip=127.0.0.1", f"--ServerApp.root_dir={folder}"]
    start += ["--ServerApp.port_retries=0", "--LabApp.news_url=None", *more]
    log = (folder / "lab.log").open("w")
    server = subprocess.Popen(start, cwd=folder, env=surroundings(folder), stdout=log, stderr=log)
    address = f"http://127.0.0.1:{port}"
    try:
        for _ in range(600):
            with contextlib.suppress(OSError), urllib.request.urlopen(f"{address}/api") as answer:
                answer.read()
                break
            assert server.poll() is None, (folder / "lab.log").read_text()
            time.sleep(0.1)
        yield address
    finally:
        server.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            server.wait(20)
        server.kill()
        log.close()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with playwright.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"])
        yield started
        started.close()


def opened(browser: Any, address: str, name: str, way: str = "lab/tree") -> Any:
    """A page with a notebook."""
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    page.set_default_timeout(60_000)
    page.goto(f"{address}/{way}/{name}")
    page.wait_for_selector(".jp-Notebook .jp-CodeCell")
    return page


def run(page: Any) -> None:
    """Runs the first cell, once the kernel is there."""
    page.wait_for_selector(".jp-Notebook-ExecutionIndicator[data-status=idle]")
    for patience in (20_000, 20_000, 60_000):
        page.click(".jp-Notebook .jp-CodeCell .cm-content")
        page.keyboard.press("Shift+Enter")
        # A kernel that has just started may be idle and not hear yet.
        with contextlib.suppress(playwright.TimeoutError):
            page.wait_for_selector(f"{CANVAS}[data-final=true]", timeout=patience)
            return
    screen(page, "0-not-run")
    raise AssertionError("the cell showed no widget")


def at_rest(page: Any, before: str | None = None) -> str:
    """Waits for a final picture, other than one before; returns its pixels as text."""
    page.wait_for_function(
        """([canvas, before]) => { const c = document.querySelector(canvas);
        return c.dataset.final === "true" && c.toDataURL() !== before }""",
        arg=[CANVAS, before],
    )
    return str(page.evaluate("canvas => document.querySelector(canvas).toDataURL()", CANVAS))


def screen(page: Any, name: str) -> None:
    if SCREENS:
        page.screenshot(path=str(Path(SCREENS, f"{name}.png")))


def share_of_background(page: Any, selector: str) -> float:
    """Share of a picture's pixels that are those of its corner."""
    share = page.evaluate(
        """async selector => { const image = document.querySelector(selector);
        const canvas = document.createElement("canvas");
        canvas.width = image.naturalWidth ?? image.width; canvas.height = image.naturalHeight ?? image.height;
        const context = canvas.getContext("2d"); context.drawImage(image, 0, 0);
        const words = new Uint32Array(context.getImageData(0, 0, canvas.width, canvas.height).data.buffer);
        return words.filter(word => word === words[0]).length / words.length }""",
        selector,
    )
    return float(share)


def test_the_widget_lives_and_its_notebook_keeps_the_picture(browser: Any, tmp_path: Path) -> None:
    (tmp_path / "head.ipynb").write_text(notebook(cell(CODE)))
    with lab(tmp_path) as address:
        page = opened(browser, address, "head.ipynb")
        problems: list[str] = []
        page.on("pageerror", lambda error: problems.append(str(error)))
        run(page)
        first = at_rest(page)
        assert 0.1 < share_of_background(page, CANVAS) < 0.9
        # The still beside the widget is hidden while the widget lives.
        assert page.locator(".jp-OutputArea img").count() == 1
        assert not page.locator(".jp-OutputArea img").is_visible()
        screen(page, "1-shown")

        box = page.locator(CANVAS).bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.evaluate(
            """canvas => { window.drafts = 0; document.querySelector(canvas).addEventListener("splatvol-frame",
            event => { window.drafts += !event.detail.final }) }""",
            CANVAS,
        )
        page.mouse.move(x, y)
        page.mouse.down()
        for step in range(20):
            page.mouse.move(x + 4 * step, y)
            page.wait_for_timeout(20)
        page.mouse.up()
        turned = at_rest(page, first)
        assert page.evaluate("window.drafts") >= 3
        screen(page, "2-turned")

        page.mouse.wheel(0, -300)
        zoomed = at_rest(page, turned)
        screen(page, "3-zoomed")

        point = page.locator(".splatvol-editor circle").nth(1).bounding_box()
        page.mouse.move(point["x"] + point["width"] / 2, point["y"] + point["height"] / 2)
        page.mouse.down()
        page.mouse.move(point["x"] + 3, point["y"] + 60, steps=5)
        page.mouse.up()
        edited = at_rest(page, zoomed)
        screen(page, "4-edited")

        page.select_option(".splatvol-panel select[aria-label=Show]", "mip")
        projected = at_rest(page, edited)
        screen(page, "5-mip")

        page.click(".splatvol-clip summary")
        page.locator(".splatvol-clip input").first.fill("500")
        # A largest value has no clip: the widget says so, and goes on.
        page.wait_for_selector(".splatvol-error:has-text('clip')")
        page.select_option(".splatvol-panel select[aria-label=Show]", "")
        clipped = at_rest(page, projected)
        screen(page, "6-clipped")

        page.dblclick(CANVAS)
        at_rest(page, clipped)
        assert page.locator(".splatvol-error").is_hidden()
        assert problems == []

        page.keyboard.press("Control+s")
        page.wait_for_function("() => !document.querySelector('.jp-mod-dirty')")
        wait_for_outputs(tmp_path / "head.ipynb")
        page.close()

    outputs = json.loads((tmp_path / "head.ipynb").read_text())["cells"][0]["outputs"]
    pictures = [output["data"]["image/png"] for output in outputs if "image/png" in output["data"]]
    assert [len(base64.b64decode(picture)) <= 300_000 for picture in pictures] == [True]
    reopen_without_kernel(browser, tmp_path)
    export(tmp_path)


def test_the_widget_turns_in_notebook_7(browser: Any, tmp_path: Path) -> None:
    pytest.importorskip("notebook", reason="Notebook is not installed")
    (tmp_path / "head.ipynb").write_text(notebook(cell(CODE)))
    with lab(tmp_path, program="notebook") as address:
        page = opened(browser, address, "head.ipynb", way="notebooks")
        problems: list[str] = []
        page.on("pageerror", lambda error: problems.append(str(error)))
        run(page)
        first = at_rest(page)
        assert 0.1 < share_of_background(page, CANVAS) < 0.9
        box = page.locator(CANVAS).bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 80, y, steps=10)
        page.mouse.up()
        turned = at_rest(page, first)
        screen(page, "8-notebook-7")
        assert turned != first
        assert 0.1 < share_of_background(page, CANVAS) < 0.9
        assert problems == []
        page.close()


#: It holds the interpreter, so that no thread of the kernel answers either, for longer than a busy machine draws.
BUSY = "sum(range(2_000_000_000))"


def test_the_widget_turns_while_the_kernel_is_busy(browser: Any, tmp_path: Path) -> None:
    if _browser.engine() is None or _browser.notice():
        pytest.skip("the package has no engine for browsers of its own sources: cargo xtask web --dev")
    (tmp_path / "head.ipynb").write_text(notebook(cell(CODE), {**cell(BUSY), "id": "two"}))
    with lab(tmp_path) as address:
        page = opened(browser, address, "head.ipynb")
        problems: list[str] = []
        page.on("pageerror", lambda error: problems.append(str(error)))
        run(page)
        first = at_rest(page)
        page.wait_for_selector(f"{CANVAS}[data-workers]", timeout=60_000)
        assert at_rest(page) == first
        page.locator(".jp-Notebook .jp-CodeCell .cm-content").nth(1).click()
        page.keyboard.press("Shift+Enter")
        busy = ".jp-InputPrompt:text('[*]')"
        page.wait_for_selector(busy)
        box = page.locator(CANVAS).bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        seen = {first}
        for step in range(1, 9):
            page.mouse.move(x + 10 * step, y)
            page.wait_for_timeout(250)
            seen.add(str(page.evaluate("canvas => document.querySelector(canvas).toDataURL()", CANVAS)))
        page.mouse.up()
        page.wait_for_timeout(1500)
        screen(page, "9-busy")
        # The kernel is at work all the while, and the page draws.
        assert page.locator(busy).count() == 1
        assert page.locator(f"{CANVAS}[data-final=true]").count() == 0
        assert len(seen) >= 5
        assert 0.1 < share_of_background(page, CANVAS) < 0.9
        drawn = page.evaluate("canvas => document.querySelector(canvas).toDataURL()", CANVAS)
        page.wait_for_selector(busy, state="detached", timeout=240_000)
        rest = at_rest(page)
        screen(page, "10-idle")
        # All of the data were small enough, so the page's last picture is the kernel's.
        assert rest == drawn
        assert problems == []
        page.close()


def test_the_widget_turns_by_webgpu(browser: Any, tmp_path: Path) -> None:
    if _browser.engine() is None or _browser.notice() or _browser.gpu_engine() is None:
        pytest.skip("the package has no GPU engine for browsers of its own sources: cargo xtask-webgpu --dev")
    (tmp_path / "head.ipynb").write_text(notebook(cell(CODE)))
    # A device that the processor imitates.
    device = ["--no-sandbox", "--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"]
    other = browser.browser_type.launch(executable_path=CHROMIUM, args=device)
    with contextlib.closing(other), lab(tmp_path) as address:
        page = opened(other, address, "head.ipynb")
        problems: list[str] = []
        page.on("pageerror", lambda error: problems.append(str(error)))
        page.evaluate("globalThis.splatvolImitatedGpu = true")
        run(page)
        first = at_rest(page)
        page.wait_for_selector(f"{CANVAS}[data-webgpu=true]", timeout=120_000)
        assert at_rest(page) == first
        box = page.locator(CANVAS).bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(x, y)
        page.mouse.down()
        drafts = set()
        for step in range(1, 7):
            page.mouse.move(x + 12 * step, y)
            page.wait_for_timeout(400)
            drafts.add(str(page.evaluate("canvas => document.querySelector(canvas).toDataURL()", CANVAS)))
        screen(page, "11-webgpu")
        assert 0.1 < share_of_background(page, CANVAS) < 0.9
        assert page.locator(f"{CANVAS}[data-webgpu=true]").count() == 1
        assert len(drafts) >= 2
        page.mouse.up()
        at_rest(page, first)
        screen(page, "12-webgpu-rest")
        assert problems == []


def wait_for_outputs(path: Path) -> None:
    for _ in range(100):
        if json.loads(path.read_text())["cells"][0]["outputs"]:
            return
        time.sleep(0.1)
    raise AssertionError("the notebook was not saved")


def reopen_without_kernel(browser: Any, folder: Path) -> None:
    """A new server, which has no kernels; it trusts the notebook, so that JupyterLab tries to show the widget too."""
    none = ("--KernelSpecManager.allowed_kernelspecs=none", "--KernelSpecManager.ensure_native_kernel=False")
    with lab(folder, *none) as address:
        page = opened(browser, address, "head.ipynb?reset")
        page.wait_for_selector(".jp-OutputArea img")
        page.wait_for_timeout(1500)
        screen(page, "7-reopened")
        assert page.locator(".jp-OutputArea img").is_visible()
        assert 0.1 < share_of_background(page, ".jp-OutputArea img") < 0.9
        page.close()


def export(folder: Path) -> None:
    """Nbconvert's page shows the picture, without scripts of others."""
    run = [sys.executable, "-m", "nbconvert", "--to", "html", "head.ipynb"]
    subprocess.run(run, cwd=folder, check=True, capture_output=True)
    assert (folder / "head.html").read_text().count('src="data:image/png;base64,') == 1
