"""Blocks of a DXF drawing taken apart: every entity with the layer that it is on, where its block was inserted."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from selfmotion.errors import InvalidInputError
from selfmotion.exchange.ledger import Ledger

_DEEPEST = 50
_MOST_INSERTS = 20_000


class Blocks:
    """The entities of the model space, those inside inserted blocks included and hidden ones left out.

    Annotations are not taken apart: the lines of a dimension are none of the workpiece.

    Parameters
    ----------
    document : ezdxf document
    ledger : Ledger
        Gets what is hidden, and what cannot be placed as its insert asks for.
    """

    def __init__(self, document: Any, ledger: Ledger) -> None:
        self._document, self._ledger = document, ledger
        layers = {layer.dxf.name.lower(): layer for layer in document.layers}
        self._frozen = {name for name, layer in layers.items() if layer.is_frozen()}
        self._off = {name for name, layer in layers.items() if layer.is_off()}
        self._inserts = 0

    def entities(self) -> Iterator[Any]:
        """Yield the entities that are seen, in the order of the file."""
        yield from self._seen(self._document.modelspace(), None, 0)

    def _seen(self, entities: Iterable[Any], above: str | None, depth: int) -> Iterator[Any]:
        for entity in entities:
            kind, layer = entity.dxftype(), str(_said(entity, "layer", "0")).lower()
            if layer == "0" and above is not None:  # inside a block that is the layer of its insert
                layer = above
            # An insert stands on a layer, but what it inserts is switched off only by its own.
            off = layer in self._off and kind != "INSERT"
            if off or layer in self._frozen or _said(entity, "invisible", 0):
                self._ledger.note(f"{kind} that is hidden")
            elif kind == "INSERT":
                yield from self._inserted(entity, layer, depth)
            else:
                yield entity

    def _inserted(self, insert: Any, layer: str, depth: int) -> Iterator[Any]:
        self._inserts += 1
        if depth >= _DEEPEST or self._inserts > _MOST_INSERTS:
            raise wrong(insert, "inserts itself, or too many others", "explode it in the drawing program")
        name = str(_said(insert, "name", ""))
        if not name or insert.block() is None:
            raise wrong(insert, f"inserts the block {name!r}, which is not in the file", "insert or export it again")
        if insert.mcount > _MOST_INSERTS - self._inserts:
            raise wrong(insert, "inserts itself, or too many others", "correct its rows and columns")
        if insert.mcount > 1:
            yield from self._seen(_copies(insert), layer, depth + 1)
            return
        if insert.attribs:
            self._ledger.note("ATTRIB")
        try:
            inside = list(insert.virtual_entities(skipped_entity_callback=self._left_out))
        except RecursionError:  # a block in itself, askew
            raise wrong(insert, "inserts itself", "explode it in the drawing program") from None
        except Exception as error:  # whatever a broken entity makes of its parser
            raise wrong(insert, f"is not read ({error})", "correct it in the drawing program") from None
        yield from self._seen(inside, layer, depth + 1)

    def _left_out(self, entity: Any, why: str) -> None:
        self._ledger.note(f"{entity.dxftype()} in a block, {why}")


def _copies(insert: Any) -> Iterator[Any]:
    """Yield the inserts of an insert in rows and columns."""
    try:
        yield from insert.multi_insert()
    except Exception as error:  # whatever a broken entity makes of its parser
        raise wrong(insert, f"is not read ({error})", "correct it in the drawing program") from None


def _said(entity: Any, name: str, default: Any) -> Any:
    """Return an attribute of an entity, of which broken ones lack even those that all have."""
    from ezdxf.lldxf.const import DXFError

    try:
        return entity.dxf.get(name, default)
    except DXFError:
        return default


def wrong(entity: Any, reason: str, remedy: str) -> InvalidInputError:
    """Return the error of an entity, named by its handle; what a block draws by that of its original."""
    original = entity
    while original.dxf.handle is None and getattr(original, "source_of_copy", None) is not None:
        original = original.source_of_copy
    return InvalidInputError(f"{entity.dxftype()} of handle {original.dxf.handle or '?'}", reason, remedy)
