"""Every relative link and anchor of README.md and docs/ leads somewhere: links_test.py [ROOT]

Anchors are those that both GitHub and mkdocs make of a heading. Links to other sites are listed, never fetched.
Also: every page is in the navigation of mkdocs.yml, pages link to nothing outside of docs/ (the static site has nothing
else), every picture is shown by some page, every source file that a page names exists, and docs/benchmarks.md stays short.
"""
import pathlib
import re
import sys
import unicodedata

ROOT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else __file__).resolve()
ROOT = ROOT if len(sys.argv) > 1 else ROOT.parents[2]
LINK = re.compile(r"!?\[(?:[^\[\]]|\[[^\]]*\])*\]\(\s*<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\s*\)")
SOURCE = re.compile(r"`((?:core|objectives|optimize|casefile|cases|viewer|report|cli|python|include|scripts|tests|bench)/[\w./-]+\.\w+)")
MADE = re.compile(r"/generated/|NAME")  # by scripts/examples.sh; stands for any


def prose(text):
    """Without fences, indented blocks of code and code in lines: what stands there is no link."""
    text = re.sub(r"^(```|~~~).*?^\1[^\n]*$", "", text, flags=re.M | re.S)
    text = re.sub(r"(?:\A|\n\n)(?:    [^\n]*\n)+", "\n\n", text)
    return re.sub(r"`[^`\n]*`", "", text)


def headings(text):
    text = re.sub(r"^(```|~~~).*?^\1[^\n]*$", "", text, flags=re.M | re.S)
    return [re.sub(r"[`*]", "", h) for h in re.findall(r"^#{1,6} +(.+?)\s*#*$", text, re.M)]


def numbered(slugs, joint, first):
    """The second heading of one name gets a number."""
    seen, out = {}, set()
    for slug in slugs:
        count = seen.get(slug, 0)
        seen[slug] = count + 1
        out.add(slug if count == 0 else f"{slug}{joint}{count - 1 + first}")
    return out


def github_slug(heading):
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


def mkdocs_slug(heading):
    plain = unicodedata.normalize("NFKD", heading).encode("ascii", "ignore").decode()
    return re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", plain).strip().lower())


def anchors(page):
    names = headings(page.read_text(encoding="utf-8"))
    return numbered(map(github_slug, names), "-", 1) & numbered(map(mkdocs_slug, names), "_", 1)


def check_page(page, problems, shown, elsewhere):
    text = page.read_text(encoding="utf-8")
    name, docs = page.relative_to(ROOT), ROOT / "docs"
    for target in LINK.findall(prose(text)):
        if re.match(r"[a-z]+:", target):
            elsewhere.add(target)
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        shown.add(file)
        if not file.is_file():
            problems.append(f"{name}: {target}: there is no {path}")
        elif page.is_relative_to(docs) and not file.is_relative_to(docs):
            problems.append(f"{name}: {target}: outside of docs/, which the static pages do not have")
        elif anchor and anchor not in anchors(file):
            problems.append(f"{name}: {target}: no heading gives #{anchor}; there are {', '.join(sorted(anchors(file)))}")
    for source in SOURCE.findall(text):
        if not (ROOT / source).exists() and not MADE.search(source):
            problems.append(f"{name}: `{source}` does not exist")


def navigation():
    """The pages that mkdocs.yml names (as text: this test needs no mkdocs)."""
    return set(re.findall(r":\s*([\w/-]+\.md)\s*$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.M))


def main():
    docs = ROOT / "docs"
    pages = sorted(docs.rglob("*.md"))
    problems, shown, elsewhere = [], set(), set()
    for page in [ROOT / "README.md", *pages]:
        check_page(page, problems, shown, elsewhere)
    listed, there = navigation(), {str(p.relative_to(docs)) for p in pages}
    problems += [f"mkdocs.yml: {p} is not in the navigation" for p in sorted(there - listed)]
    problems += [f"mkdocs.yml: {p} does not exist" for p in sorted(listed - there)]
    problems += [f"{p.relative_to(ROOT)}: no page shows it" for p in sorted((docs / "pictures").iterdir()) if p not in shown]
    if len((docs / "benchmarks.md").read_text(encoding="utf-8").splitlines()) >= 300:
        problems.append("docs/benchmarks.md: 300 lines or more; what was tried and older numbers go to docs/notes")
    if len(sys.argv) > 1:
        problems += [] if shown else ["no link found"]
    print("links to other sites (not fetched):", *sorted(elsewhere), sep="\n  ")
    print(f"{len(pages) + 1} pages, {len(shown)} files linked, {len(problems)} problems")
    print(*problems, sep="\n")
    sys.exit(1 if problems or len(shown) < 10 else 0)


if __name__ == "__main__":
    main()
