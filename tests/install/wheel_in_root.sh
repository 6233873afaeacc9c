#!/usr/bin/env bash
# Installs a wheel in a bare root of a Debian release and compares its clouds with the program's:
#   wheel_in_root.sh RELEASE WHEEL PROGRAM [SCAN...]
# As root. SCAN: scan folders besides a virtual one.
set -euo pipefail
release=$1 wheel=$(realpath "$2") program=$(realpath "$3")
shift 3
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
debootstrap --variant=minbase --include=python3-numpy,python3-pip "$release" "$root" >/dev/null
mkdir "$root/scans"
"$program" simulate "$root/scans/virtual" >/dev/null
for scan in "$@"; do cp -rL "$scan" "$root/scans/$(basename "$scan")"; done
cp "$wheel" "$root"

inside() {
  # The loader finds a program's own folder by /proc.
  # shellcheck disable=SC2016
  unshare --mount sh -c 'mount -t proc proc "$0/proc"; exec chroot "$0" "$@"' "$root" \
    env -i HOME=/root PATH=/usr/local/bin:/usr/bin:/bin "$@"
}
# shellcheck disable=SC2016
inside sh -c 'python3 -m pip install -q --no-index --root-user-action ignore \
  $(python3 -m pip install --help | grep -o -m 1 -e --break-system-packages) /*.whl'
inside slipstream --version
inside slipstream demo /demo >/dev/null
for scan in "$root"/scans/*/; do
  name=$(basename "$scan")
  "$program" reconstruct "$scan" -o "$root/expected.ply" >/dev/null
  inside slipstream reconstruct "/scans/$name" -o /program.ply >/dev/null
  inside python3 -c "import slipstream
slipstream.reconstruct(slipstream.load_scan('/scans/$name')).write('/module.ply')"
  cmp "$root/expected.ply" "$root/program.ply"
  cmp "$root/expected.ply" "$root/module.ply"
  echo "$release, $name: $(stat -c %s "$root/expected.ply") bytes, the same by program and module"
done
