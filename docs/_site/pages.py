"""What the site adds to the Markdown pages: the table of contents, links of citations, names of files of the tree."""

import re
import sys
from inspect import Signature
from pathlib import Path
from typing import Any

from docutils import nodes
from pygments.lexers.special import TextLexer
from sphinx.application import Sphinx
from sphinx.util.inspect import stringify_signature

DOCS = Path(__file__).resolve().parent.parent
ROOT = DOCS.parent
REFERENCE = DOCS / "reference"
sys.path.insert(0, str(ROOT / "tests" / "docs"))
from citations import anchors, citations

CONTENTS = "```{{toctree}}\n:hidden:\n:caption: {caption}\n\n{pages}\n```\n"


def contents(app: Sphinx, page: str, source: list[str]) -> None:
    """The links of start pages are the site's table of contents; pages without a link there come last."""
    if page not in ("index", "reference/README"):
        return
    seen: set[str] = set()
    first = 2 if page == "index" else 1  # the links of the start page's introduction come again below
    for section in re.split(r"^##? ", source[0], flags=re.MULTILINE)[first:]:
        caption, _, body = section.partition("\n")
        pages = list(dict.fromkeys(link for link in re.findall(r"\]\(([\w/-]+)\.md\)", body) if link not in seen))
        seen.update(pages)
        if pages:
            source[0] += "\n" + CONTENTS.format(caption=caption, pages="\n".join(pages))
    if page == "index":
        others = {
            str(path.relative_to(DOCS).with_suffix("")) for path in DOCS.rglob("*.md") if REFERENCE not in path.parents
        }
        if left := sorted(others - seen - {"index"}):
            source[0] += "\n" + CONTENTS.format(caption="More", pages="\n".join(left))


def outside(app: Sphinx, page: str, source: list[str]) -> None:
    """A link to a file of the tree that is no page of the site becomes the file's name."""

    def name(match: re.Match[str]) -> str:
        target = ((DOCS / page).parent / match[2].partition("#")[0]).resolve()
        if DOCS in target.parents or not target.is_relative_to(ROOT):
            return match[0]
        if not target.exists():
            return match[0]  # MyST says that it leads nowhere
        relative = str(target.relative_to(ROOT))
        return f"`{relative}`" if match[1] == relative else f"{match[1]} (`{relative}`)"

    source[0] = re.sub(r"(?<!!)\[([^\]\n]+)\]\((\.\.?/[^)\s]+)\)", name, source[0])


def link_citations(app: Sphinx, doctree: nodes.document) -> None:
    """Each citation links to the anchor that it names, the first one of a list."""
    here = app.env.docname
    places = anchors(REFERENCE)
    for text in list(doctree.findall(nodes.Text)):
        parent: Any = text.parent
        if (
            isinstance(parent, nodes.FixedTextElement | nodes.reference | nodes.title | nodes.raw)
            or parent.tagname == "pending_xref"
        ):
            continue
        words, parts, at = str(text), [], 0
        for citation in citations(words):
            target = citation.targets[0]
            if target not in places:
                continue
            page, _, anchor = target.partition("#")
            file = app.builder.get_relative_uri(here, f"reference/{page[:-3]}")
            link = nodes.reference(
                "", words[citation.begin : citation.end], internal=True, refuri=f"{file}#{anchor}" if anchor else file
            )
            link["classes"].append("citation")
            parts += [nodes.Text(words[at : citation.begin]), link]
            at = citation.end
        if parts:
            parts.append(nodes.Text(words[at:]))
            parent.replace(text, parts)


def anchored_links(app: Sphinx, doctree: nodes.document) -> None:
    """Links to `<a id>` anchors of reference pages, which MyST does not know."""
    places = anchors(REFERENCE)
    here = app.env.docname
    for link in list(doctree.findall(lambda n: n.tagname == "pending_xref")):
        target, anchor = link.get("reftarget", ""), link.get("reftargetid")
        if not anchor:
            continue
        page = Path(str(target)).name.removesuffix(".md") + ".md"
        if f"{page}#{anchor}" in places:
            file = app.builder.get_relative_uri(here, f"reference/{page[:-3]}")
            link.replace_self(nodes.reference("", "", *link.children, internal=True, refuri=f"{file}#{anchor}"))


def short_signature(
    app: Sphinx, what: str, name: str, called: Any, options: Any, signature: str | None, returns: str | None
) -> tuple[str, str | None] | None:
    """Settings as keywords (cmrc/keywords.py) are `**keywords` here, as in `help`: docs/configuration.md has them."""
    found = getattr(called.__init__ if what == "class" else called, "__signature__", None)
    if not hasattr(found, "short"):
        return None
    of = found.short()
    if what == "class":
        of = of.replace(parameters=list(of.parameters.values())[1:], return_annotation=Signature.empty)
    text, _, result = stringify_signature(of).partition(" -> ")
    return text, result or None


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_lexer("asm", TextLexer)  # Pygments knows other assemblers
    app.connect("autodoc-process-signature", short_signature)
    app.connect("source-read", contents)
    app.connect("source-read", outside)
    app.connect("doctree-read", anchored_links)
    app.connect("doctree-read", link_citations)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
