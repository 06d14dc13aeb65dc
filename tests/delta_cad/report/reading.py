"""A page as another reader sees it: its elements, texts, scripts and data."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from html.parser import HTMLParser
from typing import Any

VOID = {"meta", "link", "input", "br", "img", "polygon", "rect", "line", "i"}


@dataclass
class Element:
    """An element: tag, attributes, the text within it."""

    tag: str
    attributes: dict[str, str]
    text: str = ""
    cells: list[str] = field(default_factory=list)


class Page(HTMLParser):
    """Everything on a page, in order."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.elements: list[Element] = []
        self._open: list[Element] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        element = Element(tag, {name: value or "" for name, value in attrs})
        self.elements.append(element)
        if tag not in VOID:
            self._open.append(element)

    def handle_endtag(self, tag: str) -> None:
        if tag in VOID:
            return
        assert self._open, f"</{tag}> closes nothing"
        assert self._open[-1].tag == tag, f"</{tag}> closes <{self._open[-1].tag}>"
        self._open.pop()

    def handle_data(self, data: str) -> None:
        for element in self._open:
            element.text += data

    def close(self) -> None:
        super().close()
        assert self._open == []

    def all(self, tag: str, **attributes: str) -> list[Element]:
        found = [e for e in self.elements if e.tag == tag]
        return [e for e in found if attributes.items() <= e.attributes.items()]

    def one(self, name: str) -> Element:
        (element,) = (e for e in self.elements if e.attributes.get("id") == name)
        return element

    def scripts(self) -> list[str]:
        return [e.text for e in self.all("script") if "type" not in e.attributes]

    def data(self) -> dict[str, Any]:
        return json.loads(self.one("data").text)

    def rows(self, after: str, tag: str = "tr") -> list[list[str]]:
        """Texts of the cells of every row after an element, up to the next section."""
        begin = next(k for k, e in enumerate(self.elements) if e.attributes.get("id") == after)
        rows: list[list[str]] = []
        for element in self.elements[begin + 1 :]:
            if element.tag == "section":
                break
            if element.tag == tag:
                rows.append([])
            elif element.tag in ("th", "td") and rows:
                rows[-1].append(element.text.strip())
        return rows
