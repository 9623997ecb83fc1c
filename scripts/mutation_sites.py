"""Sites in Rust sources that a subtle change can stand at, for `scripts/mutations.py --draw`.

A site is a token of a function's body: an operator, a number, a condition, an index, the end of a
range. Each has one or more changes. A change replaces the smallest expression that can stand as
`if mutant(k) {new} else {old}`: found by brackets, and by the precedence of the operators around
it. What does not compile all the same, the compiler says.

Left out are comments, texts, attributes, tests, constants, patterns, messages and what is printed
or serialised.
"""

import bisect
import dataclasses
import re

# binary operators by how tightly they bind; a range binds least
TIGHT = {"..": 0, "..=": 0, "||": 1, "&&": 2, "|": 4, "^": 5, "&": 6, "<<": 7, ">>": 7}
TIGHT |= dict.fromkeys(("<", ">", "<=", ">=", "==", "!="), 3)
TIGHT |= {"+": 8, "-": 8, "*": 9, "/": 9, "%": 9, "as": 10}
SUM, OPERAND, RANGE = 8, 11, 0

OTHER = {"+": "-", "-": "+", "*": "/", "/": "*", "&&": "||", "||": "&&", "==": "!=", "!=": "=="}
OTHER |= {
    "<": "<=",
    "<=": "<",
    ">": ">=",
    ">=": ">",
    "+=": "-=",
    "-=": "+=",
    "*=": "/=",
    "/=": "*=",
}

OPEN, CLOSE = {"(": ")", "[": "]", "{": "}"}, {")": "(", "]": "[", "}": "{"}
BOUNDS = {",", ";", "=", "=>", "->", ":", "{", "}", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^="}
BOUNDS |= {
    "if",
    "while",
    "match",
    "in",
    "return",
    "else",
    "let",
    "move",
    "loop",
    "for",
    "break",
    "mut",
}

TOKEN = re.compile(
    r"(?P<number>\d[\d_]*(?:\.\d[\d_]*)?(?:[eE][+-]?\d[\d_]*)?"
    r"(?:_?[iuf](?:8|16|32|64|128|size))?\b)"
    r"|(?P<word>'?\b[A-Za-z_]\w*)"
    r"|(?P<mark>\.\.=|\.\.|::|=>|->|&&|\|\||<<=|>>=|[-+*/%&|^]=|[<>=!]=|[^\w\s])"
)
NOT_CODE = re.compile(
    r"""//[^\n]*|/\*.*?\*/|b?r(?P<hash>\#*)".*?"(?P=hash)|b?"(?:\\.|[^"\\])*\""""
    r"""|b?'(?:\\.[^']*|[^'\\])'""",
    re.DOTALL,
)
# what is said, not computed: macros of messages, functions of texts
MESSAGES = re.compile(
    r"\b(?:format|write|writeln|print|println|eprintln|panic"
    r"|assert|assert_eq|assert_ne|debug_assert"
    r"|debug_assert_eq|unreachable|json|concat)!\s*(?=[(\[{])"
)
CHOSEN_TEXT = re.compile(r'\bif\b[^{};]*\{\s*"[^"]*"\s*\}')
SAID = re.compile(
    r"fmt|serialize|deserialize|json_schema|schema|\w*text|message|\w*report|page|default|expecting"
)


@dataclasses.dataclass
class Site:
    """A token with its changes: what each does, the span that it replaces, and the new text."""

    line: int
    changes: list


def blanked(text, spans):
    """Replace spans by blanks, lines kept."""
    for start, end in spans:
        text = text[:start] + re.sub(r"[^\n]", " ", text[start:end]) + text[end:]
    return text


def closing(text, start):
    """Place behind the bracket that closes the one at `start`."""
    depth = 0
    for place in range(start, len(text)):
        depth += (text[place] in OPEN) - (text[place] in CLOSE)
        if depth == 0:
            return place + 1
    return len(text)


def code_only(text):
    """Rust with literals of texts as `""` and blanks; comments and attributes blank."""

    def short(match):
        token = match[0]
        if token.startswith(("//", "/*")):
            return re.sub(r"[^\n]", " ", token)
        return '"' + re.sub(r"[^\n]", " ", token[1:-1]) + '"'

    text = NOT_CODE.sub(short, text)
    return blanked(
        text, [(m.start(), closing(text, m.end() - 1)) for m in re.finditer(r"#!?\[", text)]
    )


def bodies(code, word):
    """Spans of the bodies of functions that compute and hold the word, none within another."""
    end = 0
    for head in re.finditer(r"(?<!const )\bfn (\w+)", code):
        if head.start() < end:
            continue
        depth, place = 0, head.end()
        while depth or code[place] not in "{;":
            depth += (code[place] in "([") - (code[place] in ")]")
            place += 1
        if code[place] == ";":
            continue
        end = closing(code, place)
        says = "String" in code[head.end() : place] and "format!" in code[place:end]
        if not says and not SAID.fullmatch(head[1]) and re.search(word, code[head.start() : end]):
            yield place + 1, end - 1


class Body:
    """The tokens of a function's body."""

    def __init__(self, code, start, end):
        """Leaves out messages and constants."""
        blanks = [(m.start(), closing(code, m.end())) for m in MESSAGES.finditer(code, start, end)]
        blanks += [m.span() for m in CHOSEN_TEXT.finditer(code, start, end)]
        blanks += [
            m.span() for m in re.compile(r"\b(?:const|static) [^;]*;").finditer(code, start, end)
        ]
        self.code = blanked(code, blanks)
        self.tokens = [
            (m[0], *m.span(), m.lastgroup) for m in TOKEN.finditer(self.code, start, end)
        ]
        self.partner = {}
        opened = []
        for k, (mark, *_) in enumerate(self.tokens):
            if mark in OPEN:
                opened.append(k)
            elif mark in CLOSE and opened:
                self.partner[k] = opened.pop()
                self.partner[self.partner[k]] = k

    def at(self, k):
        """Text of a token; none beyond the body."""
        return self.tokens[k][0] if 0 <= k < len(self.tokens) else ""

    def spaced(self, k):
        """Whether blanks are around a token: it is a binary operator, then."""
        _, start, end, _ = self.tokens[k]
        return self.code[start - 1].isspace() and self.code[end].isspace()

    def binds(self, k):
        """How tightly a binary operator binds; none where the token is no such."""
        mark = self.at(k)
        if mark in ("..", "..="):
            return TIGHT[mark]
        operator = (
            mark in TIGHT and self.spaced(k) and self.at(k - 1) not in {",", "(", "=", "{", ";"}
        )
        return TIGHT[mark] if operator else None

    def is_bound(self, k, tight):
        """Whether an expression of operators that bind so tightly ends at a token."""
        mark, binds = self.at(k), self.binds(k)
        closes_parameters = mark == "|" and not self.spaced(k)
        return mark in BOUNDS or closes_parameters or (binds is not None and binds < tight)

    def left(self, k, tight):
        """First token of the expression that token `k` is in."""
        while k > 0:
            mark = self.at(k - 1)
            if mark in (")", "]") and k - 1 in self.partner:
                k = self.partner[k - 1]
            elif mark in OPEN or self.is_bound(k - 1, tight):
                break
            else:
                k -= 1
        return k

    def right(self, k, tight):
        """Last token of it."""
        while k + 1 < len(self.tokens):
            mark = self.at(k + 1)
            if mark in ("(", "[") and k + 1 in self.partner:
                k = self.partner[k + 1]
            elif mark in CLOSE or self.is_bound(k + 1, tight):
                break
            else:
                k += 1
        return k

    def span(self, first, last):
        """Place of a run of tokens."""
        return self.tokens[first][1], self.tokens[last][2]

    def around(self, k, tight):
        """Place of the expression around token `k`."""
        return self.span(self.left(k, tight), self.right(k, tight))

    def in_pattern(self, k):
        """Whether a token is in an arm's pattern, or between `let` and `=`."""
        comma, place = False, k - 1
        while place >= 0 and self.at(place) not in {"{", ";", "=>", "if", "=", "let"}:
            if self.at(place) in CLOSE and place in self.partner:
                place = self.partner[place]
            elif self.at(place) in OPEN:
                comma = False
            comma |= self.at(place) == ","
            place -= 1
        before = self.at(place)
        if before in {"if", "="} or (before == "=>" and not comma):
            return False
        if before == "let":
            return True
        while k < len(self.tokens) and self.at(k) not in {"=>", "{", ";", "}"}:
            k += 1
        return self.at(k) == "=>"


def operator_changes(body, k, text):
    """Change a binary operator to the other one; of a sum, drop the term behind it or the first."""
    mark, start, end, _ = body.tokens[k]
    tight = TIGHT.get(mark, RANGE)
    whole = body.around(k, tight)
    if whole[0] >= start or whole[1] <= end:
        return []
    new = text[whole[0] : start] + OTHER[mark] + text[end : whole[1]]
    changes = [(f"`{mark}` → `{OTHER[mark]}`", whole, new)]
    if tight == SUM:
        behind = body.span(k, body.right(k, SUM + 1))
        dropped = text[whole[0] : behind[0]].rstrip() + text[behind[1] : whole[1]]
        changes.append((f"without `{flat(text[slice(*behind)])}`", whole, dropped))
        if body.left(k, SUM) == body.left(k, SUM + 1):
            rest = text[start : whole[1]].removeprefix("+")
            changes.append((f"without `{flat(text[whole[0] : start])}`", whole, rest))
    return changes


def number_changes(body, k):
    """Scale a number; an integer becomes the next one."""
    mark, start, end, _ = body.tokens[k]
    last = k
    while body.at(last) == "," or (
        last < len(body.tokens) and body.tokens[last][3] in ("word", "number")
    ):
        last += 1
    is_type = body.at(last) == ">" and not body.spaced(last)
    is_length = body.at(k - 1) == ";" and body.at(k + 1) == "]"
    if body.at(k - 1) == "." or is_type or is_length or body.in_pattern(k):
        return []
    number = re.sub(r"_?[iuf](?:8|16|32|64|128|size)$", "", mark)
    kind = mark[len(number) :]
    if "." in number or "e" in number.lower() or kind.startswith("f"):
        return (
            [(f"`{mark}` → `{mark} * 1.1`", (start, end), f"({mark} * 1.1)")]
            if float(number)
            else []
        )
    value = int(number)
    others = [value + 1, value - 1] if value else [value + 1]
    return [(f"`{mark}` → `{other}`", (start, end), f"{other}{kind}") for other in others]


def condition_changes(body, k, text):
    """Negate a condition; take an `if` always or never."""
    last = k
    while last + 1 < len(body.tokens) and body.at(last + 1) not in ("{", "=>", ";"):
        last = body.partner.get(last + 1, last + 1) if body.at(last + 1) in OPEN else last + 1
    if last == k or any(body.at(place) == "let" for place in range(k, last + 1)):
        return []
    place = body.span(k + 1, last)
    old = flat(text[slice(*place)])
    changes = [(f"`{body.at(k)} {old}` negated", place, f"!({text[slice(*place)]})")]
    if body.at(k) == "if":
        changes += [(f"`if {old}` always", place, "true"), (f"`if {old}` never", place, "false")]
    return changes


def range_changes(body, k, text):
    """Exclude the end of a range, or include it."""
    mark, start, end, _ = body.tokens[k]
    tokens_touch = (
        body.tokens[k - 1][2] == start and end == body.tokens[min(k + 1, len(body.tokens) - 1)][1]
    )
    if (
        not k
        or not tokens_touch
        or body.at(k + 1) in CLOSE
        or body.at(k - 1) in OPEN
        or body.in_pattern(k)
    ):
        return []
    other = ".." if mark == "..=" else "..="
    what = f"`{flat(text[slice(*body.around(k, RANGE))])}` → `{other}`"
    last = body.right(k, RANGE)
    if body.at(last + 1) == ")" and body.at(last + 3) == "contains":
        whole = body.around(last + 1, OPERAND)
        return [(what, whole, text[whole[0] : start] + other + text[end : whole[1]])]
    place = body.span(k + 1, last)
    return [(what, place, f"({text[slice(*place)]}) {'-' if mark == '..=' else '+'} 1")]


def index_changes(body, k, text):
    """Take the element behind, or before."""
    if body.tokens[k][1] != body.tokens[k - 1][2] or not (
        body.tokens[k - 1][3] == "word" or body.at(k - 1) in (")", "]")
    ):
        return []
    last = body.partner.get(k, k + 1) - 1
    inside = [body.at(place) for place in range(k + 1, last + 1)]
    if (
        not inside
        or inside[0] in ("(", "&")
        or {"..", "..=", ",", ";"} & set(inside)
        or body.in_pattern(k)
    ):
        return []
    place = body.span(k + 1, last)
    old = text[slice(*place)]
    signs = "+" if old == "0" else "+-"
    return [
        (f"`[{flat(old)}]` → `[{flat(old)} {sign} 1]`", place, f"({old}) {sign} 1")
        for sign in signs
    ]


def call_changes(body, k, text):
    """Take the least for the greatest, or drop an absolute value."""
    mark, start, end, _ = body.tokens[k]
    if mark in ("min", "max") and body.at(k - 1) in (".", "::"):
        whole = body.around(k, OPERAND)
        other = "max" if mark == "min" else "min"
        return [
            (f"`{mark}` → `{other}`", whole, text[whole[0] : start] + other + text[end : whole[1]])
        ]
    if mark == "abs" and body.at(k - 1) == "." and body.at(k + 1) == "(":
        whole = body.around(k, OPERAND)
        dot, behind = body.tokens[k - 1][1], body.tokens[body.partner[k + 1]][2]
        return [("without `.abs()`", whole, text[whole[0] : dot] + text[behind : whole[1]])]
    return []


def flat(code):
    """Code on one line."""
    return re.sub(r"\s+", " ", code).strip()


def changes_at(body, k, text):
    """List the changes of a token."""
    mark, _, _, kind = body.tokens[k]
    if kind == "number":
        return number_changes(body, k)
    if mark in ("if", "while"):
        return condition_changes(body, k, text)
    if mark in ("..", "..="):
        return range_changes(body, k, text)
    if mark == "[":
        return index_changes(body, k, text)
    if mark in ("min", "max", "abs"):
        return call_changes(body, k, text)
    is_operator = mark in OTHER and (
        (mark.endswith("=") and body.spaced(k)) or body.binds(k) is not None
    )
    return operator_changes(body, k, text) if is_operator else []


def sites(text, word=""):
    """List the sites of a source in the bodies of functions that hold a word."""
    code = code_only(text)
    lines = [m.start() for m in re.finditer("\n", text)]
    for start, end in bodies(code, word):
        body = Body(code, start, end)
        for k in range(len(body.tokens)):
            if changes := changes_at(body, k, text):
                yield Site(bisect.bisect(lines, body.tokens[k][1]) + 1, changes)
