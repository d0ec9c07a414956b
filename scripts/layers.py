#!/usr/bin/env python3
"""Checks the house rules of ARCHITECTURE.md that a compiler does not:

1. Arrows point one way. Of the workspace's own crates the kernel needs none, each crate under io/ and
   plugins/ needs the kernel only, and the program needs what it likes. No crate needs the tests or benches.
   (Dev-dependencies are free: a format's tests may read what another format wrote.)
2. Below app/ nothing asks the world: no clock, no file, no environment, no process, no network, no random
   number and no terminal, neither in the source nor through a dependency made for it.
3. Inside a crate, modules form no circle: what a crate's top holds side by side (`scene`, `plugin`, …) stands on floors, and
   whoever needs another stands above it.
4. A crate's tests are one program (`tests/main.rs`), which names every file beside it: none is left out in silence.

    python3 scripts/layers.py                 checks the repository it is in; exit 0 clean, 1 not, with the places
    python3 scripts/layers.py --self-test     checks that it finds what it looks for
"""
import json
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

# What source below app/ may not name. Each pattern is matched against code only: comments, strings and
# test modules are taken out first.
WORLD = [
    (re.compile(r"\bstd::(fs|env|process|net|os)\b"), "files, environment, processes and the network"),
    (re.compile(r"\bstd::(?:\w+::)*\{[^}]*\b(fs|env|process|net)\b"), "files, environment, processes and the network"),
    (re.compile(r"\bstd::io::(stdin|stdout|stderr)\b"), "the terminal"),
    (re.compile(r"\bstd::thread::(spawn|sleep)\b"), "threads of its own (rayon, behind the feature `parallel`)"),
    (re.compile(r"\b(Instant|SystemTime)\b"), "the clock"),
    (re.compile(r"\b(rand|getrandom|fastrand|oorandom)::"), "random numbers"),
    (re.compile(r"\bRandomState\b"), "random numbers (of a hash map)"),
]

# Crates made for asking the world; no crate below app/ may need one itself.
WORLDLY = {"rand", "getrandom", "fastrand", "chrono", "time", "tempfile", "walkdir", "dirs", "reqwest", "tokio", "memmap2"}

COMMENT_OR_STRING = re.compile(
    r"""//[^\n]*|/\*.*?\*/|b?r(#*)".*?"\1|b?"(?:\\.|[^"\\])*"|b?'(?:\\.[^']*|[^'\\])'""", re.S)


def blank(match):
    """The same number of lines, with nothing in them."""
    return "\n" * match.group(0).count("\n")


def code_only(text):
    """The source without comments, strings and what follows `#[cfg(test)] mod`, line numbers kept."""
    text = COMMENT_OR_STRING.sub(blank, text)
    found = re.search(r"#\[cfg\(test\)\]\s*(?:#\[[^\]]*\]\s*)*(?:pub(?:\([^)]*\))?\s+)?mod\s+\w+\s*\{", text)
    return text if found is None else text[:found.start()]


def worldly_lines(text):
    """(line number, what it asks) of every place in Rust source that asks the world."""
    for number, line in enumerate(code_only(text).splitlines(), 1):
        for pattern, what in WORLD:
            if pattern.search(line):
                yield number, what
                break


def layer(path):
    """The layer of a crate or file: the first folder of its path."""
    return os.path.relpath(path, ROOT).split(os.sep)[0]


ALLOWED = {"kernel": set(), "io": {"kernel"}, "plugins": {"kernel"}, "app": {"kernel", "io", "plugins"}}


def check_arrows(metadata):
    """Problems with who needs whom."""
    members = {p["id"]: p for p in metadata["packages"] if p["id"] in metadata["workspace_members"]}
    where = {p["name"]: layer(p["manifest_path"]) for p in members.values()}
    for package in members.values():
        own = where[package["name"]]
        for dependency in package["dependencies"]:
            name, kind = dependency["name"], dependency["kind"] or "normal"
            if kind == "dev":
                continue
            if own in ("kernel", "io", "plugins") and name in WORLDLY:
                yield "%s (%s/) needs `%s`: nothing below app/ asks the world" % (package["name"], own, name)
            if name not in where or name == package["name"]:
                continue
            if own in ALLOWED and where[name] not in ALLOWED[own]:
                yield "%s (%s/) needs %s (%s/) as a %s dependency; it may need %s" % (
                    package["name"], own, name, where[name], kind, ", ".join(sorted(ALLOWED[own])) or "no other crate")
            elif where[name] in ("tests", "benches"):
                yield "%s needs %s" % (package["name"], name)


def check_sources():
    """Problems with what the sources below app/ ask."""
    for top in ("kernel", "io", "plugins"):
        for folder, folders, files in os.walk(os.path.join(ROOT, top)):
            folders[:] = sorted(f for f in folders if f not in ("target", "tests", "benches", "examples", "fuzz"))
            for name in sorted(files):
                if not name.endswith(".rs") or name in ("tests.rs", "build.rs"):
                    continue
                path = os.path.join(folder, name)
                with open(path, encoding="utf-8") as file:
                    for number, what in worldly_lines(file.read()):
                        yield "%s:%d asks for %s; below app/ only values and bytes go in and out" % (
                            os.path.relpath(path, ROOT), number, what)


PATH = re.compile(r"\bcrate::(\w+)")
GROUP = re.compile(r"\buse\s+crate::\{([^;]*)\}\s*;", re.S)


def named(text, modules):
    """The modules of the crate's top that source names."""
    code = code_only(text)
    found = set(PATH.findall(code))
    for group in GROUP.findall(code):
        depth, word = 0, ""
        for letter in group + ",":
            depth += (letter == "{") - (letter == "}")
            if letter == "," and depth == 0:
                found.add(re.split(r"::|\s", word.strip())[0])
                word = ""
            else:
                word += letter
    return found & modules


def circles(needs):
    """Each circle of a graph once, as a list that ends where it starts; shortest ones from the first of their names."""
    for start in sorted(needs):
        ways, seen = [[start]], {start}
        while ways:
            way = ways.pop(0)
            if start in needs.get(way[-1], ()):
                if start == min(way):
                    yield way + [start]
                break
            for other in sorted(needs.get(way[-1], ())):
                if other not in seen:
                    seen.add(other)
                    ways.append(way + [other])


def check_circles():
    """Problems with modules that need one another."""
    for top in ("kernel", "io", "plugins", "app"):
        for folder, folders, files in os.walk(os.path.join(ROOT, top)):
            folders[:] = sorted(f for f in folders if f not in ("target", "tests", "benches", "examples", "fuzz"))
            if os.path.basename(folder) != "src" or "lib.rs" not in files:
                continue
            modules = {f[:-3] for f in files if f.endswith(".rs")} | set(folders)
            modules -= {"lib", "main", "bin"}
            needs = {}
            for below, inner, names in os.walk(folder):
                inner.sort()
                for name in sorted(names):
                    path = os.path.join(below, name)
                    own = os.path.relpath(path, folder).split(os.sep)[0].removesuffix(".rs")
                    if own in modules and name.endswith(".rs") and name != "tests.rs":
                        with open(path, encoding="utf-8") as file:
                            needs.setdefault(own, set()).update(named(file.read(), modules) - {own})
            for circle in circles(needs):
                yield "%s: modules need one another in a circle: %s" % (
                    os.path.relpath(folder, ROOT), " -> ".join(circle))


def unnamed(text, beside):
    """Those of the files and folders beside a `main.rs` that its text has no module of."""
    modules = set(re.findall(r"^(?:pub\(crate\) )?mod (\w+);", text, re.M))
    return sorted(beside - modules)


def check_tests():
    """Files of tests that no program takes in."""
    for top in ("kernel", "io", "plugins"):
        for folder, folders, files in os.walk(os.path.join(ROOT, top)):
            folders[:] = sorted(f for f in folders if f != "target")
            if os.path.basename(folder) != "tests":
                continue
            sources = {f[:-3] for f in files if f.endswith(".rs")} - {"main"}
            sources |= {f for f in folders if os.path.exists(os.path.join(folder, f, "mod.rs"))}
            if "main.rs" in files:
                with open(os.path.join(folder, "main.rs"), encoding="utf-8") as file:
                    for name in unnamed(file.read(), sources):
                        yield "%s has no module `%s`, which lies beside it" % (
                            os.path.relpath(os.path.join(folder, "main.rs"), ROOT), name)
            elif len(sources) > 1:
                yield "%s holds several programs: name its files in one `main.rs`" % os.path.relpath(folder, ROOT)


def self_test():
    """The checker checked: what must be found is found, what must not is not."""
    guilty = ["use std::fs;", "let t = std::time::Instant::now();", "std::env::var(\"A\")", "use std::{env, fmt};",
              "let x = rand::random::<f64>();", "std::thread::spawn(f);", "x(); // fine\nuse std::process::Command;"]
    innocent = ["// std::fs is for the program", "let s = \"std::fs\";", "/* use std::env; */ fn f() {}",
                "let c = '\"'; let d = \"SystemTime\";", "fn f() {}\n#[cfg(test)]\nmod tests { use std::fs; }",
                "let r = r#\"std::fs \"quoted\" \"#;", "fn instant(brand: u8) {}"]
    for text in guilty:
        assert list(worldly_lines(text)), "not found: " + text
    for text in innocent:
        assert not list(worldly_lines(text)), "wrongly found: " + text

    modules = {"scene", "plugin", "error"}
    text = "use crate::{Point, error::{self, Error}, scene};\nfn f() { crate::plugin::x() } // crate::solve\n"
    assert named(text, modules | {"solve"}) == modules, named(text, modules)
    assert list(circles({"a": {"b"}, "b": {"c"}, "c": {"a"}})) == [["a", "b", "c", "a"]]
    assert not list(circles({"a": {"b", "c"}, "b": {"c"}, "c": set()}))

    assert unnamed("mod a;\npub(crate) mod b;\n// mod c;\n", {"a", "b", "c"}) == ["c"]

    def metadata(own, other, kind=None):
        crates = [("a", own, [{"name": "b", "kind": kind}]), ("b", other, [])]
        return {"workspace_members": ["a", "b"], "packages": [
            {"id": n, "name": n, "manifest_path": os.path.join(ROOT, where, "Cargo.toml"), "dependencies": needs}
            for n, where, needs in crates]}
    for own, other in (("kernel", "io/obj"), ("io/obj", "io/gltf"), ("plugins/fitting", "app"), ("app", "tests")):
        assert list(check_arrows(metadata(own, other))), "not found: %s needs %s" % (own, other)
    for own, other, kind in (("io/obj", "kernel", None), ("app", "io/obj", None), ("io/obj", "io/gltf", "dev")):
        assert not list(check_arrows(metadata(own, other, kind))), "wrongly found: %s needs %s" % (own, other)


def main():
    self_test()
    if "--self-test" in sys.argv[1:]:
        return 0
    cargo = [os.environ.get("CARGO", "cargo"), "metadata", "--no-deps", "--format-version", "1", "--manifest-path",
             os.path.join(ROOT, "Cargo.toml")]
    metadata = json.loads(subprocess.run(cargo, check=True, stdout=subprocess.PIPE).stdout)
    problems = list(check_arrows(metadata)) + list(check_sources()) + list(check_circles()) + list(check_tests())
    for problem in problems:
        print("layers: " + problem)
    if not problems:
        print("layers: %d crates, arrows point one way, no modules in a circle, nothing below app/ asks the world" % len(metadata["workspace_members"]))
    return 1 if problems else 0


if __name__ == "__main__":
    raise SystemExit(main())
