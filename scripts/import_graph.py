"""Draws which rooms of each crate import which, and refuses circles.

A room is a file or a folder directly below a crate's `src`. Printed is one line for each room with
the rooms that it imports, and one for each crate. Unit tests (`#[cfg(test)] mod ...`) and comments
do not count. Exits with 1 where rooms import each other in a circle, where a stage of the core
imports a later one, where a crate depends on a later one, or where files of the kernel import each
other in a circle that leaves a room or has more than six files.
"""

import itertools
import pathlib
import re
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent

# From the bottom up; a crate may depend on those before it.
CRATES = [
    "ocmc-core",
    "ocmc-fleet",
    "ocmc-estimation",
    "ocmc-io",
    "ocmc-vecto",
    "ocmc-api",
    "ocmc-page",
    "ocmc-cli",
    "ocmc-py",
    "ocmc-tab",
]

# Stages of the core from the bottom up; a room that is not listed has to be free of circles only.
STAGES = [
    "switch",
    "lanes",
    "validation",
    "special_functions",
    "energy",
    "record",
    "random",
    "distribution",
    "operating_cycle",
    "driver",
    "first_order_lag",
    "powertrain",
    "vehicle",
    "cost",
    "study",
    "tactical",
    "kernel",
    "prescribed",
]

# Rooms of the kernel from the bottom up.
KERNEL_ROOMS = ["step", "trip", "drive"]

# Files of the kernel that may import each other in a circle.
LARGEST_CIRCLE = 6

UNIT_TESTS = re.compile(r"#\[cfg\(test\)\]\s*(?:#\[[^\]]*\]\s*)*mod \w+ *\{")
COMMENT = re.compile(r"//.*")
TEXT = re.compile(r'"(?:\\.|[^"\\])*"', re.DOTALL)
GROUP = re.compile(r"\bcrate::\{(.*?)\};", re.DOTALL)
PATH = re.compile(r"\bcrate::(\w+)")

Graph = dict[str, dict[str, pathlib.Path]]


def code(text: str) -> str:
    """Take the text without unit tests, comments and strings."""
    text = UNIT_TESTS.split(text)[0]
    return COMMENT.sub("", TEXT.sub('""', text))


def members(group: str) -> list[str]:
    """First names of the comma-separated members of a `use` group, nested groups left out."""
    depth, names, member = 0, [], ""
    for letter in group + ",":
        depth += (letter == "{") - (letter == "}")
        if letter == "," and depth == 0:
            names.append(member.strip().partition("::")[0])
            member = ""
        else:
            member += letter
    return names


def rooms(source: pathlib.Path) -> Graph:
    """Find the imports between rooms, each with one file that has it."""
    names = {path.stem for path in source.iterdir() if path.is_dir() or path.suffix == ".rs"}
    names -= {"lib", "main"}
    graph: Graph = {name: {} for name in sorted(names)}
    for path in sorted(source.rglob("*.rs")):
        room = pathlib.Path(path.relative_to(source).parts[0]).stem
        if room not in names:
            continue
        text = code(path.read_text(encoding="utf-8"))
        imported = PATH.findall(text)
        for group in GROUP.findall(text):
            imported += members(group)
        if len(path.relative_to(source).parts) == 1:
            imported += re.findall(r"^use super::(\w+)", text, re.MULTILINE)
        for name in imported:
            if name in names and name != room:
                graph[room].setdefault(name, path)
    return graph


def crates() -> Graph:
    """Find the dependencies between crates of the workspace, tests left out."""
    manifests = sorted(ROOT.glob("crates/*/Cargo.toml"))
    graph: Graph = {manifest.parent.name: {} for manifest in manifests}
    for manifest in manifests:
        for name in tomllib.loads(manifest.read_text(encoding="utf-8")).get("dependencies", {}):
            if name in graph:
                graph[manifest.parent.name][name] = manifest
    return graph


def circle(graph: Graph) -> list[str]:
    """Find a circle of the graph, its first name repeated at the end; empty where there is none."""
    done: set[str] = set()

    def visit(name: str, path: list[str]) -> list[str]:
        if name in path:
            return [*path[path.index(name) :], name]
        if name in done:
            return []
        for other in sorted(graph[name]):
            found = visit(other, [*path, name])
            if found:
                return found
        done.add(name)
        return []

    for name in graph:
        found = visit(name, [])
        if found:
            return found
    return []


def kernel_files(kernel: pathlib.Path) -> Graph:
    """Find the imports between the kernel's files, by `room/file`; `mod` has the re-exports."""
    files = {str(path.relative_to(kernel).with_suffix("")): path for path in kernel.rglob("*.rs")}
    graph: Graph = {name: {} for name in sorted(files)}
    for name, path in files.items():
        text = code(path.read_text(encoding="utf-8"))
        room = name.partition("/")[0]
        imported = [
            f"{room}/{found}" for found in re.findall(r"^use super::(\w+)", text, re.MULTILINE)
        ]
        for other, found in re.findall(r"\bcrate::kernel::(\w+)::(\w+)", text):
            imported.append(f"{other}/{found}" if f"{other}/{found}" in files else f"{other}/mod")
        for other in imported:
            if other in files and other != name:
                graph[name].setdefault(other, path)
    return graph


def rooms_between(files: Graph) -> Graph:
    """Find the imports between rooms of the kernel, from its files."""
    graph: Graph = {}
    for name, imported in files.items():
        room = graph.setdefault(name.partition("/")[0], {})
        for other, path in imported.items():
            room.setdefault(other.partition("/")[0], path)
    return graph


def reached(graph: Graph, start: str) -> set[str]:
    """All names that a name imports, and those that these import."""
    found, left = set(), [start]
    while left:
        new = set(graph[left.pop()]) - found
        found |= new
        left += new
    return found


def large_circles(graph: Graph) -> list[str]:
    """Circles of files that leave a room or have more than six files."""
    behind = {name: reached(graph, name) for name in graph}
    circles = {
        tuple(sorted(b for b in behind[a] if a in behind[b])) for a in graph if a in behind[a]
    }
    return [
        f"circle of files: {', '.join(files)}"
        for files in sorted(circles)
        if len(files) > LARGEST_CIRCLE or len({name.partition("/")[0] for name in files}) > 1
    ]


def upward(graph: Graph, order: list[str]) -> list[str]:
    """Arrows from an earlier to a later name of the order."""
    return [
        f"{name} imports {other} ({path.relative_to(ROOT)})"
        for name in order
        for other, path in sorted(graph.get(name, {}).items())
        if other in order and order.index(other) > order.index(name)
    ]


def draw(title: str, graph: Graph) -> None:
    """Print a graph as text, the names in the order from the bottom up."""
    print(f"\n{title}")
    height: dict[str, int] = {}

    def of(name: str, path: tuple[str, ...] = ()) -> int:
        if name not in height and name not in path:
            below = [of(other, (*path, name)) for other in graph[name]]
            height[name] = 1 + max(below, default=-1)
        return height.get(name, 0)

    width = max(map(len, graph), default=0)
    for name in sorted(graph, key=lambda name: (of(name), name)):
        arrows = ", ".join(sorted(graph[name], key=lambda other: (of(other), other)))
        print(f"  {name:{width}}  {'<- ' + arrows if arrows else ''}".rstrip())


def main() -> int:
    """Draws all graphs and says what is wrong with them."""
    faults = []
    graph = crates()
    draw("crates", graph)
    faults += [f"crate {fault}" for fault in upward(graph, CRATES)]
    faults += [f"crate {name} has no place in the order" for name in graph if name not in CRATES]
    for source in sorted(ROOT.glob("crates/*/src")):
        name, graph = source.parent.name, rooms(source)
        draw(f"rooms of {name}", graph)
        # all circles: one arrow of each that is found is taken away before the next one is looked
        # for
        left = {room: dict(arrows) for room, arrows in graph.items()}
        while found := circle(left):
            files = [str(graph[a][b].relative_to(ROOT)) for a, b in itertools.pairwise(found)]
            faults.append(f"{name}: circle {' -> '.join(found)} ({', '.join(files)})")
            del left[found[-2]][found[-1]]
        if name == "ocmc-core":
            faults += [f"{name}: stage {fault}" for fault in upward(graph, STAGES)]
            kernel = kernel_files(source / "kernel")
            draw("files of the kernel", kernel)
            faults += [f"{name}: {fault}" for fault in large_circles(kernel)]
            rooms_of_kernel = rooms_between(kernel)
            faults += [f"kernel: {fault}" for fault in upward(rooms_of_kernel, KERNEL_ROOMS)]
    for fault in faults:
        print(fault, file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
