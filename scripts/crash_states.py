#!/usr/bin/env python3
"""Crash states of run directories: what a kill or a power cut can leave, and how it is resumed.

    scripts/crash_states.py OCMC [--kind NAME ...] [--samples 300] [--seed 1] [--quick]

Records with `strace` the system calls by which runs change their directory, with all bytes, and
replays them on a model of a file system, which has to end with the files that the run has left. Of
the calls it makes states of the directory, as ALICE (Pillai et al., OSDI 2014) and CrashMonkey
(Mohan et al., OSDI 2018) do:

- prefixes: what a kill leaves after each call;
- torn: the same, with half of the bytes of the last write;
- samples: what a power cut can leave of a prefix.

The file system of the samples is weaker than ext4 with `data=ordered`. A write is on the disk for
certain once an fsync of its file has returned, and a new, renamed or removed name once an fsync of
its directory has. Each other call before the cut may be lost alone, so that later ones are there
without earlier ones. Of the other bytes of a file either all are there, or none, or some from the
beginning on, or the file has its length and zeros in some of its blocks of 512 bytes. A rename
within a file system is there as a whole or not at all.

On each state `ocmc verify`, `ocmc report` and, where the module is there, `ocmc.load` are asked,
and then the run's own command with `--resume`. Before that, right is:

- the answer of a command that had ended, byte for byte;
- that the run is not complete;
- a refusal that names a file.

A fault of a file that `--resume` does without is a false alarm, and counts as wrong. `--resume`
has to end with the files of the undisturbed run, byte for byte, or to refuse and name the file.
Other than those are in `summary.json` `wall_s` and `ended_at`, and with them its checksum. What
the manifest had counted on the disk when the power was cut has to be there: else it is wrong, too.
"""

import argparse
import collections
import dataclasses
import hashlib
import importlib
import importlib.util
import json
import pathlib
import pickle
import random
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from typing import Any

MODULE = "ocmc"
ocmc: Any = importlib.import_module(MODULE) if importlib.util.find_spec(MODULE) else None

BLOCK = 512
SHORT = ["--set", "mission.length_m=200", "--threads", "1", "--quiet"]
PARQUET, CSV = ["--format", "parquet"], ["--format", "csv"]
# three chunks each; `interrupted` is stopped by SIGTERM, reported, resumed and reported again
KINDS = {
    "parquet": ["--cycles", "2100", *PARQUET],
    "csv": ["--cycles", "2100", *CSV],
    "charging": ["--study", "electric-regional", "--cycles", "2100", *PARQUET],
    "trucks": ["--study", "electric-regional", "--trucks", "3", "--trips", "700", *PARQUET],
    "interrupted": ["--cycles", "3000", "--chunk", "64", *CSV],
}
TRACED = (
    "open,openat,openat2,creat,write,pwrite64,writev,pwritev,pwritev2,rename,renameat,renameat2,"
    "fsync,fdatasync,sync,syncfs,sync_file_range,ftruncate,truncate,fallocate,mkdir,mkdirat,unlink,"
    "unlinkat,rmdir,link,linkat,symlink,symlinkat,mknod,mknodat,copy_file_range,sendfile,splice,"
    "io_uring_enter,mmap"
)
# what they do; all others that are traced are not in the model, unless they are those of a
# descriptor
NAMING = {
    "open": "open",
    "openat": "open",
    "mkdir": "mkdir",
    "mkdirat": "mkdir",
    "rename": "rename",
    "renameat": "rename",
    "renameat2": "rename",
    "unlink": "remove",
    "unlinkat": "remove",
    "rmdir": "remove",
}
# what differs between runs of the same bytes
MEASURED = re.compile(rb'^ *"(wall_s|ended_at)": .*\n', re.MULTILINE)
CHUNK_ROWS = 1024

Tree = dict[str, bytes | None]
Judged = tuple[str, list[str]]


@dataclasses.dataclass
class Call:
    """One change of the directory, or one fsync, between two places in the order of all calls."""

    kind: str
    begin: int
    end: int
    inode: int
    # directory and name where it is taken away, and where it is put
    source: tuple[int, str] | None = None
    target: tuple[int, str] | None = None
    offset: int = 0
    content: bytes = b""

    def directories(self) -> set[int]:
        """Directories whose names it changes."""
        return {place[0] for place in (self.source, self.target) if place}


class FileSystem:
    """Inodes: directories by name, and the bytes of files."""

    def __init__(self) -> None:
        self.directories: dict[int, dict[str, int]] = {0: {}}
        self.files: dict[int, bytearray] = {}

    def apply(self, call: Call) -> None:
        """One change more, of which those before may be missing."""
        if call.kind == "truncate":
            file = self.files.setdefault(call.inode, bytearray())
            del file[call.offset :]
        elif call.kind == "write":
            file = self.files.setdefault(call.inode, bytearray())
            end = call.offset + len(call.content)
            file.extend(bytes(max(0, end - len(file))))
            file[call.offset : end] = call.content
        if call.source:
            directory, name = call.source
            names = self.directories.setdefault(directory, {})
            if names.get(name) == call.inode:
                del names[name]
        if call.target:
            directory, name = call.target
            self.directories.setdefault(directory, {})[name] = call.inode
            if call.kind == "mkdir":
                self.directories.setdefault(call.inode, {})
            elif call.kind == "create":
                self.files.setdefault(call.inode, bytearray())

    def tree(self, name: str) -> Tree:
        """Files and directories from that name of the root on; none where it is not there."""
        tree: Tree = {}

        def walk(inode: int, path: str) -> None:
            if inode in self.directories:
                tree[path] = None
                for own, below in self.directories[inode].items():
                    walk(below, f"{path}/{own}")
            else:
                tree[path] = bytes(self.files.get(inode, b""))

        if name in self.directories[0]:
            walk(self.directories[0][name], ".")
        return tree


class Recorder:
    """Reads what `strace` has written, and keeps what changes names below a root."""

    LINE = re.compile(r"^(\d+) +(?:<\.\.\. (\w+) resumed>(.*)|(\w+)\((.*))$")
    DONE = re.compile(r"^(.*)\) += (-?\d+|0x[0-9a-f]+|\?).*$")
    STRING = re.compile(r'"((?:\\x[0-9a-f]{2})*)"')
    DESCRIPTOR = re.compile(r"\b(?:\d+|AT_FDCWD)<([^>]*)>")

    def __init__(self, root: pathlib.Path) -> None:
        self.root = root
        self.calls: list[Call] = []
        self.now = FileSystem()
        self.inodes = 0
        self.place = 0

    def read(self, path: pathlib.Path) -> None:
        """All calls of one command, as `strace` has written them."""
        begun: dict[str, tuple[int, str]] = {}
        with path.open(encoding="ascii") as lines:
            for line in lines:
                self.place += 1
                found = self.LINE.match(line.rstrip("\n"))
                if not found:
                    continue
                thread, resumed, rest, name, arguments = found.groups()
                begin = self.place
                if resumed:
                    begin, head = begun.pop(thread)
                    name, arguments = resumed, head + rest
                if arguments.endswith("<unfinished ...>"):
                    begun[thread] = begin, arguments.removesuffix("<unfinished ...>")
                    continue
                done = self.DONE.match(arguments)
                if done and not done[2].startswith(("-", "?")):
                    self.take(name, done[1], int(done[2], 0), begin)

    def take(self, name: str, arguments: str, result: int, begin: int) -> None:
        """One call that succeeded, which is kept if it is about the directory."""
        strings = [
            bytes.fromhex(text.replace("\\x", "")) for text in self.STRING.findall(arguments)
        ]
        bases = [pathlib.Path(unescaped(text)) for text in self.DESCRIPTOR.findall(arguments)]
        base = bases[0] if bases else pathlib.Path("/")
        if name in NAMING:
            self.take_names(
                NAMING[name], arguments, [self.resolve(base / s.decode()) for s in strings], begin
            )
        elif self.root in {path for base in bases for path in (base, *base.parents)}:
            inode = self.there(self.resolve(base)) if base != self.root else 0
            if name in ("fsync", "fdatasync"):
                self.add(Call("fsync", begin, self.place, inode))
            elif name == "write":
                offset = len(self.now.files[inode])
                self.add(
                    Call(
                        "write",
                        begin,
                        self.place,
                        inode,
                        offset=offset,
                        content=strings[0][:result],
                    )
                )
            elif name != "mmap" or {"MAP_SHARED", "PROT_WRITE"} <= set(
                re.split(r"[|, ]+", arguments)
            ):
                raise SystemExit(f"`{name}` of `{base}` is not in the model")

    def take_names(
        self, kind: str, arguments: str, places: list[tuple[int, str] | None], begin: int
    ) -> None:
        """One call that names files; none of them need be in the directory."""
        place = places[0]
        if kind == "rename":
            source, target = places
            if source and target:
                self.add(Call(kind, begin, self.place, self.there(source), source, target))
            elif source or target:
                raise SystemExit(f"a rename from or to elsewhere: {arguments}")
        elif place and kind == "mkdir":
            self.add(Call(kind, begin, self.place, self.new(), target=place))
        elif place and kind == "remove":
            self.add(Call(kind, begin, self.place, self.there(place), source=place))
        elif place and ("O_WRONLY" in arguments or "O_RDWR" in arguments):
            inode = self.inode(place)
            if inode is None:
                self.add(Call("create", begin, self.place, self.new(), target=place))
            elif "O_TRUNC" in arguments and self.now.files[inode]:
                self.add(Call("truncate", begin, self.place, inode))

    def resolve(self, path: pathlib.Path) -> tuple[int, str] | None:
        """Directory and name of a path below the root."""
        if self.root not in path.parents:
            return None
        directory = 0
        *parts, name = path.relative_to(self.root).parts
        for part in parts:
            directory = self.now.directories[directory][part]
        return directory, name

    def inode(self, place: tuple[int, str]) -> int | None:
        """Inode of a name."""
        return self.now.directories[place[0]].get(place[1])

    def there(self, place: tuple[int, str] | None) -> int:
        """Inode that has to be there."""
        inode = self.inode(place) if place else None
        if inode is None:
            raise SystemExit(f"`{place}` is used, and was never made")
        return inode

    def new(self) -> int:
        """Inode that is new."""
        self.inodes += 1
        return self.inodes

    def add(self, call: Call) -> None:
        """One call more."""
        self.calls.append(call)
        self.now.apply(call)


def unescaped(text: str) -> str:
    """Text as `strace -xx` writes it in brackets."""
    return re.sub(r"\\x([0-9a-f]{2})", lambda found: chr(int(found[1], 16)), text)


def files_of(folder: pathlib.Path) -> Tree:
    """Files and directories on the disk."""
    if not folder.exists():
        return {}
    below = {f"./{path.relative_to(folder)}": path for path in folder.rglob("*")}
    return {".": None} | {
        name: None if path.is_dir() else path.read_bytes() for name, path in below.items()
    }


def write(tree: Tree, folder: pathlib.Path) -> None:
    """Files and directories of a state, on the disk."""
    shutil.rmtree(folder, ignore_errors=True)
    for name, content in tree.items():
        if content is None:
            (folder / name).mkdir()
        else:
            (folder / name).write_bytes(content)


def digest(tree: Tree, *, is_quick: bool) -> bytes:
    """Sum of all files; a quick one leaves out the bytes of files beside their places."""
    whole = hashlib.sha256()
    for name, content in sorted(tree.items()):
        is_beside = is_quick and name.endswith(".tmp")
        sum_ = b"" if content is None or is_beside else hashlib.sha256(content).digest()
        whole.update(name.encode() + b"\0" + sum_)
    return whole.digest()


def same_run(tree: Tree) -> Tree:
    """Files of a run without its report and what differs between runs of the same bytes."""
    tree = {name: content for name, content in tree.items() if not name.startswith("./report.html")}
    if summary := tree.get("./summary.json"):
        tree["./summary.json"] = MEASURED.sub(b"", summary)
    if sums := tree.get("./checksums.sha256"):
        lines = sums.splitlines()
        kept = [line for line in lines if not line.endswith((b"summary.json", b"report.html"))]
        tree["./checksums.sha256"] = b"\n".join(kept)
    return tree


def manifest_of(tree: Tree) -> tuple[str, int]:
    """Status and completed cycles; nothing where there is no manifest."""
    try:
        manifest = json.loads(tree["./manifest.json"] or b"")
    except (KeyError, ValueError):
        return "none", 0
    return manifest["status"], manifest["completed"]


@dataclasses.dataclass
class State:
    """Files that a crash leaves, and those that had to be left."""

    how: str
    tree: Tree
    counted: int
    complete: bool


class Crashes:
    """The crash states of recorded calls."""

    def __init__(self, calls: list[Call], name: str) -> None:
        self.calls, self.name = calls, name
        # what the manifest says after each fsync of the directory: from then on it is not to be
        # lost
        self.promised: list[tuple[int, bool]] = [(0, False)]
        system = FileSystem()
        for call in calls:
            system.apply(call)
            promised = self.promised[-1]
            if call.kind == "fsync" and call.inode == system.directories[0].get(name):
                status, completed = manifest_of(system.tree(name))
                promised = max(promised[0], completed), status == "complete"
            self.promised.append(promised)

    def prefixes(self) -> Iterator[State]:
        """States that a kill leaves after each call, and in the middle of each write."""
        system = FileSystem()
        for k, call in enumerate(self.calls):
            yield State("prefix", system.tree(self.name), *self.promised[k])
            if call.kind == "write" and len(call.content) > 1:
                half = dataclasses.replace(call, content=call.content[: len(call.content) // 2])
                whole = system.files[call.inode]
                system.files[call.inode] = bytearray(whole)
                system.apply(half)
                yield State("torn", system.tree(self.name), *self.promised[k])
                system.files[call.inode] = whole
            system.apply(call)
        yield State("prefix", system.tree(self.name), *self.promised[-1])

    def samples(self, count: int, draw: random.Random) -> Iterator[State]:
        """States that a power cut leaves, at random."""
        # most calls are writes of chunks: half of the cuts are where names or barriers are
        marks = [k for k, call in enumerate(self.calls) if call.kind != "write"]
        for _ in range(count):
            is_anywhere = draw.random() < 0.5  # noqa: PLR2004
            k = draw.randrange(len(self.calls) + 1) if is_anywhere else draw.choice(marks) + 1
            kept = draw.choice((0.0, 0.5, 0.5, 0.9, 1.0))

            def names(calls: list[Call], kept: float = kept) -> list[Call]:
                return [call for call in calls if draw.random() < kept]

            def content(_inode: int, calls: list[Call]) -> list[Call]:
                return damaged(calls, draw)

            yield State("sample", self.cut(k, names, content), *self.promised[k])

    def cut(
        self,
        k: int,
        names: Callable[[list[Call]], list[Call]],
        content: Callable[[int, list[Call]], list[Call]],
    ) -> Tree:
        """Files after `k` calls; `names` and `content` say what is left of unsynced ones."""
        calls = self.calls[:k]
        now = calls[-1].end if calls else 0
        synced = {
            call.inode: call.begin for call in calls if call.kind == "fsync" and call.end <= now
        }
        changed: list[Call] = []
        open_writes = collections.defaultdict(list)
        open_names = []
        for call in calls:
            touched = call.directories() or {call.inode}
            if call.kind == "fsync":
                continue
            if all(synced.get(inode, -1) > call.end for inode in touched):
                changed.append(call)
            elif call.directories():
                open_names.append(call)
            else:
                open_writes[call.inode].append(call)
        changed += names(open_names)
        for inode, writes in open_writes.items():
            changed += content(inode, writes)
        system = FileSystem()
        for call in sorted(changed, key=lambda call: call.end):
            system.apply(call)
        return system.tree(self.name)


def damaged(calls: list[Call], draw: random.Random) -> list[Call]:
    """Rest of the writes to a file that are not synced."""
    how = draw.choice(("whole", "lost", "cut", "zeros"))
    if how == "whole":
        return calls
    if how == "lost":
        return []
    if how == "cut":
        left = draw.randrange(sum(len(call.content) for call in calls) + 1)
        kept = []
        for call in calls:
            kept.append(dataclasses.replace(call, content=call.content[:left]))
            left = max(0, left - len(call.content))
        return kept
    share = draw.choice((0.3, 1.0))
    begin = min(call.offset for call in calls) // BLOCK
    end = max(call.offset + len(call.content) for call in calls) // BLOCK + 1
    zeros = {block for block in range(begin, end) if draw.random() < share}

    def zeroed(call: Call) -> Call:
        content = bytearray(call.content)
        for block in range(call.offset // BLOCK, (call.offset + len(content)) // BLOCK + 1):
            if block in zeros:
                first = max(0, block * BLOCK - call.offset)
                last = min(len(content), (block + 1) * BLOCK - call.offset)
                content[first:last] = bytes(last - first)
        return dataclasses.replace(call, content=bytes(content))

    return [zeroed(call) for call in calls]


class Asked:
    """The program and the module, asked about one directory."""

    def __init__(self, program: str, arguments: list[str], folder: pathlib.Path) -> None:
        self.program, self.arguments, self.folder = program, arguments, folder

    def command(self, *arguments: str) -> tuple[int, str, str]:
        """Status, answer and messages of a command."""
        done = subprocess.run(
            [self.program, *arguments], capture_output=True, check=False, timeout=120
        )
        return done.returncode, done.stdout.decode(), done.stderr.decode()

    def verify(self) -> tuple[int, str, str]:
        """State of each file."""
        return self.command("verify", str(self.folder))

    def report(self) -> tuple[int, str, str]:
        """Sum of the page."""
        status, _, said = self.command("report", "--quiet", str(self.folder))
        page = self.folder / "report.html"
        return status, hashlib.sha256(page.read_bytes()).hexdigest() if status == 0 else "", said

    def load(self) -> tuple[int, str, str]:
        """Sum of all that is loaded in Python."""
        try:
            run = ocmc.load(self.folder)
        except (OSError, ValueError, RuntimeError) as error:
            return 1, "", str(error)
        except BaseException as error:  # noqa: BLE001  a panic is no exception of Python's
            return 101, "", f"panicked: {error!r}"
        return 0, hashlib.sha256(pickle.dumps(run)).hexdigest(), ""

    def resume(self) -> tuple[int, str, str]:
        """End of the run."""
        return self.command(*self.arguments, *SHORT, "--out", str(self.folder), "--resume")


def names_a_file(said: str, folder: pathlib.Path) -> bool:
    """Whether a message names the directory or a file in it."""
    return str(folder) in said and "panicked" not in said


def says_incomplete(text: str) -> bool:
    """Whether an answer says that the run is not complete."""
    return "not complete: " in text


class Judge:
    """Judges each state once."""

    def __init__(self, asked: Asked, ended: list[Tree], *, is_quick: bool) -> None:
        self.asked, self.is_quick = asked, is_quick
        self.whole = same_run(ended[-1])
        self.questions = {"verify": asked.verify, "report": asked.report}
        if ocmc:
            self.questions["load"] = asked.load
        # what the ended commands have left, and what is answered of it
        self.right: dict[str, set[str]] = collections.defaultdict(set)
        for tree in ended:
            for name, question in self.questions.items():
                write(tree, asked.folder)
                status, answer, said = question()
                if status != 0:
                    raise SystemExit(f"`{name}` of an undisturbed run: {said}")
                self.right[name].add(answer)

    def faults(self, tree: Tree) -> Judged:
        """End of `--resume`, and what is wrong with the answers."""
        write(tree, self.asked.folder)
        answers = {name: question() for name, question in self.questions.items()}
        write(tree, self.asked.folder)
        status, _, said = self.asked.resume()
        left = same_run(files_of(self.asked.folder))
        is_complete = manifest_of(tree)[0] == "complete"
        resumed, wrong = "same", []
        if status != 0 or left != self.whole:
            is_refused = status == 1 and names_a_file(said, self.asked.folder) and not is_complete
            resumed = "refused" if is_refused else "wrong"
            differ = [name for name in left | self.whole if left.get(name) != self.whole.get(name)]
            wrong = (
                [] if is_refused else [f"--resume ends with {status}, other are {differ}: {said}"]
            )
        for name, (status, answer, said) in answers.items():
            fault = self.fault(name, status, answer, said, is_complete=is_complete)
            if not fault and status == 1 and resumed == "same":
                fault = "a false alarm" if "damaged " in answer or is_complete else None
            if fault:
                wrong.append(f"{name} ends with {status}, {fault}: {answer} {said}")
        return resumed, wrong

    def fault(
        self, name: str, status: int, answer: str, said: str, *, is_complete: bool
    ) -> str | None:
        """Reason why an answer about a state is wrong."""
        if "panicked" in said or status not in (0, 1):
            return "no answer"
        if status == 1:
            names = names_a_file(said, self.asked.folder) or "\ndamaged " in f"\n{answer}"
            return None if names else "no file is named"
        if name == "verify" and not is_complete:
            return None if says_incomplete(answer) else "taken for a complete run"
        return None if answer in self.right[name] else "another answer"


def record(asked: Asked, name: str, scratch: pathlib.Path) -> tuple[list[Call], list[Tree]]:
    """All calls of the commands of a kind of runs, and what each command has left."""
    recorder, ended = Recorder(asked.folder.parent), []
    begin = [*asked.arguments, *SHORT, "--out", str(asked.folder)]
    report = ["report", "--quiet", str(asked.folder)]
    commands = [begin, report, [*begin, "--resume"], report] if name == "interrupted" else [begin]
    for k, arguments in enumerate(commands):
        traced = scratch / "trace"
        trace = [
            "strace",
            "-f",
            "-y",
            "-xx",
            "-s",
            str(1 << 26),
            "-e",
            f"trace={TRACED}",
            "-o",
            str(traced),
        ]
        is_stopped = name == "interrupted" and k == 0
        if is_stopped:
            # when the first chunk is about to take its place
            trace += ["-e", "inject=rename:signal=TERM:when=3"]
        command = [*trace, asked.program, *arguments]
        run = subprocess.run(command, capture_output=True, check=False)
        if run.returncode != (143 if is_stopped else 0):
            raise SystemExit(f"{arguments} ends with {run.returncode}: {run.stderr.decode()}")
        recorder.read(traced)
        found = recorder.now.tree(asked.folder.name)
        if found != files_of(asked.folder):
            raise SystemExit(f"the recorded calls do not give the files of `{asked.folder}`")
        ended.append(found)
    return recorder.calls, ended


def counted(states: Iterable[State], judge: Judge, seen: dict[bytes, Judged]) -> dict[str, int]:
    """Numbers of states by how they are made and judged."""
    count: dict[str, int] = collections.Counter()
    for k, state in enumerate(states):
        key = digest(state.tree, is_quick=judge.is_quick)
        if key not in seen:
            seen[key] = judge.faults(state.tree)
        resumed, wrong = seen[key]
        status, completed = manifest_of(state.tree)
        lost = completed < state.counted or (state.complete and status != "complete")
        if lost:
            wrong = [
                *wrong,
                f"{state.counted} cycles were counted on the disk, {completed} are there",
            ]
        count[state.how] += 1
        count[resumed] += resumed != "wrong"
        count["wrong"] += bool(wrong)
        for fault in wrong:
            print(f"  {state.how} {k}, {status}: {fault.strip()}", file=sys.stderr)
    return count


def main() -> None:
    """Table of the states of all kinds of runs, and the status 1 where one is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("ocmc", help="the program")
    parser.add_argument(
        "--kind", action="append", choices=KINDS, help="kinds of runs [default: all]"
    )
    parser.add_argument(
        "--samples", type=int, default=300, help="power cuts of a kind [default: %(default)s]"
    )
    parser.add_argument(
        "--seed", type=int, default=1, help="of the power cuts [default: %(default)s]"
    )
    parser.add_argument(
        "--quick", action="store_true", help="states that differ in bytes of *.tmp are one"
    )
    options = parser.parse_args()
    if not shutil.which("strace"):
        print("skipped: no strace here")
        return
    if not ocmc:
        print("`ocmc.load` is skipped: this Python has no module ocmc")
    columns = ("prefix", "torn", "sample", "distinct", "same", "refused", "wrong")
    print(f"| kind | calls | {' | '.join(columns)} |\n|---|{'---:|' * (len(columns) + 1)}")
    is_wrong = False
    for name in options.kind or KINDS:
        with tempfile.TemporaryDirectory() as scratch_name:
            scratch = pathlib.Path(scratch_name).resolve()
            (scratch / "root").mkdir()
            asked = Asked(options.ocmc, KINDS[name], scratch / "root" / "run")
            calls, ended = record(asked, name, scratch)
            judge = Judge(asked, ended, is_quick=options.quick)
            crashes = Crashes(calls, asked.folder.name)
            seen: dict[bytes, Judged] = {}
            draw = random.Random(options.seed)  # noqa: S311
            count = collections.Counter(counted(crashes.prefixes(), judge, seen))
            count.update(counted(crashes.samples(options.samples, draw), judge, seen))
            count["distinct"] = len(seen)
            is_wrong |= count["wrong"] > 0
            print(
                f"| {name} | {len(calls)} | {' | '.join(str(count[c]) for c in columns)} |",
                flush=True,
            )
    if is_wrong:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
