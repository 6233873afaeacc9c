#!/usr/bin/env python3
"""Writes the bill of materials of each tarball and wheel in a folder: NAME.spdx.json, SPDX 2.3.

bill.py FOLDER

A bundle holds the copyright file of each Debian package that it packs or that is compiled into it.
The bill lists these packages with their versions on this system and the licences that the file
names. A file describes a whole source, so that some licences are of parts that are not packed.
"""

import datetime
import hashlib
import json
import os
import pathlib
import re
import subprocess
import sys
import tarfile
import zipfile

# Debian's short names, in lower case, of licences that SPDX names otherwise.
NAMES = {
    "apache-2": "Apache-2.0", "apache-2.0": "Apache-2.0", "bsd-2-clause": "BSD-2-Clause",
    "bsd-3-clause": "BSD-3-Clause", "bsl-1.0": "BSL-1.0", "cc0-1.0": "CC0-1.0", "expat": "MIT",
    "isc": "ISC", "mit": "MIT", "mpl-2.0": "MPL-2.0", "ntp": "NTP", "zlib": "Zlib", "x11": "X11"}

CHOLMOD = (
    "Debian builds CHOLMOD with modules (Supernodal, MatrixOps, Modify) under GPL-2.0-or-later; the "
    "rest is under LGPL-2.1-or-later. Debian's Ceres calls CHOLMOD whatever solver is chosen, so the "
    "bundle cannot be made without it. As a whole it is under the terms of the GPL, version 3, which "
    "Apache-2.0 allows. A build with -DSLIPSTREAM_CALIBRATE=OFF has neither.")


def spdx_name(licence):
    """The SPDX identifier of one of Debian's short names, None if it has none."""
    name = licence.strip().lower()
    if name in NAMES:
        return NAMES[name]
    if found := re.fullmatch(r"(l?gpl)-([123])(?:\.(\d))?(\+?)", name):
        kind, major, minor, later = found.groups()
        return f"{kind.upper()}-{major}.{minor or 0}-{'or-later' if later else 'only'}"
    return None


def licences_in(copyright_file):
    """The licences that a machine-readable copyright file names, without those of packaging."""
    names = []
    for paragraph in re.split(r"\n\s*\n", copyright_file):
        files = re.search(r"^Files:\s*(.*(?:\n[ \t].*)*)", paragraph, re.M)
        licence = re.search(r"^License:[ \t]*(\S.*)", paragraph, re.M)
        if not files or not licence or all(f.startswith("debian/") for f in files[1].split()):
            continue
        names += [n.strip() for n in re.split(r"\s+and\s+|,", licence[1], flags=re.I) if n.strip()]
    return sorted(set(names))


def version_of(package):
    query = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", package], text=True,
                           stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    return query.stdout


def described(package, copyright_file):
    """The SPDX package, and the text of its licence if SPDX has no identifier for each."""
    names = licences_in(copyright_file)
    known = [spdx_name(name) for name in names]
    reference = "LicenseRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", package)
    has_names = bool(known) and None not in known
    entry = {
        "name": package, "SPDXID": reference.replace("LicenseRef", "SPDXRef"),
        "supplier": "Organization: Debian", "downloadLocation": "NOASSERTION",
        "filesAnalyzed": False, "licenseConcluded": "NOASSERTION",
        "licenseDeclared": " AND ".join(sorted(set(known))) if has_names else reference,
        "licenseComments": "named in its copyright file: " + (", ".join(names) or "see its text"),
        "copyrightText": "NOASSERTION"}
    if version := version_of(package):
        entry["versionInfo"] = version
        entry["externalRefs"] = [{
            "referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
            "referenceLocator": f"pkg:deb/debian/{package}@{version.replace('+', '%2B')}"}]
    if package.startswith("libcholmod"):
        entry["comment"] = CHOLMOD
    text = None if has_names else {"licenseId": reference, "name": f"licences of {package}",
                                   "extractedText": copyright_file}
    return entry, text


def copyright_files(archive):
    """By the name of their package, as the bundle holds them."""
    if archive.suffix == ".whl":
        with zipfile.ZipFile(archive) as opened:
            names = [n for n in opened.namelist() if ".dist-info/licenses/" in n]
            files = {n: opened.read(n) for n in names}
    else:
        with tarfile.open(archive) as opened:
            members = [m for m in opened.getmembers() if m.isfile() and "/licences/" in m.name]
            files = {m.name: opened.extractfile(m).read() for m in members}
    return {pathlib.PurePath(n).name: b.decode(errors="replace") for n, b in sorted(files.items())}


def bill_of(archive):
    digest = hashlib.sha256(archive.read_bytes()).hexdigest()
    built = datetime.datetime.fromtimestamp(int(os.environ.get("SOURCE_DATE_EPOCH", "315532800")),
                                            datetime.timezone.utc)
    bundle = {"name": archive.name, "SPDXID": "SPDXRef-bundle", "downloadLocation": "NOASSERTION",
              "filesAnalyzed": False, "licenseConcluded": "NOASSERTION",
              "licenseDeclared": "Apache-2.0", "copyrightText": "2026 The authors of slipstream",
              "comment": "the licence is of slipstream's own files",
              "checksums": [{"algorithm": "SHA256", "checksumValue": digest}]}
    packages, texts = [], []
    for package, copyright_file in copyright_files(archive).items():
        if package == "slipstream":
            continue
        entry, text = described(package, copyright_file)
        packages.append(entry)
        texts += [text] if text else []
    relations = [("SPDXRef-DOCUMENT", "DESCRIBES", "SPDXRef-bundle")]
    relations += [("SPDXRef-bundle", "CONTAINS", entry["SPDXID"]) for entry in packages]
    return {
        "spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
        "name": archive.name,
        "documentNamespace": f"https://spdx.org/spdxdocs/{archive.name}-{digest}",
        "creationInfo": {"created": built.strftime("%Y-%m-%dT%H:%M:%SZ"),
                         "creators": ["Tool: packaging/bill.py"]},
        "packages": [bundle, *packages], "hasExtractedLicensingInfos": texts,
        "relationships": [{"spdxElementId": one, "relationshipType": kind,
                           "relatedSpdxElement": other} for one, kind, other in relations]}


def main(folder):
    for archive in sorted([*folder.glob("*-linux-*.tar.xz"), *folder.glob("*.whl")]):
        path = archive.with_name(archive.name + ".spdx.json")
        path.write_text(json.dumps(bill_of(archive), indent=1) + "\n")
        print(path)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
