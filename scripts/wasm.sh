#!/usr/bin/env bash
# Finds or installs a compiler for the browser's target, wasm32-unknown-unknown, in this order:
#
#   the installed Rust, where it has the target;
#   rustup, where that can fetch it;
#   Debian testing's rustc and libstd-rust-dev-wasm32, of one version, as plain packages: 200 MB are fetched and unpacked,
#   run by the loader and the libraries that come with them, and link with the installed Rust's rust-lld. Nothing of the
#   system is changed; cargo is the installed one.
#
# The packages go to $LOFTSMAN_WASM, by default ~/.cache/loftsman-wasm (XDG_CACHE_HOME is minded), outside the clone.
# They need a Debian with apt (any release, its own mirror is asked, nobody has to be root) and a C compiler, which
# links what runs while building. What is there and works is left alone, so running it again is cheap.
#
#   scripts/wasm.sh               installs what is missing
#   scripts/wasm.sh --debian      takes the packages even where the installed Rust has the target, or rustup could fetch it
#   scripts/wasm.sh --compiler    prints the rustc to use, and installs nothing; to be used as
#
#       RUSTC=$(scripts/wasm.sh --compiler) cargo check --target wasm32-unknown-unknown --target-dir target/wasm …
set -euo pipefail

target=wasm32-unknown-unknown
folder=${LOFTSMAN_WASM:-${XDG_CACHE_HOME:-$HOME/.cache}/loftsman-wasm}
case "${1:-}" in ''|--debian|--compiler) ;; *) echo "usage: scripts/wasm.sh [--debian | --compiler]" >&2; exit 2;; esac
[ $# -le 1 ] || { echo "usage: scripts/wasm.sh [--debian | --compiler]" >&2; exit 2; }

say() { echo "wasm: $*"; }
fail() { say "$*" >&2; exit 1; }
absent() { say "$*" >&2; exit 69; } # what this machine, or the net, does not have: nothing that we could mend
quiet() { # Runs a command; shows what it printed only if it fails, after a second try (networks hiccup).
  local log; log=$(mktemp)
  if "$@" >"$log" 2>&1 </dev/null || { sleep 5; "$@" >"$log" 2>&1 </dev/null; }; then rm -f "$log"; return 0; fi
  tail -n 20 "$log" >&2; rm -f "$log"; return 1
}
command -v rustc >/dev/null || fail "there is no rustc; install Rust first"
own() { [ -d "$(rustc --print sysroot)/lib/rustlib/$target" ]; }
works() { # works RUSTC: whether it makes a module of a function that needs the standard library
  local trial; trial=$(mktemp -d)
  local status=0
  echo '#[unsafe(no_mangle)] pub extern "C" fn f(n: usize) -> usize { vec![1; n].len() }' >"$trial/f.rs"
  "$1" --edition 2024 --crate-type cdylib --target "$target" -o "$trial/f.wasm" "$trial/f.rs" >"$trial/log" 2>&1 || status=$?
  [ $status = 0 ] || tail -n 5 "$trial/log" >&2
  rm -r "$trial"
  return $status
}

if [ "${1:-}" = --compiler ]; then
  if own; then command -v rustc
  elif [ -x "$folder/rustc" ]; then echo "$folder/rustc"
  else fail "there is no compiler for $target; run scripts/wasm.sh"; fi
  exit 0
fi

if [ "${1:-}" != --debian ]; then
  if own; then say "$(rustc --version) has $target"; exit 0; fi
  if command -v rustup >/dev/null; then
    if answer=$(timeout 120 rustup target add "$target" 2>&1 </dev/null) && own; then say "rustup added $target"; exit 0; fi
    say "rustup cannot add $target: $(tail -n 1 <<<"$answer")"
  fi
fi

mkdir -p "$folder"
exec 9>"$folder/.lock"
if command -v flock >/dev/null; then flock 9; fi # two runs at once do the work once

# A linker that knows the target comes with Rust; `lld` under another name does as well.
linker=$(rustc --print sysroot)/lib/rustlib/$(rustc -vV | sed -n 's/^host: //p')/bin/rust-lld
[ -x "$linker" ] || linker=$(command -v rust-lld || command -v wasm-ld || true)
[ -n "$linker" ] || fail "linking needs rust-lld or wasm-ld, and the installed Rust has none; install lld"

root=$folder/root
wrapper() { # Writes the compiler: Debian's, by the loader and libraries of its own, with that linker.
  local loader libraries
  loader=$(find "$root/usr/lib" "$root/usr/lib64" -name 'ld-linux*.so.*' 2>/dev/null | sort | head -n 1)
  libraries=$(dirname "$(find "$root/usr/lib" -name 'librustc_driver-*.so' | sort | head -n 1)")
  [ -n "$loader" ] || fail "the packages bring no loader"
  cat >"$folder/rustc.new" <<WRAPPER
#!/bin/sh
case " \$* " in *" $target "*|*"=$target "*) set -- -C "linker=$linker" "\$@" ;; esac
exec "$loader" --library-path "$libraries" "$root/usr/bin/rustc" --sysroot "$root/usr" "\$@"
WRAPPER
  chmod +x "$folder/rustc.new"
  # Left alone if nothing changes: cargo compiles everything anew for a compiler that was touched.
  if cmp -s "$folder/rustc.new" "$folder/rustc"; then rm "$folder/rustc.new"; else mv "$folder/rustc.new" "$folder/rustc"; fi
}
if [ -d "$root" ]; then
  wrapper
  if works "$folder/rustc"; then say "$folder is complete: $("$folder/rustc" --version)"; exit 0; fi
  say "$folder does not work; it is made anew"
fi

# An apt of its own: its lists, its cache, its source, all below $folder, at the mirror that the system uses.
for tool in apt-get apt-cache dpkg cc; do
  command -v $tool >/dev/null || absent "$target needs \`rustup target add $target\`, or a Debian with apt and a C compiler: there is no $tool"
done
keys=/usr/share/keyrings/debian-archive-keyring.gpg
[ -f "$keys" ] || absent "Debian's keys are not at $keys; install debian-archive-keyring, or \`rustup target add $target\`"
mirror=$(apt-get indextargets --format '$(REPO_URI)' 2>/dev/null | sed 's|/*$||' | grep -m 1 '/debian$' || true)
[ -n "$mirror" ] || absent "apt knows no Debian mirror here; \`rustup target add $target\` does without"

work=$folder/work
rm -rf "$work"
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/parts" "$work/state/lists/partial" "$work/cache/archives/partial" "$work/packages" "$work/root"
echo "deb [signed-by=$keys] $mirror testing main" >"$work/list"
# What rustc needs to link programs of this machine is taken as installed: it is, from the machine's own release.
cat >"$work/status" <<STATUS
Package: what-links-here
Status: install ok installed
Architecture: $(dpkg --print-architecture)
Version: 1
Maintainer: nobody
Description: gcc, binutils and the C library's headers, as the system has them
Provides: gcc, libc-dev, libc6-dev, binutils (= 99)
STATUS
options=(-q -o "Dir::Etc::SourceList=$work/list" -o "Dir::Etc::SourceParts=$work/parts" -o "Dir::Etc::Preferences=/dev/null"
  -o "Dir::Etc::PreferencesParts=$work/parts" -o "Dir::State=$work/state" -o "Dir::State::status=$work/status"
  -o "Dir::Cache=$work/cache" -o Acquire::Languages=none -o APT::Sandbox::User= -o Acquire::Retries=2)

say "asking Debian testing for rustc and libstd-rust-dev-wasm32"
quiet apt-get "${options[@]}" -o APT::Update::Error-Mode=any update || absent "Debian testing cannot be reached"
plan=$(apt-get "${options[@]}" install --simulate --no-install-recommends rustc libstd-rust-dev-wasm32 2>&1) ||
  absent "Debian testing has no rustc with libstd-rust-dev-wasm32 today: $(tail -n 3 <<<"$plan")"
mapfile -t packages < <(sed -n 's/^Inst \([^ ]*\) (\([^ ]*\) .*/\1=\2/p' <<<"$plan")
version() { printf '%s\n' "${packages[@]}" | sed -n "s/^$1=//p"; }
[ -n "$(version rustc)" ] && [ "$(version rustc)" = "$(version libstd-rust-dev-wasm32)" ] ||
  absent "rustc $(version rustc) and libstd-rust-dev-wasm32 $(version libstd-rust-dev-wasm32) are not of one version"

say "fetching rustc $(version rustc), ${#packages[@]} packages in all"
(cd "$work/packages" && quiet apt-get "${options[@]}" download "${packages[@]}") || absent "the packages cannot be fetched"
for package in "$work"/packages/*.deb; do dpkg -x "$package" "$work/root"; done
rm -rf "$root"
mv "$work/root" "$root"
wrapper
works "$folder/rustc" || fail "what was unpacked does not work"
say "$("$folder/rustc" --version) is in $folder"
