"""Reads tables of an R data file, with R's serialization (version 3, XDR) as far as they need it.

The format is described in "R Internals", section "Serialization Formats". Kinds of items that a
table of numbers and texts does not have are refused.
"""

import bz2
import struct

LIST, CHARACTERS, LOGICALS, INTEGERS, NUMBERS, TEXTS, ITEMS = 2, 9, 10, 13, 14, 16, 19
SYMBOL, COMPACT, EMPTY, NULL, REFERENCE = 1, 238, 242, 254, 255
HAS_ATTRIBUTES, HAS_TAG = 0x200, 0x400
HEADER = b"RDX3\nX\n"


class Reader:
    """Items one after another; a vector is the pair of its values and its attributes."""

    def __init__(self, data: bytes) -> None:
        """Begin behind the header: three versions and the name of the encoding."""
        if not data.startswith(HEADER):
            raise ValueError("this is no R data file of version 3 in XDR")
        self.data, self.at, self.symbols = data, len(HEADER), []
        for _ in range(3):
            self.integer()
        self.take(self.integer())

    def take(self, n: int) -> bytes:
        """Take the next n bytes."""
        self.at += n
        if self.at > len(self.data):
            raise ValueError("the R data file ends too early")
        return self.data[self.at - n : self.at]

    def integer(self) -> int:
        """Take an integer of four bytes."""
        return struct.unpack(">i", self.take(4))[0]

    def characters(self) -> str | None:
        """Take a text; none where R has NA."""
        kind = self.integer() & 255
        if kind != CHARACTERS:
            raise ValueError(f"a text was expected, and an item of kind {kind} is there")
        n = self.integer()
        return None if n < 0 else self.take(n).decode()

    def item(self) -> object:
        """Take the next item, whatever it is."""
        flags = self.integer()
        kind = flags & 255
        if kind in {NULL, EMPTY}:
            return None
        if kind == REFERENCE:
            return self.symbols[(flags >> 8) - 1]
        if kind == SYMBOL:
            self.symbols.append(self.characters())
            return self.symbols[-1]
        if kind == LIST:
            return self.pairs(flags)
        if kind == COMPACT:
            return self.compact()
        values = self.values(kind)
        return values, dict(self.item()) if flags & HAS_ATTRIBUTES else {}

    def pairs(self, flags: int) -> list:
        """Take a list of (tag, value)."""
        if flags & HAS_ATTRIBUTES:
            self.item()
        tag = self.item() if flags & HAS_TAG else None
        first, rest = self.item(), self.item()
        if rest is None:
            rest = []
        return [(tag, first), *(rest if isinstance(rest, list) else [(None, rest)])]

    def compact(self) -> tuple[list, dict]:
        """Take a vector that R wrote in a shorter form."""
        info, state, attributes = self.item(), self.item(), self.item()
        name = info[0][1]
        if name.startswith("wrap_"):
            values = state[0][1][0]
        elif name == "compact_intseq":
            n, first, step = state[0]
            values = [int(first + step * k) for k in range(int(n))]
        elif name == "deferred_string":
            values = [str(value) for value in state[0][1][0]]
        else:
            raise ValueError(f"{name}: a short form that is not known here")
        return values, dict(attributes or [])

    def values(self, kind: int) -> list:
        """Take the values of a vector."""
        n = self.integer()
        if kind in {LOGICALS, INTEGERS}:
            return list(struct.unpack(f">{n}i", self.take(4 * n)))
        if kind == NUMBERS:
            return list(struct.unpack(f">{n}d", self.take(8 * n)))
        if kind == TEXTS:
            return [self.characters() for _ in range(n)]
        if kind == ITEMS:
            return [self.item() for _ in range(n)]
        raise ValueError(f"items of kind {kind} are not known here")


def table(data: bytes, name: str) -> dict[str, list]:
    """Take the columns of the table of this name from a file that R compressed by bzip2."""
    columns, attributes = dict(Reader(bz2.decompress(data)).item())[name]
    return {
        column: values for column, (values, _) in zip(attributes["names"][0], columns, strict=True)
    }
