"""The documentation as static pages: mkdocs builds them without a warning, and they load nothing from elsewhere.

Every reference of every page (links, anchors, pictures, styles, scripts) leads to something in the built site. Ends with 77,
which ctest counts as skipped, where mkdocs is not installed (scripts/setup.sh test)."""
import html.parser
import pathlib
import shutil
import subprocess
import sys
import tempfile
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
LOADED = {("script", "src"), ("img", "src"), ("link", "href"), ("iframe", "src")}


class Page(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.ids, self.references = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name == "id":
                self.ids.add(value)
            if name in ("href", "src") and value:
                self.references.append((tag, name, value))


def check(site):
    problems, external = [], set()
    pages = {p: Page(p.read_text(encoding="utf-8")) for p in sorted(site.rglob("*.html"))}
    for path, page in pages.items():
        if path.name == "404.html":
            continue  # is served for any address, and has none of its own
        for tag, name, value in page.references:
            parts = urllib.parse.urlsplit(value)
            if parts.scheme or parts.netloc:
                if (tag, name) in LOADED:
                    problems.append(f"{path.name}: loads {value}")
                external.add(value)
                continue
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            anchor = urllib.parse.unquote(parts.fragment)
            if not target.is_file():
                problems.append(f"{path.name}: {value} leads nowhere")
            elif anchor and target in pages and anchor not in pages[target].ids:
                problems.append(f"{path.name}: {value}: no such anchor")
    return len(pages), problems, external


def main():
    if not shutil.which("mkdocs"):
        print("skipped: mkdocs is not installed (scripts/setup.sh test)")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as temporary:
        site = pathlib.Path(temporary) / "site"
        done = subprocess.run(["mkdocs", "build", "--strict", "--site-dir", site], cwd=ROOT, text=True, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        assert done.returncode == 0 and "WARNING" not in done.stdout, done.stdout
        pages, problems, external = check(site)
        print("links to other sites (not fetched):", *sorted(external), sep="\n  ")
        print(f"{pages} pages, {len(problems)} problems", *problems, sep="\n")
        assert pages > 15 and not problems
        # The check can fail.
        page = site / "guide.html"
        page.write_text(page.read_text(encoding="utf-8") + '<a href="cases.html#nothing-here">x</a><a href="gone.html">y</a>'
                        '<script src="https://elsewhere.example/x.js"></script>', encoding="utf-8")
        assert len(check(site)[1]) == 3


if __name__ == "__main__":
    main()
