"""Every page of a report in Chromium: `python tests/browser.py --axe path/to/axe.min.js`; not part of `make test`.

On a desktop, on a phone and in the dark: no rule of axe-core is broken, nothing is loaded, no error is logged, nothing
sticks out sideways, and the pages with a limit are no longer than it. It needs Playwright (`pip install playwright`),
Debian's chromium, and axe-core (`npm install axe-core`).
"""

import argparse
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

LOOKS = ((1400, "light"), (390, "light"), (1400, "dark"))
LONGEST_PX = {"index.html": 3000, "claims.html": 3500, "comparison.html": 6000}
"""At 1400 pixels of width."""
PATIENCE_MS = 300_000


def main() -> int:
    parser = argparse.ArgumentParser(description="Look at every page of a report in Chromium.")
    parser.add_argument("--report", type=Path, default=Path("report"), help="folder of the report")
    parser.add_argument("--axe", type=Path, required=True, help="axe.min.js of axe-core")
    parser.add_argument("--page", action="append", help="only this file (may be given again)")
    parser.add_argument("--pictures", type=Path, help="folder for a picture of each page, and for its print as PDF")
    options = parser.parse_args()
    found = 0
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=["--no-sandbox"])
        for path in sorted(options.report.glob("*.html")):
            if path.name == "bed-3d.html" or (options.page and path.name not in options.page):
                continue
            for width, scheme in LOOKS:
                lines = look(browser, path, width, scheme, options.axe.read_text(), options.pictures)
                found += len(lines)
                print(f"{path.name}, {width}, {scheme}: {'; '.join(lines) or 'nothing found'}", flush=True)
        browser.close()
    return 1 if found else 0


def look(browser, path: Path, width: int, scheme: str, axe: str, pictures: Path | None) -> list[str]:
    """What is wrong with one page in one look, a line each."""
    context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=scheme)
    page, lines = context.new_page(), []
    page.set_default_timeout(PATIENCE_MS)
    page.on("console", lambda message: lines.append(message.text) if message.type == "error" else None)
    page.on("pageerror", lambda error: lines.append(str(error)))
    page.on("request", lambda asked: lines.append(f"loads {asked.url}") if asked.url.startswith("http") else None)
    page.goto(path.resolve().as_uri())
    high, wide = page.evaluate("[document.documentElement.scrollHeight, document.documentElement.scrollWidth]")
    if wide > width:
        lines.append(f"{wide} pixels wide")
    if width == 1400 and high > LONGEST_PX.get(path.name, high):
        lines.append(f"{high} pixels high, above {LONGEST_PX[path.name]}")
    page.evaluate(axe)
    broken = page.evaluate("axe.run(document, {resultTypes: ['violations']})")["violations"]
    lines += [f"{rule['id']}: {rule['nodes'][0]['html'][:120]}" for rule in broken]
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
        page.screenshot(path=pictures / f"{path.stem}-{width}-{scheme}.png", full_page=True, timeout=PATIENCE_MS)
        if (width, scheme) == LOOKS[0]:
            page.pdf(path=pictures / f"{path.stem}.pdf", prefer_css_page_size=True)
    context.close()
    return lines


if __name__ == "__main__":
    sys.exit(main())
