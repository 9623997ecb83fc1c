"""Prints the crates that differ from the last commit, and their dependents, as cargo's options.

A crate differs where a file of its folder does, or one elsewhere whose path its sources have as a
text, such as a built-in study. What all are built with changes all of them. Untracked files count.
"""

import json
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent

# What all crates are built with, and the folders of the root package
ALL = {"Cargo.toml", "Cargo.lock", "clippy.toml", "rust-toolchain.toml", ".cargo/config.toml"}
OF_ROOT = ("src", "tests", "examples", "benches")


def said(*command: str) -> str:
    """Run a command and return its output."""
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


def paths_in(folders: list[pathlib.Path]) -> set[str]:
    """Return the texts in Rust sources that are paths, seen from the root."""
    texts = (file.read_text() for folder in folders for file in folder.rglob("*.rs"))
    found = (re.findall(r'"((?:\.\./|/)*[\w-]+(?:/[\w.-]+)*)"', text) for text in texts)
    return {path.lstrip("./") for paths in found for path in paths if "/" in path}


def main() -> None:
    """Print `-p NAME` for each crate, or `--workspace`."""
    status = said("git", "status", "--porcelain", "-z", "--no-renames", "--untracked-files=all")
    changed = {entry[3:] for entry in status.split("\0") if entry}
    metadata = said("cargo", "metadata", "--no-deps", "--offline", "--format-version=1")
    packages = json.loads(metadata)["packages"]
    touched = set()
    for package in packages:
        folder = pathlib.Path(package["manifest_path"]).parent
        folders = [folder] if folder != ROOT else [ROOT / name for name in OF_ROOT]
        own = {folder.relative_to(ROOT).as_posix() for folder in folders} | paths_in(folders)
        for file in map(pathlib.PurePosixPath, changed):
            if own.intersection(path.as_posix() for path in [file, *file.parents]):
                touched.add(package["name"])
    above = None
    while above != touched:
        above = set(touched)
        for package in packages:
            if any("path" in used and used["name"] in above for used in package["dependencies"]):
                touched.add(package["name"])
    names = [package["name"] for package in packages if package["name"] in touched]
    print("--workspace" if changed & ALL else " ".join(f"-p {name}" for name in names))


if __name__ == "__main__":
    main()
