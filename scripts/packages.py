#!/usr/bin/env python3
"""Checks what a registry asks of each published crate, and what a person finds there, from `cargo metadata`:

1. A description, a license whose files lie beside the manifest (links to those at the top, so that a package carries them), 1 to 5
   keywords and 1 to 5 categories that exist, authors, the oldest Rust.
2. A README that links to the main one; each Rust example in it is, line for line, an example of the crate's documentation, which
   `cargo test` runs.
3. Crates of this workspace are needed with a version, of the one they have, and they can be published one after the other.

    python3 scripts/packages.py               checks the repository it is in; exit 0 clean, 1 not, with the places
    python3 scripts/packages.py --order       prints the crates in an order in which they can be published
    python3 scripts/packages.py --self-test   checks that it finds what it looks for
"""
import copy
import json
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

# Of the registry's categories those that fit a geometry kernel; any other is a slip, or to be added here.
CATEGORIES = {"algorithms", "command-line-utilities", "encoding", "graphics", "mathematics", "parser-implementations", "rendering",
              "rendering::data-formats", "science", "simulation", "visualization", "wasm"}
LICENSES = {"MIT": "LICENSE-MIT", "Apache-2.0": "LICENSE-APACHE", "Bitstream-Vera": "font/LICENSE-DejaVu"}
KEYWORD = re.compile(r"[A-Za-z0-9][A-Za-z0-9_+-]{0,19}\Z")
SHOWN = re.compile(r"^```rust\n(.*?)^```$", re.S | re.M)


def text_of(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def documented(text):
    """The Rust examples in the doc comments of a source, as a reader sees them: without lines that `# ` hides."""
    example = None
    for line in text.splitlines():
        found = re.match(r"\s*//[/!] ?(.*)", line)
        if found is None:
            example = None
        elif found.group(1).startswith("```"):
            if example is not None and example[0]:
                yield "\n".join(example[1])
            language = found.group(1)[3:]
            example = None if example is not None else (language in ("", "rust", "standalone_crate"), [])
        elif example is not None and not re.match(r"#( |$)", found.group(1)):
            example[1].append(found.group(1))


def sources(folder):
    for top, folders, files in os.walk(os.path.join(folder, "src")):
        folders.sort()
        for name in sorted(files):
            if name.endswith(".rs"):
                yield text_of(os.path.join(top, name))


def readme_problems(folder, readme):
    """Problems with what the README of the crate in `folder` says."""
    link = os.path.relpath(os.path.join(ROOT, "README.md"), folder).replace(os.sep, "/")
    if "](%s)" % link not in readme:
        yield "its README does not link to the main one, as (%s)" % link
    if not 5 <= len(readme.splitlines()) <= 40:
        yield "its README has %d lines: 5 to 40 are read" % len(readme.splitlines())
    tested = set(example for text in sources(folder) for example in documented(text))
    for example in SHOWN.findall(readme):
        if example.rstrip("\n") not in tested:
            yield "an example in its README is none of its documentation, so nobody tests it: %r…" % example[:60]


def license_problems(folder, expression):
    for name in re.findall(r"[\w.+-]+", expression):
        if name in ("AND", "OR", "WITH"):
            continue
        file = LICENSES.get(name)
        path = os.path.join(folder, file or "")
        if file is None or not os.path.isfile(path):
            yield "the text of its license %s is not beside its manifest (%s)" % (name, file or "LICENSES does not know it")
        elif os.path.isfile(os.path.join(ROOT, file)) and text_of(path) != text_of(os.path.join(ROOT, file)):
            yield "its %s is not the one at the top" % file


def crate_problems(package, published):
    """What a registry or a person would miss of one crate."""
    folder = os.path.dirname(package["manifest_path"])
    for field in ("description", "license", "readme", "keywords", "categories", "authors", "rust_version"):
        if not package[field]:
            yield "it has no %s" % field
    for field in ("keywords", "categories"):
        if len(package[field]) > 5 or len(set(package[field])) < len(package[field]):
            yield "its %s are more than 5, or not different" % field
    for word in package["keywords"]:
        if not KEYWORD.match(word):
            yield "`%s` is no keyword: letters, digits, - _ +, 20 at most" % word
    for category in package["categories"]:
        if category not in CATEGORIES:
            yield "`%s` is no category that scripts/packages.py knows" % category
    if package["license"]:
        yield from license_problems(folder, package["license"])
    if package["readme"]:
        path = os.path.join(folder, package["readme"])
        if os.path.isfile(path):
            yield from readme_problems(folder, text_of(path))
        else:
            yield "its %s is not there" % package["readme"]
    for needed in package["dependencies"]:
        if needed.get("path") is None:
            continue
        other = published.get(needed["name"])
        # Cargo leaves what only tests need, and no version is asked of, out of the package.
        if other is None and needed["kind"] == "dev" and needed["req"] == "*":
            continue
        if other is None:
            yield "it needs %s, which is not published" % needed["name"]
        elif needed["req"] != "^" + other["version"]:
            yield "it needs %s %s, which is %s: give the version beside the path" % (needed["name"], needed["req"], other["version"])


def order(published):
    """(names in an order in which each finds what it needs, also for its tests; names that need one another)"""
    left = {name: {d["name"] for d in p["dependencies"] if d["name"] in published and d["name"] != name}
            for name, p in published.items()}
    done = []
    while True:
        ready = sorted(name for name, needs in left.items() if needs <= set(done))
        if not ready:
            return done, sorted(left)
        done += ready
        left = {name: needs for name, needs in left.items() if name not in ready}


def published_of(metadata):
    return {p["name"]: p for p in metadata["packages"]
            if p["id"] in metadata["workspace_members"] and p["publish"] != []}


def problems(published):
    for name in sorted(published):
        for problem in crate_problems(published[name], published):
            yield "%s: %s" % (name, problem)
    circle = order(published)[1]
    if circle:
        yield "none of these can be published before the others: %s" % ", ".join(circle)


def self_test(published):
    """The checker checked, on what is there, spoilt: each slip is found."""
    def spoilt(name, **fields):
        changed = copy.deepcopy(published)
        changed[name].update(fields)
        return set(problems(changed)) - clean
    clean, kernel = set(problems(published)), "loftsman-kernel"
    circular = [{"name": "loftsman", "req": "^" + published["loftsman"]["version"], "path": "/", "kind": None}]
    private = [{"name": "of-tests-only", "req": "*", "path": "/", "kind": None}]
    unversioned = [{"name": kernel, "req": "*", "path": "/", "kind": None}]
    for name, fields in ((kernel, {"description": None}), (kernel, {"license": "MIT OR Zlib"}), (kernel, {"readme": None}),
                         (kernel, {"readme": "nowhere.md"}), (kernel, {"keywords": list("abcdef")}), (kernel, {"keywords": ["two words"]}),
                         (kernel, {"categories": ["shipyards"]}), (kernel, {"dependencies": circular}),
                         ("loftsman", {"dependencies": unversioned}), ("loftsman", {"dependencies": private})):
        assert spoilt(name, **fields), "not found: %s %s" % (name, fields)
    source = "//! ```\n//! let a = 1;\n//! # hidden();\n//! ```\nfn f() {}\n/// ```text\n/// no Rust\n/// ```\n"
    assert list(documented(source)) == ["let a = 1;"], list(documented(source))
    folder = os.path.dirname(published[kernel]["manifest_path"])
    for readme in ("# a\n\nb\n\nc\n", "# a\n\n```rust\nnobody_tests(this);\n```\n[b](../README.md)\n"):
        assert list(readme_problems(folder, readme)), "not found: " + readme


def main():
    cargo = [os.environ.get("CARGO", "cargo"), "metadata", "--no-deps", "--format-version", "1", "--manifest-path",
             os.path.join(ROOT, "Cargo.toml")]
    published = published_of(json.loads(subprocess.run(cargo, check=True, stdout=subprocess.PIPE).stdout))
    self_test(published)
    if "--self-test" in sys.argv[1:]:
        return 0
    found = list(problems(published))
    for problem in found:
        print("packages: " + problem)
    if found:
        return 1
    if "--order" in sys.argv[1:]:
        print("\n".join(order(published)[0]))
    else:
        print("packages: %d crates have what a registry asks, and can be published one after the other" % len(published))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
