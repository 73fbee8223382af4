"""The HTML of a report: one file, no links to the outside, no script."""

from html import escape

import style

CSS = """
:root { --ink: #1d2733; --soft: #5b6875; --line: #dfe4ea; --accent: #0072B2; --warn: #9a4b00; }
* { box-sizing: border-box; }
body { font: 16px/1.55 system-ui, -apple-system, "Segoe UI", "DejaVu Sans", sans-serif; color: var(--ink);
       background: #fff; max-width: 62rem; margin: 0 auto; padding: 2rem 1.25rem 4rem; }
h1 { font-size: 1.7rem; line-height: 1.25; margin: 0 0 .3rem; }
h2 { font-size: 1.2rem; margin: 2.4rem 0 .6rem; padding-top: .9rem; border-top: 1px solid var(--line); }
p { margin: .5rem 0; } .soft, figcaption { color: var(--soft); font-size: .92rem; }
figure { margin: .8rem 0 1.4rem; } img { width: 100%; height: auto; display: block; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: .6rem 0; font-size: .95rem; }
th, td { padding: .28rem 1.1rem .28rem 0; text-align: left; border-bottom: 1px solid var(--line); vertical-align: top; }
th { font-weight: 600; } td.n, th.n { text-align: right; }
.scroll { overflow-x: auto; }
.facts { display: grid; grid-template-columns: repeat(auto-fill, minmax(10.5rem, 1fr)); gap: .6rem 1.4rem; }
.facts div { border-left: 3px solid var(--accent); padding-left: .7rem; }
.facts dt { color: var(--soft); font-size: .85rem; } .facts dd { margin: 0; font-size: 1.08rem; font-weight: 600; }
.badge { display: inline-block; border: 1px solid; border-radius: .3rem; padding: 0 .5rem; font-size: .85rem;
         font-weight: 600; }
.good { color: #00684b; } .bad { color: #a32100; }
.note { border-left: 3px solid #E69F00; background: #fdf6e7; padding: .5rem .8rem; margin: .5rem 0; }
pre { background: #f6f8fa; padding: .9rem; overflow-x: auto; font-size: .85rem; line-height: 1.45; }
summary { cursor: pointer; color: var(--accent); } code { font-size: .9em; }
@media print { body { max-width: none; padding: 0; font-size: 11pt; } h2 { break-after: avoid; }
               figure, table, .note { break-inside: avoid; } details > pre { white-space: pre-wrap; } }
"""


def document(title, sections):
    """Sections are HTML strings; empty ones are dropped."""
    return ("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
            "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
            f"<title>{escape(title)}</title>\n<style>{CSS}</style>\n</head>\n<body>\n"
            + "\n".join(s for s in sections if s) + "\n</body>\n</html>\n")


def section(identity, heading, *parts):
    body = "\n".join(p for p in parts if p)
    return f"<section id=\"{identity}\">\n<h2>{escape(heading)}</h2>\n{body}\n</section>" if body else ""


def paragraph(text, kind=""):
    return f"<p class=\"{kind}\">{escape(text)}</p>" if text else ""


def notes(texts):
    return "\n".join(f"<div class=\"note\">{escape(str(text))}</div>" for text in texts)


def picture(data, alt, caption="", otherwise=""):
    """`data`: bytes of a PNG or an SVG, embedded; without data the sentence `otherwise`."""
    if not data:
        return paragraph(otherwise, "soft")
    below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return f"<figure><img alt=\"{escape(alt)}\" src=\"{style.data_uri(data)}\">{below}</figure>"


def facts(pairs):
    items = "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>" for name, value in pairs if value)
    return f"<dl class=\"facts\">{items}</dl>" if items else ""


def table(headers, rows):
    """A header that starts with `#` is right-aligned, as are its cells."""
    numeric = [h.startswith("#") for h in headers]

    def cells(tag, values):
        return "".join(f"<{tag}{' class=n' if n else ''}>{escape(str(v))}</{tag}>" for v, n in zip(values, numeric))

    head = cells("th", [h.lstrip("#") for h in headers])
    body = "\n".join(f"<tr>{cells('td', row)}</tr>" for row in rows)
    if not rows:
        return ""
    return f"<div class=\"scroll\"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>{body}</tbody>\n</table></div>"


def folded(summary, text):
    return f"<details><summary>{escape(summary)}</summary>\n<pre>{escape(text)}</pre></details>" if text else ""
