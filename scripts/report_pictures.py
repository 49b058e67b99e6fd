#!/usr/bin/env python3
"""Takes the pictures of docs/report.md with a headless Chromium: report_pictures.py REPORT.html FAILED.html OUT_FOLDER

REPORT is the page of a run with several levels (runs/lifting_body-glide-001), FAILED that of a run in which a program
failed. Pictures: report-overview, -progress, -shape, -field (a pressure), -patches, -failures, and -narrow (a window of
400 pixels).
"""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from browser import Browser  # noqa: E402

report, failed, out = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])


def load(browser, page):
    browser.open(page)
    browser.until("document.documentElement.dataset.ready")
    browser.settle()


def window(browser, name, place=None):
    """What a reader sees who has gone to that place."""
    if place:
        browser.run(f"document.querySelector({place!r}).scrollIntoView()")
    browser.settle()
    browser.screenshot(out / f"{name}.png")
    print(out / f"{name}.png")


with Browser(1180, 880) as b:
    load(b, report)
    window(b, "report-overview")
    window(b, "report-progress", "#progress")
    window(b, "report-shape", "#shapes")
    # What an objective sees, where it has something to show.
    fields = b.run("[...document.querySelector('#shapes select').options].map((o) => o.value).filter((v) => v.endsWith('.cp'))")
    if fields:
        b.choose("Colour", fields[0])
        b.resize(1180, 620)
        window(b, "report-field", "#shapes")
        b.resize(1180, 880)
    b.choose("Colour", "patches:2")
    b.run("document.querySelectorAll('#patches button.patch')[1].click()")
    window(b, "report-patches", "#patches")
    load(b, failed)
    b.run("document.querySelector('details.failure').open = true")
    window(b, "report-failures", "#failures")

# Four windows of a telephone beside each other.
with Browser(400, 800) as b:
    pictures = []
    for page, place in ((report, "header"), (report, "#shapes"), (report, "#patches"), (failed, "#failures")):
        load(b, page)
        b.run(f"document.querySelector({place!r}).scrollIntoView()")
        if place == "#failures":
            b.run("document.querySelector('details.failure').open = true")
        b.settle()
        b.screenshot(out / f"narrow-{len(pictures)}.png")
        pictures.append(out / f"narrow-{len(pictures)}.png")
    sheet = out / "narrow.html"
    sheet.write_text("<body style='margin:0;display:flex;gap:20px;background:#ccc'>"
                     + "".join(f"<img src='{p.name}' width=400>" for p in pictures))
    b.resize(4 * 400 + 60, 800)
    b.open(sheet)
    b.settle()
    b.screenshot(out / "report-narrow.png")
    print(out / "report-narrow.png")
    for file in (*pictures, sheet):
        file.unlink()
