"""G-code as words: one block per line, comments dropped, every character accounted for."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from selfmotion.errors import InvalidInputError

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)"
_WORD = re.compile(rf"\s*([A-Za-z])\s*({_NUMBER})", re.ASCII)
_COMMENT = re.compile(r"\([^()]*\)|;.*")
_EXPONENT = re.compile(r"[\d.][eE][+-]?\d")
# Lines of whole programs and of controllers that are no words.
_ASIDE = re.compile(r"\s*(?:\$.*|[Mm]11[78]\b.*)")
_SKIPPED = re.compile(r"/[1-9]?(?![0-9])")
_LINE_END = re.compile(r"\r\n?|\n")
_END_OF_FILE = "\x1a"  # as old systems write it
_LARGEST = 1e9


class Word(NamedTuple):
    """A letter and its number."""

    letter: str
    value: float

    def __str__(self) -> str:
        return f"{self.letter}{self.value:g}"


class Block(NamedTuple):
    """The words of one line.

    Attributes
    ----------
    line : int
        Counted from 1.
    words : list of Word
    aside : str
        What is no word and has no meaning for the path; to be reported.
    last : bool
        Whether the program ends here, whatever follows.
    """

    line: int
    words: list[Word]
    aside: str = ""
    last: bool = False


def blocks(text: str) -> Iterator[Block]:
    """Yield the blocks of a program that hold anything.

    Raises
    ------
    InvalidInputError
        Naming the line of what is no word.
    """
    begun = framed = False
    for number, raw in enumerate(_LINE_END.split(text.rstrip(_END_OF_FILE)), 1):
        content = raw.strip()
        if content == "%":
            if framed:  # what follows the second one is no part of the program
                yield Block(number, [], "% (end of the program)", True)
                return
            framed = not begun
        if not content or content == "%":
            continue
        begun = True
        if _ASIDE.fullmatch(content):
            yield Block(number, [], content.split()[0])
            continue
        if "(" in content or ";" in content:
            content = _COMMENT.sub(" ", content).strip()
            if not content:
                continue
        aside = ""
        if (skipped := _SKIPPED.match(content)) is not None:
            content, aside = content[skipped.end() :], "/ (block delete), read as if switched off"
        yield Block(number, _words(content, number), aside)


def _words(content: str, number: int) -> list[Word]:
    words, at = [], 0
    if _EXPONENT.search(content):
        raise _unread(number, content, "writes a number with an exponent", "write it out: G-code has no exponents")
    while at < len(content):
        found = _WORD.match(content, at)
        if found is None:
            rest = content[at:].strip()
            if not rest:
                break
            if rest[0] in "#[" or "[" in rest or "#" in rest:
                raise _unread(number, rest, "holds a variable or an expression", "write the program out in numbers")
            if rest[0] in "()":
                raise _unread(number, rest, "has parentheses that do not pair", "close every comment in its line")
            raise _unread(number, rest, "is not understood", "write words such as G1 X10.5; comments stand in ( )")
        value = float(found[2])
        if abs(value) > _LARGEST:
            raise _unread(number, found[0], f"exceeds {_LARGEST:g} in magnitude", "correct it")
        words.append(Word(found[1].upper(), value))
        at = found.end()
    return words


def _unread(number: int, text: str, reason: str, remedy: str) -> InvalidInputError:
    return InvalidInputError(f"line {number}", reason, remedy, text)
