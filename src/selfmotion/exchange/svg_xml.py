"""SVG as a tree of elements that know their line: no document types, no entities, nothing from elsewhere."""

from __future__ import annotations

from dataclasses import dataclass, field

from selfmotion.errors import InvalidInputError

_SVG = "http://www.w3.org/2000/svg"
_DEEPEST = 200


@dataclass
class Element:
    """One element.

    Attributes
    ----------
    name : str
        Without its namespace; empty if that is not SVG's.
    attributes : dict of str to str
        By name without namespace.
    line : int
    children : list of Element
    text : str
        The rules of a style sheet; of other elements it is not kept.
    """

    name: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)
    text: str = ""


def parse_svg(data: bytes) -> Element:
    """Return the root of an SVG document, in the encoding that it states, UTF-8 if it states none.

    Raises
    ------
    InvalidInputError
        If it is not XML, not SVG, nested too deeply, or brings a document type or entities: those are how small files
        grow without bounds and how files read others.
    """
    from xml.parsers import expat

    parser = expat.ParserCreate(namespace_separator=" ")
    root = Element("", {}, 0)
    above = [root]

    def start(name: str, attributes: dict[str, str]) -> None:
        if len(above) > _DEEPEST:
            raise _refused(parser.CurrentLineNumber, "nests more than 200 elements", "flatten its groups")
        local = name.removeprefix(f"{_SVG} ")
        element = Element(
            "" if " " in local else local,
            {key.rsplit(" ", 1)[-1]: value for key, value in attributes.items()},
            parser.CurrentLineNumber,
        )
        above[-1].children.append(element)
        above.append(element)

    def characters(text: str) -> None:
        if above[-1].name == "style":
            above[-1].text += text

    def refuse(*_: object) -> None:
        remedy = "delete its <!DOCTYPE …> and <!ENTITY …>; SVG needs neither"
        raise _refused(parser.CurrentLineNumber, "declares a document type or entities", remedy)

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: above.pop()
    parser.CharacterDataHandler = characters
    parser.StartDoctypeDeclHandler = refuse
    parser.EntityDeclHandler = refuse
    if data.startswith(b"\x1f\x8b"):
        raise InvalidInputError("", "is packed, as files ending in .svgz are", "unpack it with gunzip")
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        reason = f"is not XML: {expat.ErrorString(error.code)}"
        raise _refused(error.lineno, reason, "is it a whole SVG file?") from None
    except (LookupError, UnicodeError, ValueError) as error:
        if isinstance(error, InvalidInputError):
            raise
        raise _refused(1, f"states an encoding that is not read ({error})", "save it as UTF-8") from None
    if not root.children or root.children[0].name != "svg":
        raise _refused(1, "is not an SVG document", 'start with <svg xmlns="http://www.w3.org/2000/svg" …>')
    return root.children[0]


def _refused(line: int, reason: str, remedy: str) -> InvalidInputError:
    return InvalidInputError(f"line {line}", reason, remedy)
